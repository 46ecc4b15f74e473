use proptest::prelude::*;

use super::*;
use crate::OctNormal;
use crate::error::Place;
use crate::io::NotDrawn;

fn input(bytes: &[u8]) -> Input {
    Input::from_bytes("a.off", bytes.to_vec(), &ReadOptions::default()).unwrap()
}

fn model(text: &str) -> ReadModel {
    assert!(looks_like(text.as_bytes()), "{text}");
    read(&input(text.as_bytes()), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn error_line(text: &str) -> u64 {
    match read(&input(text.as_bytes()), &ReadOptions::default()) {
        Err(ReadError::Malformed { place: Place::Line(line), .. }) => line,
        other => panic!("{other:?}"),
    }
}

const BODY: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n4 0 1 2 3\n";

#[test]
fn headers_of_all_kinds() {
    for header in [
        "OFF\n4 2 5\n",
        "OFF 4 2\n",
        "# c\n\nOFF # c\n4 2 0 # c\n\n",
        "OFF4 2 5\n",
        "appearance {\n+a {x}\n}\nOFF\n4 2 0\n",
    ] {
        let m = model(&format!("{header}{BODY}"));
        assert_eq!((m.mesh.positions.len(), m.mesh.triangles.len(), m.report.faces), (4, 3, 2), "{header}");
        assert_eq!(m.mesh.face_of_triangle.as_deref(), Some(&[0, 1, 1][..]));
        assert_eq!((m.report.format.as_str(), m.report.warnings.len()), ("OFF", 0));
    }
    let bare = model(&format!("4 2 0\n{BODY}"));
    assert_eq!(bare.report.warnings, ["the keyword OFF is missing"]);
    let crs = format!("OFF\n4 2 0\n{BODY}").replace('\n', "\r");
    assert_eq!(model(&crs).mesh.triangles.len(), 3);
}

#[test]
fn other_dimensions_become_three() {
    let points = |text: &str| model(text).mesh.positions;
    let four = "4OFF\n3 1 0\n0 0 0 2\n2 0 -4 2\n0 2 0 0.5\n3 0 1 2\n";
    assert_eq!(points(four), [[0., 0., 0.], [1., 0., -2.], [0., 4., 0.]]);
    assert_eq!(model(four).report.format, "OFF, 4OFF");
    assert!(points(&four.replace("-4 2", "-4 0"))[1][0].is_infinite(), "a point at infinity");
    let three = "nOFF 3\n3 1 0\n0 0 0\n2 0 -4\n0 2 0\n3 0 1 2\n";
    assert_eq!(points(three), [[0., 0., 0.], [2., 0., -4.], [0., 2., 0.]]);
    assert_eq!((model(three).report.format.as_str(), model(three).report.warnings.len()), ("OFF", 0));
    assert_eq!(points("nOFF\n2\n3 1 0\n0 0\n2 1\n0 2\n3 0 1 2\n")[1], [2., 1., 0.]);
    let five = model("nOFF 5 3 1 0\n0 0 0 7 7\n2 0 -4 7 7\n0 2 0 7 7\n3 0 1 2\n");
    assert_eq!(five.mesh.positions[1], [2., 0., -4.]);
    assert_eq!(five.report.warnings, ["drew the first 3 of 5 dimensions"]);
    assert_eq!(error_line("nOFF\n0\n3 1 0\n"), 2);
    let error = |text: &[u8]| read(&input(text), &ReadOptions::default()).unwrap_err().to_string();
    let none = error(b"nOFF\n-1\n3 1 0\n");
    assert!(none.ends_with("expected the number of coordinates of a vertex, found \"-1\""), "{none}");
    let binary = error(b"nOFF BINARY\n\0\0\0\x03\0\0\0\x03\0\0\0\x01\0\0\0\0");
    assert!(binary.contains("(nOFF BINARY) is not supported"), "{binary}");
    assert_eq!(error_line("nOFF 9223372036854775807\n3 1 0\n0 0 0\n"), 2);
    let both = read(&input(b"C4nOFF 5\n4 2 0\n"), &ReadOptions::default()).unwrap_err().to_string();
    assert_eq!(both, "a.off: line 1: OFF of any number of homogeneous coordinates (4nOFF) is not supported");
}

#[test]
fn vertices_hold_what_the_letters_announce() {
    let m = model(
        "STCNOFF\n3 1 0\n0 0 0 0 0 2 1 0.5 0 0.25 0.75\n1 0 0 0 0 1 0 0 1 0.5 1 0\n0 1 0 0 0 1 0 0 0 1 1 # c\n3 0 1 2\n",
    );
    assert_eq!(m.report.format, "OFF, STCNOFF");
    assert_eq!(m.mesh.normals.unwrap()[0].decode(), [0., 0., 1.]);
    assert_eq!(m.mesh.vertex_colors.unwrap(), [[255, 128, 0, 255], [0, 0, 255, 128], [0, 0, 0, 255]]);
    assert_eq!(m.mesh.texcoords.unwrap(), [[0.25, 0.75], [1., 0.], [1., 1.]]);
    let plain = model("NOFF 3 1\n0 0 0 0 0 1\n1 0 0\n0 0 0\n0 1 0 0 1e200 0\n3 0 1 2\n");
    let (up, along) = (OctNormal::from_vector([0.0, 0.0, 1.0]), OctNormal::from_vector([0.0, 1.0, 0.0]));
    assert_eq!(plain.mesh.normals, Some(vec![up, OctNormal::NONE, along]));
}

#[test]
fn colours_that_are_not_finite_become_white() {
    let text = "COFF\n3 1 0\n0 0 0 1 nan 0\n1 0 0 0.5 0.5 inf 1\n0 1 0 1 0 0\n3 0 1 2 0 0 nan\n";
    let m = model(text);
    assert_eq!(m.mesh.vertex_colors.unwrap(), [[255; 4], [255; 4], [255, 0, 0, 255]]);
    assert_eq!(m.mesh.face_colors.unwrap(), [[255; 4]]);
    assert_eq!(
        m.report.warnings,
        [
            "set 2 colours of vertices that were not finite to white",
            "set 1 colour of faces that were not finite to white"
        ]
    );
}

#[test]
fn colours_from_0_to_1_and_from_0_to_255() {
    let v = "0 0 0\n1 0 0\n0 1 0\n0 1 1\n";
    let m = model(&format!("OFF\n4 4 0\n{v}3 0 1 2 255 0 10\n4 0 1 2 3 1 2 3 4\n3 0 1 3\n3 0 1 2 7#c\n"));
    let colors = m.mesh.face_colors.unwrap();
    assert_eq!(colors, [[255, 0, 10, 255], [1, 2, 3, 4], [1, 2, 3, 4], [255; 4], [255; 4]]);
    let unit = model(&format!("OFF\n4 1 0\n{v}3 0 1 2 1 0.5 0#red\n")).mesh.face_colors.unwrap();
    assert_eq!(unit, [[255, 128, 0, 255]]);
    assert_eq!(model(&format!("OFF\n4 1 0\n{v}3 0 1 2\n")).mesh.face_colors, None);
}

#[test]
fn small_faces_are_ignored_and_the_rest_is_reported() {
    let m = model("OFF\n3 5 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n1 0\n2 1 2\n0\n\nmore\n");
    let not_drawn = NotDrawn { points: 1, lines: 2, ..NotDrawn::default() };
    assert_eq!((m.report.faces, m.report.not_drawn, m.mesh.face_of_triangle), (1, not_drawn, None));
    assert_eq!(m.report.warnings.len(), 2);
    assert!(m.report.warnings[0].contains("line 12"), "{:?}", m.report.warnings);
    assert!(m.report.warnings[1].contains("no corners"), "{:?}", m.report.warnings);
}

#[test]
fn errors_state_the_line() {
    assert_eq!(error_line("OFF\nx 2 0\n"), 2);
    assert_eq!(error_line("OFF\n-1 2 0\n"), 2);
    assert_eq!(error_line("OFF\n400000000000 2 0\n0 0 0\n"), 2);
    assert_eq!(error_line("OFF\n18446744073709551615 9223372036854775807 0\n0 0 0\n"), 2);
    assert_eq!(error_line(&format!("OFF\n4 2 0\n{}", BODY.replace("1 1 0", "1 x 0"))), 5);
    assert_eq!(error_line(&format!("OFF\n4 2 0\n{}", BODY.replace("3 0 1 2\n", "3 0 1 4\n"))), 7);
    assert_eq!(error_line(&format!("OFF\n4 2 0\n{}", BODY.replace("3 0 1 2\n", "3 0 1 2 1 1\n"))), 7);
    assert_eq!(error_line(&format!("OFF\n4 2 0\n{}", BODY.replace("4 0", "-4 0"))), 8);
    assert_eq!(error_line(&format!("OFF\n4 3 0\n{BODY}")), 9);
}

#[test]
fn other_files_do_not_look_like_off() {
    for no in ["", "# OFF\n", "OFFSET 1", "1 2 3\n4 5 6\n", "3 1 0\n", "solid\n", "0 0 0\n1 0 0\n0 1 0\n"] {
        assert!(!looks_like(no.as_bytes()), "{no}");
    }
}

#[test]
fn a_stray_line_before_the_keyword_is_skipped() {
    let m = model(&format!("made by hand\n# c\nOFF\n4 2 0\n{BODY}"));
    assert_eq!(m.report.faces, 2);
    assert_eq!(m.report.warnings, ["ignored the line before the keyword: \"made by hand\""]);
    assert_eq!(error_line("made by hand\nOFF\n4 2 0\n0 0 0\nx 0 0\n1 1 1 1 1 1\n1 1 1 1\n"), 5);
    for no in ["a\nb\nOFF\n4 2 0\n", "a\nOFF we go\n", "a\nOFF\n"] {
        assert!(!looks_like(no.as_bytes()), "{no}");
    }
}

#[test]
fn a_face_in_a_file_without_vertices_is_an_error() {
    let error = read(&input(b"OFF\n0 1 0\n3 0 1 2\n"), &ReadOptions::default()).unwrap_err().to_string();
    assert_eq!(error, "a.off: line 3: expected no vertex indices (the file has no vertices), found \"0\"");
}

#[test]
fn one_and_many_are_reported_in_singular_and_plural() {
    for (faces, told) in
        [("0\n", "ignored 1 face that has no corners"), ("0\n0\n", "ignored 2 faces that have no corners")]
    {
        let m = model(&format!("OFF\n4 {} 0\n{BODY}{faces}", 2 + faces.len() / 2));
        assert_eq!(m.report.warnings, [told]);
    }
}

#[test]
fn a_file_cut_anywhere_never_panics() {
    let text = "appearance { a }\nSTCNOFF\n3 1 0\n0 0 0 0 0 2 1 0.5 0 0.25 0.75\n1 0 0 0 0 1 0 0 1 0.5 1 0#\n0 1 0 0 0 1 0 0 0 1 1 # c\n3 0 1 2 1 0 0\n";
    for n in 0..text.len() {
        let _ = looks_like(&text.as_bytes()[..n]);
        let _ = read(&input(&text.as_bytes()[..n]), &ReadOptions::default());
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(text in "(ST|C|N){0,2}OFF[ \n][0-5] [0-3][ 0-9.#\n-]{0,120}") {
        let _ = looks_like(text.as_bytes());
        let _ = read(&input(text.as_bytes()), &ReadOptions::default());
    }
}
