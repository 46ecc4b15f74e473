//! PCD in every encoding, written here, and what is wrong with files that are cut or changed.

use tercio_mesh::ReadError;
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadModel, ReadOptions, read_input};

const HEADER: &str = "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb intensity\nSIZE 4 4 8 4 1\nTYPE F F F U I\nCOUNT 1 1 1 1 2\n\
                      WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ";

fn try_read(bytes: &[u8]) -> Result<ReadModel, ReadError> {
    let options = ReadOptions { memory_limit: Some(16 << 20), ..ReadOptions::default() };
    read_input(&Input::from_bytes("a", bytes.to_vec(), &options)?, &options)
}

fn rows() -> [Vec<u8>; 2] {
    [(0.5f32, -1.0f32, 2.0f64, 0x00ff_8001u32, [-3i8, 4]), (1.0, 2.0, 3.0, 0x0000_00ff, [5, -6])].map(
        |(x, y, z, rgb, [a, b])| {
            let parts = [
                &x.to_le_bytes()[..],
                &y.to_le_bytes(),
                &z.to_le_bytes(),
                &rgb.to_le_bytes(),
                &[a as u8, b as u8],
            ];
            parts.concat()
        },
    )
}

fn files() -> [Vec<u8>; 3] {
    let [a, b] = rows();
    let fields = [0..4, 4..8, 8..16, 16..20, 20..22];
    let columns: Vec<u8> = fields.into_iter().flat_map(|f| [&a[f.clone()], &b[f]].concat()).collect();
    // Literals only, at most 32 at a time.
    let packed: Vec<u8> = columns.chunks(32).flat_map(|c| [&[c.len() as u8 - 1][..], c].concat()).collect();
    let sizes = [packed.len() as u32, columns.len() as u32].map(u32::to_le_bytes).concat();
    let header = |data: &str| format!("{HEADER}{data}\n").into_bytes();
    let text = b"0.5 -1 2 16744449 -3 4\n1 2 3 255 5 -6\n";
    [
        [&header("ascii")[..], text].concat(),
        [&header("binary")[..], &a, &b].concat(),
        [&header("binary_compressed")[..], &sizes, &packed].concat(),
    ]
}

#[test]
fn every_encoding_gives_the_same_points() {
    for bytes in files() {
        let model = try_read(&bytes).unwrap_or_else(|e| panic!("{e}"));
        let strokes = &model.strokes;
        assert_eq!(strokes.positions, [[0.5, -1.0, 2.0], [1.0, 2.0, 3.0]]);
        assert_eq!(strokes.points, [0, 1]);
        assert_eq!(strokes.colors.as_deref(), Some(&[Some([255, 128, 1, 255]), Some([0, 0, 255, 255])][..]));
        let attributes: Vec<_> =
            strokes.attributes.iter().map(|a| (a.name.as_str(), &a.values[..])).collect();
        assert_eq!(attributes, [("intensity:0", &[-3.0, 5.0][..]), ("intensity:1", &[4.0, -6.0])]);
    }
}

#[test]
fn damaged_files_give_errors() {
    for bytes in files() {
        for cut in 0..bytes.len() - 3 {
            let error = try_read(&bytes[..cut]).expect_err("the end is missing").to_string();
            assert!(error.starts_with("a: "), "{error}");
        }
        for at in 0..bytes.len() {
            for value in [0, 0xff, b'9'] {
                let mut changed = bytes.clone();
                changed[at] = value;
                let _ = try_read(&changed);
            }
        }
    }
    let huge = String::from_utf8(files()[0].clone()).unwrap().replace("POINTS 2", "POINTS 4000000000");
    let error = try_read(huge.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        error,
        "a: line 12: expected 4000000000 points of 6 numbers, found 38 bytes up to the end of the file"
    );
}

/// A header of a few bytes states four thousand million points without a number, or millions of attributes without a
/// point. Both used to run for minutes.
#[test]
fn headers_cannot_ask_for_more_than_the_file_holds() {
    let header = |fields: usize, names: &str, count: &str, points: &str| {
        let all = |one: &str| vec![one; fields].join(" ");
        let (names, counts) = (all(names), all(count));
        let (sizes, types) = (all("4"), all("F"));
        format!(
            "VERSION 0.7\nFIELDS {names}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\nPOINTS {points}\nDATA ascii\n"
        )
    };
    let error = |text: String| try_read(text.as_bytes()).expect_err("no such points").to_string();
    let nothing = error(header(3, "x", "0", "4000000000"));
    assert_eq!(nothing, "a: line 7: expected the fields x, y and z, found \"\"");
    let many = error(header(256, "histogram", "4096", "0"));
    assert!(
        many.contains("expected at most 4096 components of fields beside x, y and z, not 1048576"),
        "{many}"
    );
    // As many components as there may be, beside the coordinates.
    let most = "VERSION 0.7\nFIELDS x y z vfh\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 4096\nPOINTS 1\nDATA ascii\n1 2 3";
    let most = format!("{most}{}\n", " 7".repeat(4096));
    let model = try_read(most.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        (model.strokes.attributes.len(), &model.strokes.attributes[4095].values[..]),
        (4096, &[7.0][..])
    );
    // A field without components is in no point.
    let empty = "VERSION 0.7\nFIELDS x y z w\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 0\nPOINTS 1\nDATA ascii\n1 2 3\n";
    let model = try_read(empty.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((model.strokes.origin.to_array(), &model.strokes.points[..]), ([1.0, 2.0, 3.0], &[0][..]));
    assert!(model.strokes.attributes.is_empty());
}
