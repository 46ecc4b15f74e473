//! Scale invariance for files: a model whose coordinates are multiplied by a power of two gives the same picture in
//! every format, through reading, repair, welding, normals and clusters.

use std::fmt::Write as _;
use std::path::Path;

use tercio::mesh::mesh::power_of_two;
use tercio::mesh::{Mesh, builtin};
use tercio::raster::{Outputs, RenderError, Renderer, Settings};
use tercio::scene::{Framing, Scene};
use tercio::{LoadOptions, Normals};

/// Positions as integers below 2^12 times a power of two, which `f32` represents down to 2^-149.
fn positions(mesh: &Mesh, exponent: i32) -> Vec<[f32; 3]> {
    let largest = mesh.positions.as_flattened().iter().fold(0.0f32, |most, c| most.max(c.abs()));
    let whole = |c: f32| f64::from((c / largest * 2000.0).round());
    mesh.positions.iter().map(|p| p.map(|c| (whole(c) * power_of_two(exponent)) as f32)).collect()
}

fn stl(mesh: &Mesh, exponent: i32) -> Vec<u8> {
    let points = positions(mesh, exponent);
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in &mesh.triangles {
        bytes.extend([0; 12]);
        bytes.extend(t.iter().flat_map(|&v| points[v as usize]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply(mesh: &Mesh, exponent: i32) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    bytes.extend(positions(mesh, exponent).iter().flatten().flat_map(|c| c.to_be_bytes()));
    for t in &mesh.triangles {
        bytes.push(3);
        bytes.extend(t.iter().flat_map(|v| v.to_be_bytes()));
    }
    bytes
}

fn obj(mesh: &Mesh, exponent: i32) -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z] in positions(mesh, exponent) {
        writeln!(text, "v {x:e} {y:e} {z:e}").expect("a string takes it");
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).expect("a string takes it");
    }
    text.into_bytes()
}

/// Colours, ids and normals of the default view, as bits. If distances are out of range of `f32`, it draws without
/// depth.
fn picture(path: &Path, crease_angle: Option<f64>) -> (Vec<[u8; 4]>, Vec<u32>, Vec<u32>) {
    let options = LoadOptions { normals: Normals::FileOrMade { crease_angle }, ..LoadOptions::default() };
    let loaded = options.load(path).expect("a model");
    assert_eq!(loaded.report.cleaned.total(), 0, "{:?}", loaded.report.cleaned);
    let scene = Scene::from_mesh(loaded.mesh);
    let camera = Framing::new(160, 120).camera_for_scene(&scene);
    let outputs = Outputs { color: true, depth: true, ids: true, normals: true, ..Outputs::default() };
    let mut settings = Settings { outputs, ..Settings::one_sample(160, 120) };
    let mut frame = Renderer::new().render(&scene, &camera, &settings);
    if let Err(RenderError::Distances { farthest }) = frame {
        assert!(!(farthest as f32).is_normal(), "{farthest}");
        settings.outputs.depth = false;
        frame = Renderer::new().render(&scene, &camera, &settings);
    }
    let frame = frame.expect("a picture");
    let shown = frame.planes.ids.iter().filter(|&&id| id != u32::MAX).count();
    assert!(shown * 10 > frame.planes.ids.len(), "{shown} pixels show something");
    (
        frame.planes.color,
        frame.planes.ids,
        frame.planes.normals.as_flattened().iter().map(|c| c.to_bits()).collect(),
    )
}

/// Writes a mesh times a power of two as a file.
type Write = fn(&Mesh, i32) -> Vec<u8>;

#[test]
fn files_of_any_scale_give_the_same_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let models =
        [("builtin:teapot@2k", Some(1.0)), ("builtin:gyroid@3k", None), ("builtin:sphere@8", Some(0.5))];
    let formats: [(&str, Write); 3] = [("stl", stl), ("ply", ply), ("obj", obj)];
    for (spec, crease_angle) in models {
        let mesh = builtin::make(spec).expect("a model");
        for (format, write) in formats {
            let path = folder.path().join(format!("model.{format}"));
            let at = |exponent: i32| {
                std::fs::write(&path, write(&mesh, exponent)).expect("a file");
                picture(&path, crease_angle)
            };
            let plain = at(0);
            for exponent in [-149, -130, -90, -42, 1, 30, 90, 105, 116] {
                let scaled = at(exponent);
                let different = plain.0.iter().zip(&scaled.0).filter(|(a, b)| a != b).count();
                assert!(plain == scaled, "{spec}.{format} times 2^{exponent}: {different} colours differ");
            }
        }
    }
}
