//! Errors state where they are, and nothing panics.

use super::*;
use crate::error::Place;

const HEAD: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                    property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";

#[track_caller]
fn place(bytes: impl Into<Vec<u8>>) -> (Place, String) {
    match try_read(bytes) {
        Err(ReadError::Malformed { place, expected, found, .. }) => {
            (place, format!("expected {expected}, found {found}"))
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn ascii_errors_name_the_line() {
    for (body, line, words) in [
        ("0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", 11, "\"zero\""),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 3\n", 14, "from 0 to 2"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 -1 1\n", 14, "\"-1\""),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n-3 0 1 1\n", 14, "a list length"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 4294967296\n3 0 1 1\n", 13, "\"4294967296\""),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 99999999999999999999\n3 0 1 1\n", 13, "\"99999999999999999999\""),
        (
            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1\n",
            14,
            "3 numbers for vertex_indices of element face 1, found 5 bytes up to",
        ),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0   \n", 15, "the end of the file"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n4000000000 0 1\n", 14, "4000000000 numbers"),
        // Not one instance per line: found by the sequential reading.
        ("0 0\n0\n1 0 0 0 1\n0\n3 0 1 2 3 0 1 2.5\n", 14, "\"2.5\""),
        ("0 0 0 1 0 0\n0 1 0\n\n\n3 0 1 2\n3 0\n1 7\n", 16, "\"7\""),
    ] {
        let (found, text) = place(format!("{HEAD}{body}"));
        assert_eq!(found, Place::Line(line), "{body:?} {text}");
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn header_errors_name_the_line() {
    for (text, line, words) in [
        ("ply", 2, "end_header"),
        ("plyx\n", 1, "\"ply\""),
        ("ply\nformat utf8 1.0\nend_header\n", 2, "utf8"),
        ("ply\nend_header\n", 2, "format"),
        ("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", 3, "\"-1\""),
        (
            "ply\nformat ascii 1.0\nelement vertex 18446744073709551617\nend_header\n",
            3,
            "18446744073709551617",
        ),
        ("ply\nformat ascii 1.0\nelement vertex\nend_header\n", 3, "end of the line"),
        ("ply\nformat ascii 1.0\nproperty float x\nend_header\n", 3, "an element before"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\nend_header\n", 4, "\"real\""),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar x\nend_header\n", 4, "\"x\""),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n12345\n", 3, "x, y and z"),
        ("ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n12345\n", 3, "vertex_indices"),
        ("ply\nformat ascii 1.0\nelement vertex 0\nelement vertex 0\nend_header\n", 4, "second"),
        ("ply\nformat ascii 1.0\n\x01\x02\n", 3, "\\x01"),
    ] {
        let (found, shown) = place(text);
        assert_eq!(found, Place::Line(line), "{text:?} {shown}");
        assert!(shown.contains(words), "{shown}");
    }
}

#[test]
fn binary_errors_name_the_byte() {
    let polygons = [vec![0, 1, 2], vec![0, 1, 2], vec![0, 1, 2, 3]];
    for encoding in &ENCODINGS[1..] {
        // Both the reading with a stride and the one that walks.
        for faces_read in [2, 3] {
            let bytes = encode(encoding, &[square(), faces(&polygons[..faces_read])]);
            let body = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
            let second = body + 4 * 12 + 13;
            let mut wrong = bytes.clone();
            wrong[second + 1..second + 5].fill(0xff);
            let (found, text) = place(wrong);
            assert_eq!(found, Place::Byte(second as u64 + 1));
            assert!(text.contains("from 0 to 3, found -1"), "{text}");
            let mut wrong = bytes.clone();
            wrong[second] = 200;
            let (found, text) = place(wrong);
            assert_eq!(found, Place::Byte(second as u64 + 1));
            assert!(text.contains("800 bytes of a list of 200 of element face 1"), "{text}");
        }
        let signed = Sheet { properties: vec!["list char int vertex_indices"], ..faces(&polygons) };
        let mut bytes = encode(encoding, &[square(), signed]);
        let body = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        bytes[body + 48] = 0x80;
        let (found, text) = place(bytes);
        assert_eq!(found, Place::Byte(body as u64 + 48));
        assert!(text.contains("a list length") && text.contains("-128"), "{text}");
    }
}

#[test]
fn huge_counts_are_refused_before_memory_is_taken() {
    for encoding in ENCODINGS {
        for count in ["4294967294", "4294967295", "99999999999", "9223372036854775807"] {
            for element in ["vertex", "face", "tristrips", "other"] {
                let text = format!(
                    "ply\nformat {encoding} 1.0\nelement {element} {count}\nproperty float x\nproperty float y\n\
                     property float z\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0"
                );
                assert!(try_read(text).is_err());
            }
        }
        // Instances without properties take no bytes: any number of them is allowed.
        let text = format!("ply\nformat {encoding} 1.0\nelement other 9223372036854775807\nend_header\n");
        assert_eq!(read_ok(text).mesh.positions.len(), 0);
    }
}

#[test]
fn the_memory_limit_holds() {
    let points = vec![[1.0; 3]; 10_000];
    for encoding in ENCODINGS {
        let bytes = encode(encoding, &[vertices(&points), faces(&vec![vec![0, 1, 2]; 10_000])]);
        let held = bytes.len() as u64;
        let read_with = |limit| {
            let options = ReadOptions { memory_limit: Some(limit), progress: None, ..ReadOptions::default() };
            read(&Input::from_bytes("test.ply", bytes.clone(), &ReadOptions::default()).unwrap(), &options)
        };
        assert!(matches!(read_with(held + 100_000), Err(ReadError::MemoryLimit { .. })), "{encoding}");
        assert!(read_with(held + 1_000_000).is_ok(), "{encoding}");
    }
}

/// A file with every kind of element and property.
fn rich(encoding: &str) -> Vec<u8> {
    let mut v = square();
    v.properties.extend(["uchar red", "uchar green", "uchar blue", "double quality"]);
    v.rows.iter_mut().for_each(|row| row.extend(one(&[1.0, 2.0, 3.0, 4.5])));
    let mut f = faces(&[vec![0, 1, 2], vec![0, 1, 2, 3]]);
    f.properties.extend(["list uchar float texcoord", "short flags"]);
    f.rows.iter_mut().for_each(|row| row.extend([list(&[1, 0, 1, 0, 0, 1]), Value::One(3.0)]));
    let strips = Sheet {
        name: "tristrips",
        properties: vec!["list int int vertex_indices"],
        rows: vec![vec![Value::List(vec![0., 1., 2., -1., 1., 2., 3.])]],
    };
    encode(encoding, &[v, f, strips])
}

#[test]
fn cut_off_at_every_byte() {
    for encoding in ENCODINGS {
        let whole = rich(encoding);
        assert_eq!(read_ok(whole.clone()).mesh.triangles.len(), 5);
        for n in 0..whole.len() {
            let cut = try_read(&whole[..n]);
            // ASCII may lose the blank, the line end and digits of the last number.
            assert!(cut.is_err() || (encoding == "ascii" && n + 4 > whole.len()), "{encoding} {n}");
        }
    }
}

#[test]
fn every_byte_corrupted() {
    for encoding in ENCODINGS {
        let whole = rich(encoding);
        for n in 0..whole.len() {
            for value in [0, b'\n', b' ', b'-', b'9', 0x80, 0xff] {
                let mut spoilt = whole.clone();
                spoilt[n] = value;
                if let Ok(model) = try_read(spoilt) {
                    let vertices = model.mesh.positions.len() as u32;
                    assert!(model.mesh.triangles.iter().flatten().all(|&v| v < vertices));
                }
            }
        }
    }
}

#[test]
fn one_and_many_are_reported_in_singular_and_plural() {
    let vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let lists = "property list uchar int vertex_indices\nproperty list uchar float texcoord\n";
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    let of = |faces: usize, face: &str, surplus: &str, elements: usize| {
        let more: String = (0..elements).map(|i| format!("element e{i} 1\nproperty float a\n")).collect();
        let points = points.replacen("0 0\n", &format!("0 0{surplus}\n"), faces);
        let text = format!(
            "ply\nformat ascii 1.0\n{vertices}element face {}\n{lists}{more}end_header\n{points}3 0 1 2 6 0 0 1 0 0 1\n{}{}",
            faces + 1,
            face.repeat(faces),
            "1\n".repeat(elements)
        );
        let input = Input::from_bytes("a.ply", text.into_bytes(), &ReadOptions::default()).unwrap();
        read(&input, &ReadOptions::default()).unwrap().report.warnings
    };
    let without = |n| of(n, "3 0 1 2 0\n", "", 0);
    assert_eq!(without(1), ["1 face has no texture coordinates at its corners"]);
    assert_eq!(without(2), ["2 faces have no texture coordinates at their corners"]);
    let empty = |n| of(n, "0 0\n", "", 0);
    assert_eq!(empty(1)[0], "ignored 1 face that has no corners");
    assert_eq!(empty(2)[0], "ignored 2 faces that have no corners");
    let longer = |n| of(n, "3 0 1 2 6 0 0 1 0 0 1\n", " 7", 0);
    assert_eq!(longer(1), ["1 line of element vertex holds more than the header declares"]);
    assert_eq!(longer(2), ["2 lines of element vertex hold more than the header declares"]);
    let last = |n| of(0, "", "", n).pop();
    assert_eq!(last(9).as_deref(), Some("ignored 1 more element"));
    assert_eq!(last(10).as_deref(), Some("ignored 2 more elements"));
}

#[test]
fn a_face_in_a_file_without_vertices_is_an_error() {
    let text = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n3 0 1 2\n";
    let input = Input::from_bytes("a.ply", text.into(), &ReadOptions::default()).unwrap();
    let error = read(&input, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("expected no vertex indices (the file has no vertices) for"), "{error}");
}
