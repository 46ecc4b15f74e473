//! Tests the reader with files that are written here, in all encodings.

mod errors;
mod formats;
mod random;

use super::read;
use crate::ReadError;
use crate::io::{ReadModel, ReadOptions, input::Input};

/// One value of an instance.
#[derive(Clone, Debug)]
enum Value {
    One(f64),
    List(Vec<f64>),
}

/// One element: its name, its property declarations ("float x", "list uchar int vertex_indices"), its rows.
#[derive(Clone, Debug)]
struct Sheet {
    name: &'static str,
    properties: Vec<&'static str>,
    rows: Vec<Vec<Value>>,
}

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

fn one(values: &[f64]) -> Vec<Value> {
    values.iter().map(|&v| Value::One(v)).collect()
}

fn list(values: &[u32]) -> Value {
    Value::List(values.iter().map(|&v| v.into()).collect())
}

/// Vertices with `float x y z` only.
fn vertices(points: &[[f32; 3]]) -> Sheet {
    Sheet {
        name: "vertex",
        properties: vec!["float x", "float y", "float z"],
        rows: points.iter().map(|p| one(&p.map(f64::from))).collect(),
    }
}

/// Faces with only their corners.
fn faces(polygons: &[Vec<u32>]) -> Sheet {
    Sheet {
        name: "face",
        properties: vec!["list uchar int vertex_indices"],
        rows: polygons.iter().map(|p| vec![list(p)]).collect(),
    }
}

fn square() -> Sheet {
    vertices(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]])
}

fn write_number(out: &mut Vec<u8>, encoding: &str, ty: &str, v: f64) {
    macro_rules! as_type {
        ($t:ty) => {{
            let v = v as $t;
            match encoding {
                "ascii" => out.extend(format!("{v} ").bytes()),
                "binary_little_endian" => out.extend(v.to_le_bytes()),
                _ => out.extend(v.to_be_bytes()),
            }
        }};
    }
    match ty {
        "char" | "int8" => as_type!(i8),
        "uchar" | "uint8" => as_type!(u8),
        "short" | "int16" => as_type!(i16),
        "ushort" | "uint16" => as_type!(u16),
        "int" | "int32" => as_type!(i32),
        "uint" | "uint32" => as_type!(u32),
        "float" | "float32" => as_type!(f32),
        _ => as_type!(f64),
    }
}

fn encode(encoding: &str, sheets: &[Sheet]) -> Vec<u8> {
    let mut out = format!("ply\nformat {encoding} 1.0\ncomment made by a test\n").into_bytes();
    for sheet in sheets {
        out.extend(format!("element {} {}\n", sheet.name, sheet.rows.len()).bytes());
        for property in &sheet.properties {
            out.extend(format!("property {property}\n").bytes());
        }
    }
    out.extend(b"end_header\n");
    for sheet in sheets {
        for row in &sheet.rows {
            for (property, value) in sheet.properties.iter().zip(row) {
                let words: Vec<&str> = property.split(' ').collect();
                match value {
                    Value::One(v) => write_number(&mut out, encoding, words[0], *v),
                    Value::List(items) => {
                        write_number(&mut out, encoding, words[1], items.len() as f64);
                        items.iter().for_each(|&v| write_number(&mut out, encoding, words[2], v));
                    }
                }
            }
            if encoding == "ascii" {
                out.push(b'\n');
            }
        }
    }
    out
}

fn try_read(bytes: impl Into<Vec<u8>>) -> Result<ReadModel, ReadError> {
    let options = ReadOptions::default();
    read(&Input::from_bytes("test.ply", bytes.into(), &options)?, &options)
}

#[track_caller]
fn read_ok(bytes: impl Into<Vec<u8>>) -> ReadModel {
    try_read(bytes).unwrap_or_else(|e| panic!("{e}"))
}

/// Fails if two meshes differ in any bit.
#[track_caller]
fn assert_same(a: &ReadModel, b: &ReadModel) {
    let bits =
        |m: &ReadModel| -> Vec<[u32; 3]> { m.mesh.positions.iter().map(|p| p.map(f32::to_bits)).collect() };
    assert_eq!(a.mesh.origin, b.mesh.origin);
    assert_eq!(bits(a), bits(b));
    assert_eq!(a.mesh.triangles, b.mesh.triangles);
    assert_eq!(a.mesh.normals, b.mesh.normals);
    assert_eq!(a.mesh.vertex_colors, b.mesh.vertex_colors);
    assert_eq!(a.mesh.face_colors, b.mesh.face_colors);
    assert_eq!(a.mesh.texcoords, b.mesh.texcoords);
    assert_eq!(a.mesh.attributes, b.mesh.attributes);
    assert_eq!(a.mesh.face_of_triangle, b.mesh.face_of_triangle);
    assert_eq!(a.report.faces, b.report.faces);
    assert_eq!(a.report.not_drawn, b.report.not_drawn);
}
