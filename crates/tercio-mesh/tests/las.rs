//! LAS and LAZ written by the crate `las`, in every point format that it writes, and what is wrong with files that are cut or
//! changed.

use std::io::Cursor;

use las::point::{Classification, Format};
use las::{Builder, Color, Point, Transform, Vector, Version, Writer};
use tercio_mesh::ReadError;
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadModel, ReadOptions, read_input};

fn try_read(bytes: &[u8]) -> Result<ReadModel, ReadError> {
    let options = ReadOptions { memory_limit: Some(256 << 20), ..ReadOptions::default() };
    read_input(&Input::from_bytes("a", bytes.to_vec(), &options)?, &options)
}

fn point(i: u32, format: &Format) -> Point {
    let v = f64::from(i);
    let color = Color::new((i * 257 % 65536) as u16, 65535 - (i % 60_000) as u16, 256);
    Point {
        x: 690_000.0 + (v * 0.37).sin() * 50.0,
        y: 5_335_000.0 - v * 0.01,
        z: 500.0 + (v * 0.11).cos(),
        intensity: (i * 7 % 65536) as u16,
        return_number: (i % 3 + 1) as u8,
        number_of_returns: 3,
        classification: Classification::new((i % 7) as u8 + 1).unwrap_or_default(),
        point_source_id: 42,
        gps_time: format.has_gps_time.then_some(3e8 + v * 0.5),
        color: format.has_color.then_some(color),
        nir: format.has_nir.then_some((i % 1000) as u16),
        ..Point::default()
    }
}

fn file(format: u8, packed: bool, count: u32, change: impl Fn(&mut Point)) -> Vec<u8> {
    file_of(Format::new(format).unwrap(), packed, count, change)
}

fn file_of(format: Format, packed: bool, count: u32, change: impl Fn(&mut Point)) -> Vec<u8> {
    let mut builder = Builder::from(Version::new(1, 4));
    builder.point_format = format;
    builder.point_format.is_compressed = packed;
    let transform = |offset| Transform { scale: 0.001, offset };
    builder.transforms = Vector { x: transform(690_000.0), y: transform(5_335_000.0), z: transform(0.0) };
    let layout = builder.point_format;
    let mut writer = Writer::new(Cursor::new(Vec::new()), builder.into_header().unwrap()).unwrap();
    for i in 0..count {
        let mut point = point(i, &layout);
        change(&mut point);
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
    writer.into_inner().unwrap().into_inner()
}

#[test]
fn every_format_gives_the_points_that_were_written() {
    for format in [0u8, 1, 2, 3, 6, 7, 8] {
        for packed in [false, true] {
            // Two chunks of LASzip.
            let count = if packed { 60_000 } else { 3000 };
            let bytes = file(format, packed, count, |_| {});
            let model = try_read(&bytes).unwrap_or_else(|e| panic!("{format}: {e}"));
            let layout = Format::new(format).unwrap();
            let strokes = &model.strokes;
            assert_eq!(strokes.points.len(), count as usize);
            let kind = if packed { "LAZ" } else { "LAS" };
            assert_eq!(model.report.format, format!("{kind} 1.4, point format {format}"));
            let values = |name: &str| strokes.attributes.iter().find(|a| a.name == name).map(|a| &a.values);
            for i in (0..count).step_by(97).chain([count - 1]) {
                let (of_file, p) = (point(i, &layout), strokes.position(i));
                let off = [p.x - of_file.x, p.y - of_file.y, p.z - of_file.z];
                assert!(off.iter().all(|d| d.abs() < 5.1e-4), "{format} {i}: {off:?}");
                let value = |name: &str| f64::from(values(name).unwrap()[i as usize]);
                assert_eq!(value("intensity"), f64::from(of_file.intensity));
                assert_eq!(value("classification"), f64::from(u8::from(of_file.classification)));
                assert_eq!(value("return_number"), f64::from(of_file.return_number));
                assert_eq!(value("number_of_returns"), 3.0);
                assert_eq!(value("point_source_id"), 42.0);
                if layout.has_gps_time {
                    let times = strokes.attributes.iter().find(|a| a.name == "gps_time").unwrap();
                    assert_eq!(times.full(times.values[i as usize]), 3e8 + 0.5 * f64::from(i));
                }
                if layout.has_nir {
                    assert_eq!(value("nir"), f64::from(of_file.nir.unwrap()));
                }
                let color = of_file.color.map(|c| [c.red, c.green, c.blue].map(|c| (c >> 8) as u8));
                assert_eq!(strokes.color(i), color.map(|[r, g, b]| [r, g, b, 255]), "{format} {i}");
            }
            assert_eq!(values("gps_time").is_some(), layout.has_gps_time);
        }
    }
}

/// More bytes of a point are passed over: those of layers at once, whether a layer has bytes (every third one here) or stands for bytes
/// that do not change.
#[test]
fn more_bytes_of_points_change_nothing() {
    const COUNT: u32 = 400;
    for format in [1u8, 6, 7, 8] {
        let plain = try_read(&file(format, true, COUNT, |_| {})).unwrap_or_else(|e| panic!("{format}: {e}"));
        let layout = Format { extra_bytes: 300, ..Format::new(format).unwrap() };
        let bytes = file_of(layout, true, COUNT, |point| {
            let changing = point.intensity as u8;
            point.extra_bytes = (0..300).map(|k| if k % 3 == 0 { changing ^ k as u8 } else { 7 }).collect();
        });
        let model = try_read(&bytes).unwrap_or_else(|e| panic!("{format}: {e}"));
        assert_eq!(model.strokes.positions, plain.strokes.positions, "{format}");
        assert_eq!(model.strokes.colors, plain.strokes.colors, "{format}");
        assert_eq!(model.strokes.attributes, plain.strokes.attributes, "{format}");
    }
}

#[test]
fn colours_of_8_bits_are_told_apart_and_black_ones_are_none() {
    let color = |c: Color| {
        let bytes = file(2, false, 10, |point| point.color = Some(c));
        try_read(&bytes).unwrap().strokes.color(0)
    };
    assert_eq!(color(Color::new(255, 7, 0)), Some([255, 7, 0, 255]));
    assert_eq!(color(Color::new(65280, 256, 255)), Some([255, 1, 0, 255]));
    assert_eq!(color(Color::new(0, 0, 0)), None);
}

#[test]
fn damaged_files_give_errors() {
    for (format, packed) in [(3, false), (3, true), (7, false), (7, true)] {
        let bytes = file(format, packed, 300, |_| {});
        for cut in (0..bytes.len()).step_by(53).filter(|&cut| cut < bytes.len() - 60) {
            let error = match try_read(&bytes[..cut]) {
                Err(error) => error.to_string(),
                // Behind the points, which is what counts.
                Ok(model) => {
                    assert_eq!(model.strokes.points.len(), 300);
                    continue;
                }
            };
            assert!(error.starts_with("a: "), "{error}");
        }
        for at in (0..bytes.len()).filter(|at| *at < 600 || at % 11 == 0) {
            for value in [0, 0xff, 0x7f] {
                let mut changed = bytes.clone();
                changed[at] = value;
                let _ = try_read(&changed);
            }
        }
    }
    let bytes = file(1, false, 300, |_| {});
    let error = try_read(&bytes[..bytes.len() - 1]).unwrap_err().to_string();
    let begin = u32::from_le_bytes(bytes[96..100].try_into().unwrap());
    assert_eq!(
        error,
        format!("a: byte {begin}: expected 300 points in 8400 bytes, found 8399 bytes of them")
    );
    let limit = ReadOptions { memory_limit: Some(15_000), ..ReadOptions::default() };
    let input = Input::from_bytes("a", bytes, &ReadOptions::default()).unwrap();
    assert!(matches!(read_input(&input, &limit), Err(ReadError::MemoryLimit { .. })));
}

/// Each item has a decompressor of some kilobytes, also one of no bytes.
#[test]
fn more_items_than_a_point_can_have_are_refused() {
    let mut bytes = file(0, true, 100, |_| ());
    let id = b"laszip encoded";
    let vlr = bytes.windows(id.len()).position(|w| w == id).expect("a record of LASzip") - 2;
    let record = vlr + 54;
    let of_32 = |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let items = 1000u16;
    let more = usize::from(items - 1) * 6;
    let begin = of_32(&bytes, 96);
    let table = of_32(&bytes, begin as usize);
    bytes[begin as usize..][..4].copy_from_slice(&(table + more as u32).to_le_bytes());
    bytes[96..100].copy_from_slice(&(begin + more as u32).to_le_bytes());
    let length = u16::from_le_bytes([bytes[vlr + 20], bytes[vlr + 21]]);
    bytes[vlr + 20..vlr + 22].copy_from_slice(&(length + more as u16).to_le_bytes());
    bytes[record + 32..record + 34].copy_from_slice(&items.to_le_bytes());
    // Type 6, no bytes, version 2.
    let end = record + usize::from(length);
    bytes.splice(end..end, [6, 0, 0, 0, 2, 0].repeat(usize::from(items - 1)));
    let error = try_read(&bytes).expect_err("a thousand items").to_string();
    assert!(error.contains("expected at most 8 items of a point, found 1000"), "{error}");
}
