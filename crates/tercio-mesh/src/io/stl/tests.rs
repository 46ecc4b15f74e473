use proptest::prelude::*;

use super::*;
use crate::error::Place;

type Facet = [[f32; 3]; 3];

fn input(bytes: &[u8]) -> Input {
    Input::from_bytes("a.stl", bytes.to_vec(), &ReadOptions::default()).unwrap()
}

fn looks_like(bytes: &[u8]) -> bool {
    super::looks_like(&input(bytes))
}

fn model(bytes: &[u8]) -> ReadModel {
    assert!(looks_like(bytes));
    read(&input(bytes), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn error(bytes: &[u8]) -> (Place, String) {
    match read(&input(bytes), &ReadOptions::default()) {
        Err(ReadError::Malformed { place, expected, .. }) => (place, expected),
        other => panic!("{other:?}"),
    }
}

fn ascii(facets: &[Facet]) -> String {
    let mut text = String::from("solid a facet name\n");
    for facet in facets {
        text += "facet normal 0 0 nan\n outer loop\n";
        for [x, y, z] in facet {
            text += &format!("  vertex {x:e} {y} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid a\n"
}

fn binary(header: &str, facets: &[Facet], attribute: impl Fn(usize) -> u16) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend((facets.len() as u32).to_le_bytes());
    for (i, facet) in facets.iter().enumerate() {
        bytes.extend([0; 12]);
        bytes.extend(facet.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend(attribute(i).to_le_bytes());
    }
    bytes
}

const FACETS: [Facet; 2] =
    [[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], [[0., 0., 2.5], [1., 0., 1e-3], [0., -1., 0.]]];

#[test]
fn both_dialects_hold_the_same_facets() {
    let a = model(ascii(&FACETS).as_bytes());
    let b = model(&binary("x", &FACETS, |_| 0));
    assert_eq!((a.report.format.as_str(), b.report.format.as_str()), ("STL, ASCII", "STL, binary"));
    assert_eq!(a.mesh.positions, FACETS.concat());
    assert_eq!(a.mesh.positions, b.mesh.positions);
    assert_eq!(a.mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(a.mesh.triangles, b.mesh.triangles);
    assert_eq!((a.report.faces, b.mesh.face_colors), (2, None));
    assert_eq!(a.report.warnings, [""; 0]);
}

#[test]
fn white_space_case_and_further_words_do_not_matter() {
    let plain = model(ascii(&FACETS).as_bytes()).mesh.positions;
    let upper = ascii(&FACETS).to_uppercase().replace('\n', "\r\n\t");
    assert_eq!(model(upper.as_bytes()).mesh.positions, plain);
    let carriage_returns = ascii(&FACETS).replace('\n', "\r");
    assert_eq!(model(carriage_returns.as_bytes()).mesh.positions, plain);
    let one_line = ascii(&FACETS).replace('\n', " ");
    assert_eq!(model(one_line.as_bytes()).mesh.positions, plain);
    let words = ascii(&FACETS).replace("endloop", "endloop foo").replace("endfacet", "endfacet bar");
    let words = model(words.as_bytes());
    assert_eq!(words.mesh.positions, plain);
    assert_eq!(words.report.warnings, ["skipped 2 unknown words between the statements"]);
}

#[test]
fn several_solids_become_one_mesh() {
    let two = ascii(&FACETS[..1]) + &ascii(&FACETS[1..]) + "solid\nendsolid\n";
    assert_eq!(model(two.as_bytes()).mesh.positions, FACETS.concat());
}

#[test]
fn a_header_that_begins_with_solid_may_be_binary() {
    let exact = binary("solid x", &FACETS, |_| 0);
    assert_eq!(model(&exact).report.format, "STL, binary");
    let longer = [&exact[..], b"!"].concat();
    let m = model(&longer);
    assert_eq!((m.report.format.as_str(), m.report.faces), ("STL, binary", 2));
    assert_eq!(m.report.warnings, ["ignored 1 byte after the last triangle"]);
}

#[test]
fn a_wrong_count_is_reported_with_the_right_one() {
    let message = |bytes: &[u8]| {
        assert!(looks_like(bytes));
        read(&input(bytes), &ReadOptions::default()).unwrap_err().to_string()
    };
    let mut bytes = binary("x", &FACETS, |_| 0);
    let cut = &bytes[..bytes.len() - 1];
    let expected = "the 2 triangles that the header counts (184 bytes)";
    assert_eq!(
        message(cut),
        format!("a.stl: byte 183: expected {expected}, found only 1 triangle (183 bytes)")
    );
    for count in [0, 1] {
        bytes[80] = count;
        let expected = "a count of 2 triangles, as many as fit in the 184 bytes";
        assert_eq!(message(&bytes), format!("a.stl: byte 80: expected {expected}, found {count}"));
        // Padding does not hide it.
        let padded = [&bytes[..], &[0; 300]].concat();
        if count > 0 {
            let expected = "a count of 2 triangles, as many as fit in the 484 bytes";
            assert_eq!(message(&padded), format!("a.stl: byte 80: expected {expected}, found {count}"));
        }
    }
    bytes[80] = 200;
    assert!(message(&bytes).contains("200 triangles") && message(&bytes).contains("only 2 triangles"));
}

#[test]
fn a_count_of_half_the_facets_is_reported_whatever_follows_them() {
    let facets: Vec<Facet> = FACETS.iter().copied().cycle().take(200).collect();
    let mut bytes = binary("x", &facets, |_| 0);
    bytes[80] = 100;
    for rest in [&b""[..], b"\n", b"\r\n", &[0; 49], &[7; 49]] {
        let bytes = [&bytes[..], rest].concat();
        let (place, expected) = error(&bytes);
        let length = bytes.len();
        assert_eq!(place, Place::Byte(80));
        assert_eq!(expected, format!("a count of 200 triangles, as many as fit in the {length} bytes"));
    }
}

#[test]
fn a_count_that_is_far_too_large_is_reported_too() {
    let facets: Vec<Facet> = FACETS.iter().copied().cycle().take(40).collect();
    for header in ["x", "solid x"] {
        let mut bytes = binary(header, &facets, |_| 0);
        bytes.push(0);
        for count in [100_000_000, 1 << 31, u32::MAX] {
            bytes[80..84].copy_from_slice(&count.to_le_bytes());
            assert!(looks_like(&bytes), "{header} {count}");
            let message = read(&input(&bytes), &ReadOptions::default()).unwrap_err().to_string();
            assert!(message.contains(&format!("the {count} triangles that the header counts")), "{message}");
            assert!(message.contains("only 40 triangles"), "{message}");
        }
        let noise: Vec<u8> =
            (0..2000u32).map(|n| (n.wrapping_mul(n).wrapping_mul(7919) >> 5) as u8).collect();
        assert!(!looks_like(&[&bytes[..84], &noise].concat()), "{header}");
    }
}

#[test]
fn what_follows_the_last_facet_is_ignored_unless_it_is_one() {
    let bytes = binary("x", &FACETS, |_| 0);
    for (rest, what) in
        [(&[0; 12][..], "12 zero bytes"), (&[0; 150], "150 zero bytes"), (&[0xab; 50], "50 bytes")]
    {
        let m = model(&[&bytes[..], rest].concat());
        assert_eq!(m.report.faces, 2);
        assert_eq!(m.report.warnings, [format!("ignored {what} after the last triangle")]);
    }
}

#[test]
fn a_file_without_facets_needs_a_header_of_text() {
    assert_eq!(model(&binary("made by a test", &[], |_| 0)).report.faces, 0);
    for header in ["", "a\nb", "\u{1}", "   "] {
        assert!(!looks_like(&binary(header, &[], |_| 0)), "{header:?}");
    }
    let zeros = binary("x", &[[[0.0; 3]; 3]; 3], |_| 0);
    assert!(looks_like(&zeros));
    assert!(!looks_like(&[&[0; 80][..], &zeros[80..]].concat()));
    for length in [84, 134, 184, 1084, 5000] {
        assert!(!looks_like(&vec![0; length]), "{length}");
    }
    assert!(!looks_like(&[&binary("x", &[], |_| 0)[..], &[0; 500]].concat()));
}

#[test]
fn facets_of_any_size_are_facets() {
    for scale in [1e-44, 1e-38, 1e-36, 1e-30, 1e30, 1e38] {
        let facets = FACETS.map(|f| f.map(|p| p.map(|x| x * scale)));
        assert_eq!(model(&binary("x", &facets, |_| 0)).report.faces, 2, "{scale}");
    }
    // Normals are only tested where the coordinates are of unusual sizes.
    let mut odd = binary("x", &FACETS, |_| 0);
    odd[84..88].copy_from_slice(&7e22f32.to_le_bytes());
    odd[134..138].copy_from_slice(&7e22f32.to_le_bytes());
    assert_eq!(model(&odd).report.faces, 2);
}

#[test]
fn colours_are_read_where_they_are_meant() {
    let colors = |header: &str, attributes: [u16; 2]| {
        model(&binary(header, &FACETS, |i| attributes[i])).mesh.face_colors
    };
    assert_eq!(colors("x", [0, 0]), None);
    assert_eq!(colors("x", [0x8000 | 31 << 10, 0]), Some(vec![[255, 0, 0, 255], [255; 4]]));
    assert_eq!(colors("x", [0x8000 | 31 << 10, 7]), None, "not all are colours");
    let magics = "COLOR=\u{1}\u{2}\u{3}\u{4},MATERIAL=";
    assert_eq!(colors(magics, [0x8000, 31]), Some(vec![[1, 2, 3, 4], [255, 0, 0, 255]]));
    assert_eq!(colors(magics, [0, 0]), None);
}

#[test]
fn far_positions_keep_their_detail() {
    let far = FACETS.map(|f| f.map(|[x, y, z]| [x + 4e6, y, z]));
    let mesh = model(&binary("x", &far, |_| 0)).mesh;
    assert!(mesh.origin.x > 3.9e6);
    assert_eq!(mesh.positions[1][0] - mesh.positions[0][0], 1.0);
    assert_eq!(model(ascii(&far).as_bytes()).mesh.origin, mesh.origin);
}

#[test]
fn errors_state_the_place() {
    let at = |text: &str| error(text.as_bytes());
    let text = ascii(&FACETS);
    assert_eq!(at(&text.replace("vertex 0e0 -1 0", "vertex 0e0 x 0")).0, Place::Line(13));
    assert_eq!(at(&text.replace("  vertex 0e0 -1 0\n", "")), (Place::Line(13), "\"vertex\"".into()));
    assert_eq!(at(&text.replace("outer loop", "outer")).0, Place::Line(4));
    let four = text.replace("vertex 0e0 -1 0", "vertex 0e0 -1 0\nvertex 1 2 3");
    assert_eq!(at(&four), (Place::Line(14), "\"endloop\"".into()));
    assert_eq!(at("solid\nendsolid\nvertex 1 2 3").0, Place::Line(3));
}

#[test]
fn line_numbers_count_over_all_chunks() {
    let text = ascii(&[FACETS[0]; 50]) + "facet normal 0 0 0\nouter loop\nvertex 0 0 x\n";
    for step in [1, 100, 1 << 20] {
        match ascii::for_tests::read_in_steps(&input(text.as_bytes()), step) {
            Err(ReadError::Malformed { place, .. }) => assert_eq!(place, Place::Line(50 * 7 + 5)),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_file_cut_anywhere_never_panics() {
    for whole in [ascii(&FACETS).into_bytes(), binary("solid", &FACETS, |_| 0), binary("", &FACETS, |_| 9)] {
        for n in 0..whole.len() {
            let _ = looks_like(&whole[..n]);
            let _ = read(&input(&whole[..n]), &ReadOptions::default());
        }
    }
}

#[test]
fn other_files_do_not_look_like_stl() {
    let long_text = "v 1 2 3\n".repeat(100);
    let utf16: Vec<u8> = long_text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for no in
        [&b""[..], b"solid", b"solid state physics", long_text.as_bytes(), &utf16, &[0; 1000], &[255; 1000]]
    {
        assert!(!looks_like(no), "{:?}", &no[..no.len().min(20)]);
    }
}

proptest! {
    #[test]
    fn ascii_equals_binary(facets in prop::collection::vec(any::<[[i16; 3]; 3]>(), 1..30), step in 1usize..3000) {
        let facets: Vec<Facet> = facets.iter().map(|f| f.map(|p| p.map(|x| f32::from(x) / 64.0))).collect();
        let a = ascii::for_tests::read_in_steps(&input(ascii(&facets).as_bytes()), step).unwrap().mesh;
        let b = model(&binary("", &facets, |_| 0)).mesh;
        prop_assert_eq!((a.positions, a.triangles, a.origin), (b.positions, b.triangles, b.origin));
    }
}

proptest! {
    #[test]
    fn random_bytes_are_no_stl(mut bytes in random_file(), is_counted: bool) {
        if is_counted && bytes.len() >= 84 {
            let count = ((bytes.len() - 84) / 50) as u32;
            bytes[80..84].copy_from_slice(&count.to_le_bytes());
        }
        prop_assert!(!looks_like(&bytes));
    }
}

/// Of any length, or of the length of whole facets.
fn random_file() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        prop::collection::vec(any::<u8>(), 0..4000),
        (1usize..60).prop_flat_map(|n| prop::collection::vec(any::<u8>(), 84 + 50 * n)),
    ]
}
