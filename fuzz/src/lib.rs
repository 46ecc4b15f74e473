//! Shared by the fuzz targets: reading bytes as a model, and the invariants of every model that is read and of every
//! [`picture`] of it.

#![forbid(unsafe_code)]

pub mod picture;

use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadModel, ReadOptions};
use tercio_mesh::{AttributeDomain, ReadError};

/// A function that reads a model.
pub type Read = fn(&Input, &ReadOptions) -> Result<ReadModel, ReadError>;

/// Far below libFuzzer's own limit, so that a reader that exceeds its memory limit is detected; and so low that an input of some bytes
/// that stands for a large grid is refused, before it takes its time.
const MEMORY_LIMIT: u64 = 64 << 20;

/// Reads the bytes with `read`. An error is a valid result: only a panic, a hang, too much memory or an inconsistent
/// model is a failure.
///
/// Format targets pass the reader of the format, whatever the bytes begin with: it has to cope with any input.
///
/// # Panics
/// If the reader does, or if its model is inconsistent.
pub fn read_bytes(read: Read, bytes: &[u8]) {
    allow_damage();
    let options = ReadOptions { memory_limit: Some(MEMORY_LIMIT), ..ReadOptions::default() };
    let result = Input::from_bytes("fuzz", bytes.to_vec(), &options).and_then(|input| read(&input, &options));
    match result {
        Ok(model) => check(&model),
        // Formatting the message must not fail either: it contains bytes of the input.
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Panics of libraries that mean damaged data are errors, as the program reports them; libFuzzer ends with any panic.
pub fn allow_damage() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let other = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if tercio_mesh::guard::damage().is_none() {
                other(panic);
            }
        }));
    });
}

fn check(ReadModel { mesh, strokes, .. }: &ReadModel) {
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    assert!(mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < vertices), "index outside");
    let belongs = |what: &str, length: Option<usize>, elements: usize| {
        assert!(length.is_none_or(|length| length == elements), "{length:?} {what}, not {elements}");
    };
    belongs("normals", mesh.normals.as_ref().map(Vec::len), vertices);
    belongs("vertex colours", mesh.vertex_colors.as_ref().map(Vec::len), vertices);
    belongs("face colours", mesh.face_colors.as_ref().map(Vec::len), triangles);
    belongs("texture coordinates", mesh.texcoords.as_ref().map(Vec::len), vertices);
    belongs("triangle materials", mesh.triangle_materials.as_ref().map(Vec::len), triangles);
    belongs("face numbers", mesh.face_of_triangle.as_ref().map(Vec::len), triangles);
    let drawn = strokes.segments.as_flattened().iter().chain(&strokes.points);
    assert!({ drawn }.all(|&v| (v as usize) < strokes.positions.len()), "index of a line or point outside");
    belongs("colours of strokes", strokes.colors.as_ref().map(Vec::len), strokes.positions.len());
    for attribute in &strokes.attributes {
        belongs(&attribute.name, Some(attribute.values.len()), strokes.positions.len());
    }
    for attribute in &mesh.attributes {
        let elements = match attribute.domain {
            AttributeDomain::Vertex => vertices,
            AttributeDomain::Triangle => triangles,
        };
        belongs(&attribute.name, Some(attribute.values.len()), elements);
    }
    for &material in mesh.triangle_materials.iter().flatten() {
        let known = (material as usize) < mesh.materials.len();
        assert!(known || material == tercio_mesh::Mesh::NO_MATERIAL, "material {material}");
    }
}
