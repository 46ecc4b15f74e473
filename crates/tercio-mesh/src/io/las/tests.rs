//! Extra bytes: what descriptions make of them, in LAS and LAZ, and descriptions that are wrong.

use std::io::Cursor;

use las::point::Format;
use las::{Builder, Point, Version, Vlr, Writer};

use crate::ReadError;
use crate::io::input::Input;
use crate::io::{ReadModel, ReadOptions, read_input};

/// What a description has besides its name and its type: the options, and the first values of no data, scale and offset.
#[derive(Clone, Copy, Default)]
struct Has {
    options: u8,
    no_data: [u8; 8],
    scale: f64,
    offset: f64,
}

const NO_DATA: u8 = 1;
const SCALE: u8 = 8;
const OFFSET: u8 = 16;

fn description(name: &str, kind: u8, has: Has) -> Vec<u8> {
    let mut all = vec![0; 192];
    (all[2], all[3]) = (kind, has.options);
    all[4..4 + name.len()].copy_from_slice(name.as_bytes());
    all[40..48].copy_from_slice(&has.no_data);
    all[112..120].copy_from_slice(&has.scale.to_le_bytes());
    all[136..144].copy_from_slice(&has.offset.to_le_bytes());
    all
}

/// A file with points that have these extra bytes, described before them.
fn file(format: u8, is_packed: bool, descriptions: Vec<u8>, points: &[Vec<u8>]) -> Vec<u8> {
    file_with(format, is_packed, |builder, record| builder.vlrs.push(record(descriptions)), points)
}

/// The same with records of its own, whose content are descriptions.
fn file_with(
    format: u8,
    is_packed: bool,
    describe: impl FnOnce(&mut Builder, &dyn Fn(Vec<u8>) -> Vlr),
    points: &[Vec<u8>],
) -> Vec<u8> {
    let mut builder = Builder::from(Version::new(1, 4));
    builder.point_format = Format::new(format).expect("a format");
    builder.point_format.is_compressed = is_packed;
    builder.point_format.extra_bytes = points[0].len() as u16;
    describe(&mut builder, &|data| {
        let (user_id, description) = ("LASF_Spec".to_owned(), String::new());
        Vlr { user_id, record_id: 4, description, data }
    });
    let layout = builder.point_format;
    let header = builder.into_header().expect("a header");
    let mut writer = Writer::new(Cursor::new(Vec::new()), header).expect("a writer");
    for (i, extra_bytes) in points.iter().enumerate() {
        let gps_time = layout.has_gps_time.then_some(1.0);
        let color = layout.has_color.then(las::Color::default);
        let extra_bytes = extra_bytes.clone();
        let point = Point { x: i as f64, gps_time, color, extra_bytes, ..Point::default() };
        writer.write_point(point).expect("written");
    }
    writer.close().expect("closed");
    writer.into_inner().expect("a file").into_inner()
}

fn read(bytes: Vec<u8>) -> Result<ReadModel, ReadError> {
    let options = ReadOptions::default();
    read_input(&Input::from_bytes("a", bytes, &options)?, &options)
}

/// Names and values of the attributes of extra bytes. Those that every file has come first.
fn extra(model: &ReadModel, format: u8) -> Vec<(String, Vec<f64>)> {
    let others = if format == 0 { 5 } else { 6 };
    let of_extra = model.strokes.attributes.iter().skip(others);
    of_extra.map(|a| (a.name.clone(), a.values.iter().map(|&v| a.full(v)).collect())).collect()
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b || a.is_nan() && b.is_nan())
}

#[test]
fn described_extra_bytes_are_attributes() {
    let none = Has::default();
    let scaled = Has { options: SCALE | OFFSET | NO_DATA, no_data: [0xff; 8], scale: 0.25, offset: -10.0 };
    let missing = Has { options: NO_DATA, no_data: (-9999.9f64).to_le_bytes(), ..none };
    let descriptions = [
        // A scale counts only with its option.
        description("Amplitude", 3, Has { scale: 0.5, ..none }),
        description("not documented", 0, Has { options: 2, ..none }),
        // All bits set are -1 of signed numbers.
        description("Reflectance", 4, scaled),
        description("Deviation", 9, missing),
        description("id", 7, none),
        // Two signed bytes, which the specification no longer has.
        description("pair", 12, none),
        description("", 10, none),
    ]
    .concat();
    let point = |a: u16, r: i16, d: f32, id: u64, pair: [i8; 2], real: f64| {
        let pair = pair.map(|v| v as u8);
        let parts: [&[u8]; 7] = [
            &a.to_le_bytes(),
            &[77, 78],
            &r.to_le_bytes(),
            &d.to_le_bytes(),
            &id.to_le_bytes(),
            &pair,
            &real.to_le_bytes(),
        ];
        parts.concat()
    };
    let large = 1 << 40;
    let points = [
        point(1000, 8, 0.5, large, [-3, 4], 1.5),
        point(65535, -1, -9999.9, large + 1, [5, -128], f64::NAN),
        point(0, -2, 2.0, large + 7, [0, 0], -8.0),
    ];
    let large = large as f64;
    let expected: [(&str, [f64; 3]); 7] = [
        ("Amplitude", [1000.0, 65535.0, 0.0]),
        ("Reflectance", [-8.0, f64::NAN, -10.5]),
        ("Deviation", [0.5, f64::NAN, 2.0]),
        ("id", [large, large + 1.0, large + 7.0]),
        ("pair:0", [-3.0, 5.0, 0.0]),
        ("pair:1", [4.0, -128.0, 0.0]),
        ("extra_7", [1.5, f64::NAN, -8.0]),
    ];
    for (format, is_packed) in [(0, false), (0, true), (6, false), (6, true), (7, true)] {
        let model = read(file(format, is_packed, descriptions.clone(), &points)).expect("a model");
        let found = extra(&model, format);
        assert_eq!(found.len(), expected.len(), "{format} {is_packed}: {found:?}");
        for ((name, values), (expected_name, expected)) in found.iter().zip(expected) {
            assert_eq!(name, expected_name);
            assert!(is_same(values, &expected), "{format} {is_packed} {name}: {values:?}");
        }
        assert_eq!(model.report.warnings, ["left out 2 extra bytes of every point"]);
    }
}

/// Layers are decompressed only where they are described: those between others are passed over, in several chunks.
#[test]
fn layers_between_others_are_left_out() {
    let not_documented = |bytes| description("", 0, Has { options: bytes, ..Has::default() });
    let descriptions = [
        not_documented(3),
        description("first", 5, Has::default()),
        not_documented(1),
        description("second", 1, Has::default()),
    ]
    .concat();
    let number = |i: u32| i.wrapping_mul(2_654_435_761) >> 4;
    let point = |i: u32| [&[i as u8, 0, 9], &number(i).to_le_bytes()[..], &[i as u8], &[7], &[5]].concat();
    let points: Vec<Vec<u8>> = (0..60_000).map(point).collect();
    for format in [1, 6] {
        let model = read(file(format, true, descriptions.clone(), &points)).expect("a model");
        let found = extra(&model, format);
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["first", "second"]);
        let first: Vec<f64> = (0..60_000).map(|i| f64::from(number(i))).collect();
        let error = found[0].1.iter().zip(&first).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Of numbers up to 2^28 that are spread over all of them, f32 rounds away 8.
        assert!(error <= 8.0, "{format}: {error}");
        assert!(found[1].1.iter().all(|&v| v == 7.0), "{format}");
        let left_out = "left out 5 extra bytes of every point".to_owned();
        assert!(model.report.warnings.contains(&left_out), "{:?}", model.report.warnings);
    }
}

/// What follows a wrong description is left out, with a warning: the points are drawn.
#[test]
fn wrong_descriptions_are_warned_of() {
    let points = [vec![1, 2, 3, 4]];
    let of = |descriptions: Vec<u8>| {
        let model = read(file(0, false, descriptions, &points)).expect("a model");
        assert_eq!(model.strokes.points, [0]);
        let names: Vec<String> = extra(&model, 0).into_iter().map(|(name, _)| name).collect();
        (names, model.report.warnings)
    };
    // The head of a record of variable length is behind the header.
    let warning = |at: usize, what: &str| {
        let place = 375 + 54 + at;
        format!("byte {place}: {what}: extra bytes that this and what follows describe are left out")
    };
    let left_out = |bytes: usize| format!("left out {bytes} extra bytes of every point");
    let none = Has::default();
    let all = || description("a", 1, none);
    let expected = warning(0, "expected descriptions of extra bytes of 192 bytes each, found 191 bytes");
    assert_eq!(of(vec![0; 191]), (vec![], vec![expected, left_out(4)]));
    let cut = [all(), vec![0; 9]].concat();
    let expected = warning(0, "expected descriptions of extra bytes of 192 bytes each, found 201 bytes");
    assert_eq!(of(cut), (vec!["a".to_owned()], vec![expected, left_out(3)]));
    let too_many = [description("a", 3, none), description("b", 6, none), all()].concat();
    let expected = "expected descriptions of at most 4 extra bytes, found one of the bytes 2 to 6";
    assert_eq!(of(too_many), (vec!["a".to_owned()], vec![warning(192, expected), left_out(2)]));
    for (wrong, at, expected) in [
        (description("a", 31, none), 2, "expected a data type of 0 to 30, found 31"),
        (description("a", 1, Has { options: SCALE, ..none }), 112, "expected a scale other than 0, found 0"),
        (
            description("a", 1, Has { options: OFFSET, offset: f64::INFINITY, ..none }),
            136,
            "expected a finite offset, found inf",
        ),
    ] {
        let found = of([all(), wrong, all()].concat());
        assert_eq!(found, (vec!["a".to_owned()], vec![warning(192 + at, expected), left_out(3)]));
    }
}

/// An offset beside which all points are one is an error, which names it; and so is a scale with which they are nowhere.
#[test]
fn offsets_that_are_too_large_are_refused() {
    let bytes = file(0, false, Vec::new(), &[vec![7], vec![9]]);
    for (offset, scale, is_good) in [
        (4.2e6, 0.001, true),
        (-1e12, 1e-3, true),
        (1e308, 0.001, false),
        (-1e30, 0.001, false),
        (1.7e308, 1e298, false),
        (0.0, 1e300, false),
        (1e308, 1e299, false),
    ] {
        let mut changed = bytes.clone();
        changed[139..147].copy_from_slice(&f64::to_le_bytes(scale));
        changed[163..171].copy_from_slice(&f64::to_le_bytes(offset));
        match read(changed) {
            Ok(_) => assert!(is_good, "{offset} {scale}"),
            Err(error) => {
                let error = error.to_string();
                let (what, found) = if scale > 1e298 { ("a scale", scale) } else { ("an offset", offset) };
                let [what, found] = [format!("{what} of y"), format!("found {found:e}")];
                assert!(!is_good && error.contains(&what) && error.contains(&found), "{error}");
            }
        }
    }
}

/// Names of descriptions that are those of other data are numbered.
#[test]
fn names_are_used_once() {
    let of = |name| description(name, 1, Has::default());
    let bytes = file(0, false, [of("intensity"), of("a"), of("a"), of("a")].concat(), &[vec![7, 8, 9, 10]]);
    let found = extra(&read(bytes).expect("a model"), 0);
    let expected = [("intensity_2", 7.0), ("a", 8.0), ("a_2", 9.0), ("a_3", 10.0)];
    assert_eq!(found, expected.map(|(name, value)| (name.to_owned(), vec![value])));
}

/// Descriptions are also found behind the points, behind another record there; those before the points come first.
#[test]
fn descriptions_in_extended_records_are_read() {
    let of = |name| description(name, 1, Has::default());
    for is_packed in [false, true] {
        for is_before in [false, true] {
            let describe = |builder: &mut Builder, record: &dyn Fn(Vec<u8>) -> Vlr| {
                let other = Vlr { record_id: 7, ..record(vec![1; 100_000]) };
                builder.evlrs.extend([other, record(of("behind"))]);
                builder.vlrs.extend(is_before.then(|| record(of("before"))));
            };
            let bytes = file_with(6, is_packed, describe, &[vec![7], vec![9]]);
            let name = if is_before { "before" } else { "behind" };
            let model = read(bytes.clone()).expect("a model");
            assert_eq!(extra(&model, 6), [(name.to_owned(), vec![7.0, 9.0])]);
            assert_eq!(model.report.warnings, Vec::<String>::new());
            // One that is cut off is none.
            let cut = read(bytes[..bytes.len() - 1].to_vec()).expect("a model");
            assert_eq!(extra(&cut, 6).len(), usize::from(is_before));
        }
    }
}
