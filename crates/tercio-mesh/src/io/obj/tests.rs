use proptest::prelude::*;

use super::*;
use crate::error::Place;
use crate::io::NotDrawn;
use crate::{AttributeDomain, Mesh};

fn input(text: &[u8]) -> Input {
    Input::from_bytes("a.obj", text.to_vec(), &ReadOptions::default()).unwrap()
}

fn looks_like(bytes: &[u8]) -> bool {
    super::looks_like(&input(bytes))
}

fn model(text: &str) -> ReadModel {
    read(&input(text.as_bytes()), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Line, expected and found text of the error.
fn error(text: &str) -> (u64, String, String) {
    match read(&input(text.as_bytes()), &ReadOptions::default()) {
        Err(ReadError::Malformed { place: Place::Line(line), expected, found, .. }) => {
            (line, expected, found)
        }
        other => panic!("{other:?}"),
    }
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn a_triangle_and_a_square() {
    let m = model(&format!("# c\n\n{SQUARE}f 1 2 3 # c\n  f\t1 2 3 4\r\n"));
    assert_eq!(m.mesh.positions, [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
    assert_eq!(m.mesh.triangles.len(), 3);
    assert_eq!(m.mesh.face_of_triangle.as_deref(), Some(&[0, 1, 1][..]));
    assert_eq!((m.report.faces, m.report.format.as_str()), (2, "OBJ"));
    assert_eq!(m.report.warnings, [""; 0]);
}

#[test]
fn relative_indices_count_from_their_line() {
    let m = model("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 0 1\nv 0 1 1\nv 1 1 1\nf -3 -2 -1\nf 1 -1 2\n");
    assert_eq!(m.mesh.triangles, [[0, 1, 2], [3, 4, 5], [0, 5, 1]]);
    assert_eq!(m.mesh.face_of_triangle, None);
}

#[test]
fn faces_may_precede_their_vertices() {
    assert_eq!(model("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn line_ends_and_encodings_do_not_matter() {
    let text = format!("mtllib no\n{SQUARE}f 1 2 \\\n 3 4\nf 1 2 3");
    let plain = model(&text.replace("mtllib no\n", ""));
    let utf16: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [
        text.replace('\n', "\r\n").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        format!("\u{feff}{text}").into_bytes(),
        utf16,
    ] {
        assert!(looks_like(&bytes), "{bytes:?}");
        let m = read(&input(&bytes), &ReadOptions::default()).unwrap();
        assert_eq!(m.mesh.triangles, plain.mesh.triangles);
        assert_eq!(m.mesh.positions, plain.mesh.positions);
    }
}

#[test]
fn vertices_are_split_only_where_corners_differ() {
    let vt = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5\n";
    let same = model(&format!("{SQUARE}{vt}f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"));
    assert_eq!(same.mesh.positions.len(), 4);
    assert_eq!(same.mesh.texcoords, Some(vec![[0., 0.], [1., 0.], [1., 1.], [0., 1.]]));
    let seam = model(&format!("{SQUARE}{vt}f 1/2 2/2 3/3\nf 1/5 3/3 4/4\nf 1/5 2/2 4/4\n"));
    assert_eq!(seam.mesh.triangles, [[0, 1, 2], [4, 2, 3], [4, 1, 3]]);
    assert_eq!(seam.mesh.positions[4], [0., 0., 0.]);
    assert_eq!(seam.mesh.texcoords.unwrap()[4], [0.5, 0.]);
}

#[test]
fn a_vertex_is_split_for_each_of_its_normals() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for i in 0..100 {
        text += &format!("vn 1 {i} 0\n");
    }
    for _ in 0..2 {
        for i in 1..=100 {
            text += &format!("f 1//{i} 2//1 3//1\n");
        }
    }
    let m = model(&text).mesh;
    assert_eq!(m.positions.len(), 3 + 99);
    assert_eq!(m.triangles[..100], m.triangles[100..]);
    assert_eq!(m.normals.unwrap().len(), 102);
}

#[test]
fn corners_without_a_normal_do_not_take_those_of_others() {
    let vn = "vn 0 0 2\nvn 0 0 0\nvn nan 1 0\nvn 1e39 0 0\nvn 0 -1e-50 0\n";
    let normals = |faces: &str| model(&format!("{SQUARE}{vn}{faces}")).mesh.normals;
    let (up, none) = (OctNormal::from_vector([0.0, 0.0, 1.0]), OctNormal::NONE);
    // The fourth vertex has no corner, so it needs no normal.
    assert_eq!(normals("f 1//1 2//1 3//1\n"), Some(vec![up, up, up, OctNormal::default()]));
    // One normal is missing; then some are broken.
    assert_eq!(normals("f 1//1 2//1 3//1\nf 1 3 4\n"), Some(vec![up, up, up, none, none, none]));
    assert_eq!(normals("f 1//1 2//2 3//3\nf 1//1 3//3 4//1\n"), Some(vec![up, none, none, up]));
    // Any length is accepted, even one that is out of range in 32 bits.
    let (right, down) = (OctNormal::from_vector([1.0, 0.0, 0.0]), OctNormal::from_vector([0.0, -1.0, 0.0]));
    assert_eq!(normals("f 1//4 2//5 3//1\nf 1//4 3//1 4//1\n"), Some(vec![right, down, up, up]));
    // The same where every corner uses the same index for all its elements.
    assert_eq!(normals("f 1//1 2//2 3//3\n").unwrap()[..3], [up, none, none]);
}

#[test]
fn colours_after_positions() {
    let m = model("v 0 0 0 1 0.5 0\nv 1 0 0 1\nv 0 1 0 0 0 1 0.2\nf 1 2 3\n");
    assert_eq!(m.mesh.vertex_colors.unwrap(), [[255, 128, 0, 255], [255; 4], [0, 0, 255, 51]]);
    assert!(m.report.warnings[0].contains("1 of 3"), "{:?}", m.report.warnings);
    let bytes = model("v 0 0 0 255 128 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
    assert_eq!(bytes.mesh.vertex_colors.unwrap()[..2], [[255, 128, 0, 255], [0, 1, 0, 255]]);
    let broken = model("v 0 0 0 1 0.5 inf\nv 1 0 0 nan 1 0\nv 0 1 0 1 0.5 0\nf 1 2 3\n");
    assert_eq!(broken.mesh.vertex_colors.unwrap(), [[255; 4], [255; 4], [255, 128, 0, 255]]);
    assert!(broken.report.warnings[0].contains("2 of 3"), "{:?}", broken.report.warnings);
}

#[test]
fn materials_come_from_the_library_beside_the_model() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my lib.mtl"), "newmtl red paint\nKd 1 0 0\n").unwrap();
    std::fs::write(folder.path().join("b.mtl"), "newmtl blue\nKd 0 0 1\nnewmtl unused\n").unwrap();
    let text = format!(
        "mtllib my lib.mtl none.mtl b.mtl\n{SQUARE}f 1 2 3\nusemtl blue\nf 1 2 3 4\nusemtl red paint\nf 1 2 4\n\
         usemtl gone\nf 1 2 4\n"
    );
    let mut input = input(text.as_bytes());
    input.base = Some(folder.path().into());
    let m = read(&input, &ReadOptions::default()).unwrap();
    let names: Vec<_> = m.mesh.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["blue", "red paint"]);
    let none = Mesh::NO_MATERIAL;
    assert_eq!(m.mesh.triangle_materials.unwrap(), [none, 0, 0, 1, none]);
    assert_eq!(m.report.warnings.len(), 2, "{:?}", m.report.warnings);
    assert!(m.report.warnings[0].contains("\"none.mtl\""));
    assert!(m.report.warnings[1].contains("\"gone\""));
}

#[test]
fn lines_and_points_have_the_colors_of_their_materials() {
    let folder = tempfile::tempdir().unwrap();
    let library = "newmtl red\nKd 1 0 0\nnewmtl pale\nKd 0 0 1\nd 0.2\nnewmtl plain\n";
    std::fs::write(folder.path().join("m.mtl"), library).unwrap();
    let read_text = |text: String| {
        let mut input = input(text.as_bytes());
        input.base = Some(folder.path().into());
        read(&input, &ReadOptions::default()).unwrap()
    };
    let m = read_text(format!(
        "mtllib m.mtl\n{SQUARE}l 1 2\nusemtl red\nl 2 3\nf 1 2 3\nusemtl pale\nusemtl gone\nl 3 4\nusemtl pale\np 4 3\n\
         usemtl plain\nl 4 1\n"
    ));
    // Those of faces only are materials of the mesh.
    assert_eq!(m.mesh.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["red"]);
    assert_eq!(m.report.warnings, ["found no definition of 1 material: \"gone\""]);
    let strokes = &m.strokes;
    let of_strokes: Vec<_> = strokes.materials.iter().map(|m| (m.name.as_str(), m.opacity)).collect();
    assert_eq!(of_strokes, [("red", 1.0), ("plain", 1.0), ("pale", 0.2)]);
    let color_and_place = |v: u32| (strokes.color(v), strokes.positions[v as usize]);
    let of_file = |v: usize| m.mesh.positions[v - 1];
    let [grey, red, pale] = [[204, 204, 204, 255], [255, 0, 0, 255], [0, 0, 255, 51]].map(Some);
    // The first line has no material, the third one that is not defined, the last one that states no colour.
    let segments = [(1, 2, None), (2, 3, red), (3, 4, None), (4, 1, grey)];
    assert_eq!(strokes.segments.len(), segments.len());
    for (segment, (from, to, color)) in strokes.segments.iter().zip(segments) {
        assert_eq!(segment.map(color_and_place), [from, to].map(|v| (color, of_file(v))));
    }
    let points: Vec<_> = strokes.points.iter().map(|&v| color_and_place(v)).collect();
    assert_eq!(points, [4, 3].map(|v| (pale, of_file(v))));
    // Vertices with colours keep them, with the opacity of the material.
    let m = read_text("mtllib m.mtl\nv 0 0 0 1 1 0\nv 1 0 0 0 1 0\nusemtl pale\nl 1 2\n".into());
    assert_eq!(m.strokes.colors.unwrap(), [Some([255, 255, 0, 51]), Some([0, 255, 0, 51])]);
    // Without a defined material they have the colour that the user chooses.
    for text in ["l 1 2\n", "usemtl gone\nl 1 2\n", "usemtl red\nf 1 2 3\n"] {
        assert!(read_text(format!("mtllib m.mtl\n{SQUARE}{text}")).strokes.colors.is_none(), "{text}");
    }
}

#[test]
fn the_names_of_libraries_may_be_continued() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl a\n").unwrap();
    for line in ["mtllib \\\n m.mtl", "mtllib \\\r\nm.mtl", "mtllib\\\n m.mtl", "mtllib m.mtl \\\n m.mtl"] {
        let mut input = input(format!("{line}\n{SQUARE}usemtl a\nf 1 2 3\n").as_bytes());
        input.base = Some(folder.path().into());
        let m = read(&input, &ReadOptions::default()).unwrap();
        assert_eq!((m.mesh.materials.len(), m.report.warnings), (1, vec![]), "{line}");
        assert_eq!(m.report.companions, [folder.path().join("m.mtl")]);
    }
}

#[test]
fn unused_libraries_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let many: String = (0..300).map(|n| format!("mtllib {n}.mtl\n")).collect();
    for (used, warnings) in [("", 0), ("usemtl a\n", 258)] {
        for n in 0..300 {
            std::fs::write(folder.path().join(format!("{n}.mtl")), "Kd\n").unwrap();
        }
        let mut input = input(format!("{many}{SQUARE}{used}f 1 2 3\n").as_bytes());
        input.base = Some(folder.path().into());
        let m = read(&input, &ReadOptions::default()).unwrap();
        assert_eq!((m.report.companions.len(), m.report.warnings.len()), (300, warnings));
    }
}

#[test]
fn groups_become_an_attribute_where_they_differ() {
    let m = model(&format!("{SQUARE}g a\nf 1 2 3 4\ng b c\nf 1 2 3\ng a\nf 2 3 4\n"));
    assert_eq!(m.mesh.attributes.len(), 1);
    let group = &m.mesh.attributes[0];
    assert_eq!((group.name.as_str(), group.domain), ("group", AttributeDomain::Triangle));
    assert_eq!(group.values, [1., 1., 2., 1.]);
    assert!(model(&format!("{SQUARE}o x\ng a\nf 1 2 3\n")).mesh.attributes.is_empty());
}

#[test]
fn what_is_not_drawn_is_counted_and_reported() {
    let curve =
        "cstype bspline\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 0 1 1\nend\nsurf 0 1 0 1 1 2 3 4\ntrim 0 1 1\n";
    let m = model(&format!("{SQUARE}p 1 2 3\nl 1 2 3\n{curve}f 1 2\ns off\nfoo 1\nbar\nfoo\nf 1 2 3\n"));
    let expected = NotDrawn { points: 3, lines: 1, curves: 1, surfaces: 1, ..NotDrawn::default() };
    assert_eq!((m.report.faces, m.report.not_drawn), (1, expected));
    assert_eq!(
        m.report.warnings,
        [
            "ignored 1 face with fewer than three corners, the first in line 14",
            "ignored 3 lines that begin with an unknown word: \"foo\", \"bar\"",
        ]
    );
}

#[test]
fn errors_state_line_expected_and_found() {
    let at = |text: &str| {
        let (line, _, found) = error(text);
        (line, found)
    };
    assert_eq!(at("v 0 0 0\nv 1 \\\n x 0\n"), (2, "\"x\"".into()));
    assert_eq!(at("v 0 0\nv 1 0 0\n"), (1, "the end of the line".into()));
    assert_eq!(at("v 0 0 0\n\nf 1 1 2\n"), (3, "\"2\"".into()));
    assert_eq!(at("v 0 0 0\nf 1 0 1\n"), (2, "\"0\"".into()));
    assert_eq!(at("v 0 0 0\nf 1 1 -2\n"), (2, "\"-2\"".into()));
    assert_eq!(at("v 0 0 0\nf 1 1 9223372036854775808\n"), (2, "\"9223372036854775808\"".into()));
    assert_eq!(at("v 0 0 0\nf 1 1 -9223372036854775808\n"), (2, "\"-9223372036854775808\"".into()));
    assert_eq!(at("v 0 0 0\nvt 0 0\nf 1/1 1/2 1/1\n"), (3, "\"1/2\"".into()));
    assert_eq!(at("v 0 0 0\nf 1/1/1/1 1 1\n"), (2, "\"1/1/1/1\"".into()));
    assert_eq!(at("vn 0 0\n"), (1, "the end of the line".into()));
    assert!(error("v 0 0 0\nf 1 2 3\n").1.contains("from 1 to 1"));
}

#[test]
fn numbers_of_old_programs_are_accepted() {
    let m = model("v 1.#IND -1.#INF 3.1+e2\nv +1. .5 -2.e+1\nv nan -nan inf\nv 0 0 0\nf 1 2 3\n");
    assert!(m.mesh.positions[0][0].is_nan());
    assert_eq!(m.mesh.positions[0][1], f32::NEG_INFINITY);
    assert_eq!(m.mesh.positions[1], [1., 0.5, -20.]);
    assert_eq!(m.report.warnings, ["guessed 3 numbers written in a way that OBJ does not know"]);
}

#[test]
fn statements_decide_what_looks_like_obj() {
    let many_comments = "# nothing yet\n".repeat(30_000) + "v 1 2 3\n";
    for yes in [
        "v 1 2 3",
        "\n# c\n\t mtllib a\no b\nv 1 2 3 # c\n",
        "Exported by a program that forgets the hash\nv 1 2 3\nv 1 2 \\\n3\nf 1/1 2//2 -1/-1/-1\n",
        "v nan -nan 1.#INF\nv 1 2 3\nf x\n",
        "vt 0 0\nvn 0 0 1\nv 1 2 3\n",
        &many_comments,
    ] {
        assert!(looks_like(yes.as_bytes()), "{}", &yes[..yes.len().min(80)]);
    }
    for no in [
        "",
        "# only a comment\n\n",
        "ply\n",
        "solid\n",
        "hello",
        "<svg>",
        "g\n",
        "o",
        "mtllib a\nusemtl b\n",
        "v = 3\n",
        "v 1 2\n",
        "v one two three\n",
        "f\n",
        "f x y z\n",
        "f(1, 2)\n",
        "p\n",
        "vt\n",
    ] {
        assert!(!looks_like(no.as_bytes()), "{no}");
    }
}

#[test]
fn a_file_without_a_vertex_is_no_model() {
    for text in ["vt 0 0\nvn 0 0 1\n", "g a\n", "p 1\nl 1 2\n"] {
        let error = read(&input(text.as_bytes()), &ReadOptions::default()).unwrap_err().to_string();
        assert_eq!(error, "a.obj: expected at least one vertex (v), found none in the whole file");
    }
    let (line, expected, found) = error("# no vertices\nf 1 2 3\n");
    assert_eq!((line, found.as_str()), (2, "\"1\""));
    assert_eq!(expected, "no vertex indices (the file has no vertices)");
}

#[test]
fn companions_are_in_the_order_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..40).map(|i| format!("{}.mtl", i * 7 % 40)).collect();
    let lines: String = names.iter().map(|name| format!("mtllib {name}\nmtllib {}\n", names[0])).collect();
    let mut input = input(format!("{lines}{SQUARE}f 1 2 3\n").as_bytes());
    input.base = Some(folder.path().into());
    let model = read(&input, &ReadOptions::default()).unwrap();
    let expected: Vec<_> = names.iter().map(|name| folder.path().join(name)).collect();
    assert_eq!(model.report.companions, expected);
}

#[test]
fn one_is_reported_in_the_singular() {
    let m = model(&format!("{SQUARE}foo 1\nf 1/1 2 3\n"));
    assert_eq!(
        m.report.warnings,
        [
            "ignored 1 index of texture coordinates or normals that the file does not hold",
            "ignored 1 line that begins with an unknown word: \"foo\"",
        ]
    );
}

#[test]
fn memory_is_checked_before_it_is_taken() {
    let options = ReadOptions { memory_limit: Some(1000), progress: None, ..ReadOptions::default() };
    let text = SQUARE.repeat(8);
    let result = read(&input(text.as_bytes()), &options);
    assert!(matches!(result, Err(ReadError::MemoryLimit { .. })), "{result:?}");
}

#[test]
fn a_file_cut_anywhere_never_panics() {
    let text = format!(
        "mtllib a b.mtl\n{SQUARE}vt 0 0\nvn 0 0 1\nusemtl a\ng x\nf 1/1/1 2/1/1 3/1/1 \\\n 4/1/1\nf -4//-1 -3//-1 -1//-1\nl 1 2 -1\nusemtl b\np 3 -2\n"
    );
    for n in 0..text.len() {
        let _ = read(&input(&text.as_bytes()[..n]), &ReadOptions::default());
        let _ = looks_like(&text.as_bytes()[..n]);
    }
}

fn statement() -> impl Strategy<Value = String> {
    let c = -9i32..9;
    let i = prop_oneof![1i32..12, -4i32..0];
    prop_oneof![
        6 => (c.clone(), c.clone(), c.clone()).prop_map(|(x, y, z)| format!("v {x} {y} {z}")),
        1 => (c.clone(), c.clone()).prop_map(|(x, y)| format!("v {x} \\\n{y} 0 1 0 0.5")),
        2 => (c.clone(), c.clone()).prop_map(|(x, y)| format!("vt {x} {y}")),
        2 => (c.clone(), c).prop_map(|(x, y)| format!("vn {x} {y} 1")),
        4 => (i.clone(), i.clone(), i.clone()).prop_map(|(a, b, c)| format!("f {a} {b} {c}")),
        2 => (i.clone(), i.clone(), i.clone(), i.clone()).prop_map(|(a, b, c, d)| format!("f {a} {b} \\\n {c} {d}")),
        2 => (i.clone(), i.clone(), i.clone())
            .prop_map(|(a, b, c)| format!("f {a}/{b}/{c} {b}/{c}/1 {c}/1/{a}")),
        2 => (i.clone(), i.clone(), i.clone()).prop_map(|(a, b, c)| format!("l {a} {b} {c} x")),
        2 => (i.clone(), i).prop_map(|(a, b)| format!("p {a} {b}")),
        2 => "[abc]".prop_map(|n| format!("usemtl {n}")),
        1 => "[abc]".prop_map(|n| format!("g {n}")),
        1 => "[abc]{2}".prop_map(|n| format!("{n} \\")),
    ]
}

proptest! {
    #[test]
    fn chunks_parsed_separately_give_the_same_model(
        mut lines in prop::collection::vec(statement(), 0..40),
        step in 1usize..200,
    ) {
        // A sufficient number of each element first, so that most files are valid.
        for i in 0..11 {
            lines.insert(0, format!("v {i} 0 1\nvt {i} 0\nvn {i} 0 1"));
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.mtl"), "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nd 0.5\n").unwrap();
        lines.insert(0, "mtllib m.mtl".into());
        let text = lines.join("\n");
        let mut input = input(text.as_bytes());
        input.base = Some(folder.path().into());
        let options = ReadOptions::default();
        let whole = read_chunks(&input, &options, &[text.as_bytes()]);
        let apart = read_chunks(&input, &options, &lines::split(text.as_bytes(), step, |_| ()));
        prop_assert_eq!(format!("{whole:?}"), format!("{apart:?}"));
    }

    #[test]
    fn arbitrary_bytes_never_panic(text in "[vfntlp 0-9/\\\\\n#.-]{0,200}") {
        let _ = read(&input(text.as_bytes()), &ReadOptions::default());
    }
}
