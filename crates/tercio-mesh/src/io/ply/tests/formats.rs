//! What the format allows.

use super::*;
use crate::{AttributeDomain, FileTexture, Mesh, OctNormal};

#[test]
fn every_scalar_type_in_every_encoding() {
    let types = [
        ("char", "int8", -7.0),
        ("uchar", "uint8", 200.0),
        ("short", "int16", -3000.0),
        ("ushort", "uint16", 60000.0),
        ("int", "int32", -8_000_000.0),
        ("uint", "uint32", 3_000_000_000.0),
        ("float", "float32", 0.1f32.into()),
        ("double", "float64", 0.1),
    ];
    for (old, new, value) in types {
        for name in [old, new] {
            let property: &'static str = format!("{name} quality").leak();
            let list_type: &'static str = format!("list {name} {name} vertex_indices").leak();
            for encoding in ENCODINGS {
                let mut v = square();
                v.properties.insert(1, property);
                v.rows.iter_mut().for_each(|row| row.insert(1, Value::One(value)));
                let mut f = faces(&[vec![0, 1, 2, 3]]);
                if !name.contains("float") && name != "double" {
                    f.properties = vec![list_type];
                }
                let model = read_ok(encode(encoding, &[v, f]));
                assert_eq!(model.mesh.positions[2], [1.0, 1.0, 0.0], "{name} {encoding}");
                assert_eq!(model.mesh.attributes[0].name, "quality");
                // A constant that `f32` does not hold is in the offset.
                let attribute = &model.mesh.attributes[0];
                let full: Vec<f64> = attribute.values.iter().map(|&v| attribute.full(v)).collect();
                assert_eq!(full, [value; 4], "{name} {encoding}");
                assert_eq!(model.mesh.triangles.len(), 2);
            }
        }
    }
}

#[test]
fn mixed_polygons_have_face_numbers() {
    let polygons = [vec![0, 1, 2], vec![0, 1, 2, 3], vec![], vec![0, 1], vec![3, 2, 1]];
    for encoding in ENCODINGS {
        let model = read_ok(encode(encoding, &[square(), faces(&polygons)]));
        assert_eq!(model.mesh.triangles.len(), 4);
        assert_eq!(model.mesh.triangles[0], [0, 1, 2]);
        assert_eq!(model.mesh.triangles[3], [3, 2, 1]);
        assert_eq!(model.mesh.face_of_triangle, Some(vec![0, 1, 1, 4]));
        assert_eq!((model.report.faces, model.report.not_drawn.lines), (3, 1));
        assert!(model.report.warnings[0].contains("no corners"), "{:?}", model.report.warnings);
    }
}

#[test]
fn triangles_alone_need_no_face_numbers() {
    for encoding in ENCODINGS {
        let model = read_ok(encode(encoding, &[square(), faces(&[vec![0, 1, 2], vec![0, 2, 3]])]));
        assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(model.mesh.face_of_triangle, None);
        assert_eq!(model.report.faces, 2);
        assert!(model.report.warnings.is_empty());
    }
}

#[test]
fn elements_in_any_order_and_unknown_ones_between() {
    let extra = Sheet {
        name: "thing",
        properties: vec!["uchar a", "list ushort double b", "list uchar char c", "short d"],
        rows: vec![
            vec![Value::One(1.0), list(&[1, 2, 3]), list(&[]), Value::One(7.0)],
            vec![Value::One(1.0), list(&[]), list(&[9, 9]), Value::One(7.0)],
        ],
    };
    let f = faces(&[vec![0, 1, 2, 3], vec![0, 1, 2]]);
    for encoding in ENCODINGS {
        let plain = read_ok(encode(encoding, &[square(), f.clone()]));
        let mixed = [extra.clone(), f.clone(), Sheet { name: "other", ..extra.clone() }, square()];
        let mixed = read_ok(encode(encoding, &mixed));
        assert_same(&plain, &mixed);
        assert_eq!(mixed.report.warnings.len(), 2, "{:?}", mixed.report.warnings);
    }
}

#[test]
fn vertices_and_faces_with_further_lists() {
    let mut v = square();
    v.properties.insert(2, "list uchar short neighbours");
    v.rows.iter_mut().enumerate().for_each(|(i, row)| row.insert(2, list(&vec![5; i])));
    let mut f = faces(&[vec![0, 1, 2], vec![0, 2, 3]]);
    f.properties.insert(0, "list uint uchar flags");
    f.rows.iter_mut().for_each(|row| row.insert(0, list(&[1, 2])));
    for encoding in ENCODINGS {
        let model = read_ok(encode(encoding, &[v.clone(), f.clone()]));
        assert_eq!(model.mesh.positions[3], [0.0, 1.0, 0.0]);
        assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(model.report.warnings.len(), 2);
    }
}

#[test]
fn strips_turn_every_second_triangle_and_restart() {
    let strips = Sheet {
        name: "tristrips",
        properties: vec!["list int int vertex_indices"],
        rows: vec![vec![Value::List(vec![0., 1., 2., 3., 3., 2., -1., 1., 2., 3., -1., 0., 1.])]],
    };
    for encoding in ENCODINGS {
        let model = read_ok(encode(encoding, &[square(), strips.clone()]));
        assert_eq!(model.mesh.triangles, [[0, 1, 2], [2, 1, 3], [1, 2, 3]]);
        assert_eq!(model.report.faces, 3);
        let both = read_ok(encode(encoding, &[square(), strips.clone(), faces(&[vec![0, 1, 2, 3]])]));
        assert_eq!(both.mesh.triangles.len(), 5);
        assert_eq!(both.mesh.face_of_triangle, Some(vec![0, 0, 1, 2, 3]));
        assert_eq!(both.report.faces, 4);
    }
}

#[test]
fn all_line_ends_and_loose_headers() {
    let text = "  ply \n format ascii 1.0\nobj_info x\n\telement vertex 3\nproperty float x\ncomment y\n \
                property  float y\nproperty float z\n\nWritten by hand\nelement face 1\n\
                property list uchar int vertex_index\ncomment\nend_header \n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let plain = read_ok(text);
    assert_eq!(plain.mesh.triangles, [[0, 1, 2]]);
    assert_eq!(plain.report.warnings.len(), 1);
    assert_same(&plain, &read_ok(text.replace('\n', "\r\n")));
    assert_same(&plain, &read_ok(text.replace('\n', "\r")));
    let error = try_read(text.replace("3 0 1 2", "3 0 1 x").replace('\n', "\r")).unwrap_err().to_string();
    assert!(error.starts_with("test.ply: line 18: "), "{error}");
}

#[test]
fn binary_after_every_line_end() {
    let sheets = [vertices(&[[f32::from_bits(0x0a0a_0a0a); 3]; 3]), faces(&[vec![0, 1, 2]])];
    for encoding in &ENCODINGS[1..] {
        let bytes = encode(encoding, &sheets);
        let plain = read_ok(bytes.clone());
        let header = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        for end in ["\r\n", "\r"] {
            let text = String::from_utf8(bytes[..header].to_vec()).unwrap().replace('\n', end);
            assert_same(&plain, &read_ok([text.as_bytes(), &bytes[header..]].concat()));
        }
    }
}

#[test]
fn colours_of_every_type() {
    for (ty, names, values, expected) in [
        ("uchar", ["red", "green", "blue"], [255.0, 0.0, 128.0], [255, 0, 128, 255]),
        ("float", ["diffuse_red", "diffuse_green", "diffuse_blue"], [1.0, -1.0, 0.5], [255, 0, 128, 255]),
        ("ushort", ["r", "g", "b"], [65535.0, 0.0, 32768.0], [255, 0, 128, 255]),
        ("double", ["red", "green", "blue"], [7.0, -3.0, 0.2], [255, 0, 51, 255]),
    ] {
        for encoding in ENCODINGS {
            let (mut v, mut f) = (square(), faces(&[vec![0, 1, 2, 3]]));
            for (name, value) in names.iter().zip(values) {
                let property: &'static str = format!("{ty} {name}").leak();
                v.properties.push(property);
                v.rows.iter_mut().for_each(|row| row.push(Value::One(value)));
                f.properties.push(property);
                f.rows[0].push(Value::One(value));
            }
            let model = read_ok(encode(encoding, &[v, f]));
            assert_eq!(model.mesh.vertex_colors, Some(vec![expected; 4]));
            assert_eq!(model.mesh.face_colors, Some(vec![expected; 2]));
            assert!(model.mesh.attributes.is_empty());
        }
    }
}

#[test]
fn colours_that_are_not_finite_become_white() {
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    let colors =
        [[0.2, nan, 0.4, 0.6], [infinite, 0.0, 0.0, 1.0], [0.2, 0.4, 0.6, nan], [0.2, 0.4, 0.6, 0.8]];
    let expected = [[255, 255, 255, 153], [255; 4], [51, 102, 153, 255], [51, 102, 153, 204]];
    for ty in ["float", "double"] {
        for encoding in ENCODINGS {
            let (mut v, mut f) = (square(), faces(&[vec![0, 1, 2]]));
            for name in ["red", "green", "blue", "alpha"] {
                let property: &'static str = format!("{ty} {name}").leak();
                v.properties.push(property);
                f.properties.push(property);
            }
            v.rows.iter_mut().zip(&colors).for_each(|(row, color)| row.extend(one(color)));
            f.rows[0].extend(one(&colors[0]));
            let model = read_ok(encode(encoding, &[v, f]));
            assert_eq!(model.mesh.vertex_colors.as_deref(), Some(&expected[..]), "{encoding}");
            assert_eq!(model.mesh.face_colors.as_deref(), Some(&expected[..1]), "{encoding}");
            assert_eq!(
                model.report.warnings,
                [
                    "set 3 colours of vertices that were not finite to white",
                    "set 1 colour of faces that were not finite to white"
                ]
            );
        }
    }
}

#[test]
fn normals_may_have_any_length_but_zero() {
    let lengths = [1e-300, 1e-30, 1e30, 0.0];
    let mut v = square();
    v.properties.extend(["double nx", "double ny", "double nz"]);
    v.rows.iter_mut().zip(lengths).for_each(|(row, l)| row.extend(one(&[0.0, -l, l])));
    let (slanted, none) = (OctNormal::encode([0.0, -1.0, 1.0]), OctNormal::NONE);
    for encoding in ENCODINGS {
        let mesh = read_ok(encode(encoding, &[v.clone(), faces(&[vec![0, 1, 2, 3]])])).mesh;
        assert_eq!(mesh.normals, Some(vec![slanted, slanted, slanted, none]), "{encoding}");
    }
}

#[test]
fn normals_texcoords_and_attributes() {
    let mut v = square();
    v.properties.extend(["float nx", "float ny", "float nz", "float s", "float t", "uchar red", "int label"]);
    v.rows.iter_mut().for_each(|row| row.extend(one(&[0.0, -3.0, 0.0, 0.25, 0.75, 9.0, -4.0])));
    let mut f = faces(&[vec![0, 1, 2], vec![0, 1, 2, 3]]);
    f.properties.push("double area");
    f.rows[0].push(Value::One(0.5));
    f.rows[1].push(Value::One(1.0));
    for encoding in ENCODINGS {
        let mesh = read_ok(encode(encoding, &[v.clone(), f.clone()])).mesh;
        assert_eq!(mesh.normals, Some(vec![OctNormal::encode([0.0, -1.0, 0.0]); 4]));
        assert_eq!(mesh.texcoords, Some(vec![[0.25, 0.75]; 4]));
        assert_eq!(mesh.vertex_colors, None, "red alone is no colour");
        let shown: Vec<_> =
            mesh.attributes.iter().map(|a| (a.name.as_str(), a.domain, &a.values[..])).collect();
        assert_eq!(
            shown,
            [
                ("red", AttributeDomain::Vertex, &[9.0; 4][..]),
                ("label", AttributeDomain::Vertex, &[-4.0; 4][..]),
                ("area", AttributeDomain::Triangle, &[0.5, 1.0, 1.0][..]),
            ]
        );
    }
}

#[test]
fn texture_seams_split_vertices() {
    let f = Sheet {
        name: "face",
        properties: vec!["list uchar int vertex_indices", "list uchar float texcoord", "int texnumber"],
        rows: vec![
            vec![list(&[0, 1, 2]), Value::List(vec![0., 0., 1., 0., 1., 1.]), Value::One(0.0)],
            vec![list(&[0, 2, 3]), Value::List(vec![0., 0., 0.5, 0.5, 0., 1.]), Value::One(1.0)],
            vec![list(&[0, 2, 1]), Value::List(vec![]), Value::One(-1.0)],
        ],
    };
    for encoding in ENCODINGS {
        let bytes = encode(encoding, &[square(), f.clone()]);
        let at = bytes.windows(7).position(|w| w == b"comment").unwrap();
        let textures = b"comment TextureFile a  b.png\ncomment TextureFile c.png\n";
        let model = read_ok([&bytes[..at], textures, &bytes[at..]].concat());
        let mesh = &model.mesh;
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 4, 3], [0, 5, 6]]);
        assert_eq!(mesh.positions[4..], [[1., 1., 0.], [1., 1., 0.], [1., 0., 0.]]);
        let uv = mesh.texcoords.as_ref().unwrap();
        assert_eq!(uv[..], [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0.5, 0.5], [0., 0.], [0., 0.]]);
        assert_eq!(mesh.materials[0].textures.diffuse, Some(FileTexture::new("a  b.png")));
        assert_eq!(mesh.triangle_materials, Some(vec![0, 1, Mesh::NO_MATERIAL]));
        assert_eq!(model.report.warnings.len(), 1);
        // Numbers of textures that the file does not name.
        let one = [&bytes[..at], b"comment TextureFile a.png\n", &bytes[at..]].concat();
        for (bytes, expected) in [
            (
                one,
                "did not draw textures of 1 triangle: the file names 1 texture, and their texnumber is none of these",
            ),
            (
                bytes,
                "did not draw textures of 2 triangles: the file names 0 textures, and their texnumber is none of these",
            ),
        ] {
            let warnings = read_ok(bytes).report.warnings;
            assert!(warnings.iter().any(|warning| warning == expected), "{warnings:?}");
        }
    }
}

#[test]
fn far_models_keep_their_detail() {
    let far = |x: f64| [500_000.0 + x, 4_000_000.0, 100.0];
    let rows: Vec<Vec<Value>> = [0.0, 0.125, 0.25].iter().map(|&x| one(&far(x))).collect();
    let wide = ["double x", "double y", "double z"];
    for properties in [wide, ["float x", "float y", "float z"]] {
        for encoding in ENCODINGS {
            let v = Sheet { name: "vertex", properties: properties.to_vec(), rows: rows.clone() };
            let mesh = read_ok(encode(encoding, &[v])).mesh;
            assert_eq!(mesh.origin.y, 4_000_000.0);
            assert_eq!(mesh.positions[1][0] - mesh.positions[0][0], 0.125);
        }
    }
}

#[test]
fn point_clouds_are_counted() {
    let edges = Sheet {
        name: "edge",
        properties: vec!["int vertex1", "int vertex2"],
        rows: vec![one(&[0.0, 1.0]); 2],
    };
    for encoding in ENCODINGS {
        let whole = |sheets: &[Sheet]| {
            let options = ReadOptions::default();
            let input = Input::from_bytes("test.ply", encode(encoding, sheets), &options).unwrap();
            crate::io::read_input(&input, &options).unwrap()
        };
        assert_eq!(whole(&[square()]).report.not_drawn.points, 4);
        let model = whole(&[square(), edges.clone(), faces(&[])]);
        assert_eq!((model.report.not_drawn.points, model.report.not_drawn.lines), (0, 2));
        assert!(model.mesh.triangles.is_empty() && model.mesh.positions.len() == 4);
        assert_eq!(read_ok(encode(encoding, &[])).mesh.positions.len(), 0);
    }
}

#[test]
fn surplus_on_a_line_is_ignored() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nelement face 2\nproperty list uchar int vertex_indices\n\
                property uchar flag\nend_header\n";
    let model = read_ok(format!("{head}0 0 0\n1 0 0\n0 1 0 \n3 0 1 2 9 1 1 1\n\n3 0 2 1 9 1 1\n"));
    assert_eq!(model.mesh.triangles, [[0, 1, 2], [0, 2, 1]]);
    assert!(model.mesh.attributes.is_empty());
    assert_eq!(model.report.warnings.len(), 1, "{:?}", model.report.warnings);
}

#[test]
fn the_magic_word_is_a_word_of_its_own() {
    let looks_like = |bytes: &[u8]| {
        super::super::looks_like(&Input::from_bytes("a", bytes.to_vec(), &ReadOptions::default()).unwrap())
    };
    assert!(looks_like(b"ply\r\nformat") && looks_like(b" ply\n") && looks_like(b"ply"));
    assert!(!looks_like(b"plywood\n") && !looks_like(b"") && !looks_like(b"pl"));
}

/// Found by the fuzzer: zeros at the end of a file were removed from the header, so the header was longer than the
/// file.
#[test]
fn zeros_on_the_last_line_of_a_header() {
    let header =
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n";
    for end in ["end_header \0\0", "end_header \0\0\n\0\0", "end_header \0\n"] {
        let model = read_ok(format!("{header}{end}"));
        assert_eq!(model.mesh.positions.len(), 0, "{end:?}");
    }
    // A missing vertex is an error, not a zero.
    let header = header.replace("vertex 0", "vertex 1");
    assert!(try_read(format!("{header}end_header \0\0\0\0\0\0\0\0")).is_err());
}
