//! The picture does not depend on which corner of a triangle comes first, nor on the order of triangles.

mod common;

use common::*;
use tercio_mesh::Mesh;
use tercio_raster::frame::NO_PRIMITIVE;
use tercio_raster::{Frame, Settings, Shading, SimdLevel};
use tercio_scene::Camera;

/// Rotates the corners of every triangle by 0, 1 or 2 positions; with `mixed`, not all by the same number.
fn turned(mesh: &Mesh, by: usize, mixed: bool) -> Mesh {
    let mut mesh = mesh.clone();
    for (i, t) in mesh.triangles.iter_mut().enumerate() {
        t.rotate_left(if mixed { (by + i * 7 / 3) % 3 } else { by });
    }
    mesh
}

fn views() -> [(&'static str, Camera); 3] {
    [
        ("outside", perspective([1.0, 1.5, 2.5], [0.0; 3], 40.0)),
        ("inside", perspective([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 100.0)),
        ("parallel", orthographic([1.0, 1.5, 2.5], [0.0; 3], 2.5)),
    ]
}

fn models() -> [(&'static str, Mesh); 3] {
    let bare = Mesh { normals: None, ..sphere(12) };
    [("soup", soup(3000, 31)), ("sphere", sphere(20)), ("bare sphere", bare)]
}

#[test]
fn turned_triangles_draw_the_same_bytes() {
    for (name, mesh) in models() {
        for (view, camera) in views() {
            for shading in [Shading::Flat, Shading::Gouraud, Shading::Phong] {
                let settings = Settings { shading, ..everything(140, 100) };
                let expected = draw_reference(&mesh, &scene(&mesh), &camera, &settings);
                for (by, mixed) in [(1, false), (2, false), (0, true)] {
                    let turned = turned(&mesh, by, mixed);
                    let plain = scene(&turned);
                    let what = format!("{name}, {view}, {shading:?}, by {by}, mixed {mixed}");
                    assert_same(&expected, &draw_reference(&turned, &plain, &camera, &settings), &what);
                    for simd in SimdLevel::available() {
                        let s = Settings { simd: Some(simd), ..settings.clone() };
                        assert_same(&expected, &draw(&plain, &camera, &s), &format!("{what}, {simd}"));
                    }
                }
            }
        }
    }
}

/// A random permutation of 0..n (Fisher and Yates).
fn permutation(n: usize, seed: u64) -> Vec<u32> {
    let mut random = Random(seed);
    let mut order: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        order.swap(i, (random.next() * (i + 1) as f64) as usize);
    }
    order
}

fn shuffled(mesh: &Mesh, order: &[u32]) -> Mesh {
    let triangles = order.iter().map(|&t| mesh.triangles[t as usize]).collect();
    Mesh { triangles, ..mesh.clone() }
}

fn same_depth(a: &Frame, b: &Frame) -> bool {
    a.planes.depth.iter().zip(&b.planes.depth).all(|(a, b)| a.to_bits() == b.to_bits())
}

#[test]
fn shuffled_triangles_draw_the_same_surface() {
    for (name, mesh) in models() {
        let order = permutation(mesh.triangles.len(), 32);
        assert!(order.iter().enumerate().filter(|(i, t)| *i != **t as usize).count() > 100);
        let other = shuffled(&mesh, &order);
        for (view, camera) in views() {
            let settings = everything(140, 100);
            let a = draw(&scene(&mesh), &camera, &settings);
            let mut b = draw(&scene(&other), &camera, &settings);
            for id in b.planes.ids.iter_mut().filter(|id| **id != NO_PRIMITIVE) {
                *id = order[*id as usize];
            }
            // The lower half of a key is `NO_PRIMITIVE` minus the number of the triangle.
            for key in b.planes.keys.iter_mut().filter(|key| **key != 0) {
                let number = NO_PRIMITIVE - *key as u32;
                *key = *key >> 32 << 32 | u64::from(NO_PRIMITIVE - order[number as usize]);
            }
            assert_same(&a, &b, &format!("{name}, {view}"));
        }
    }
}

#[test]
fn among_equal_depths_the_lower_number_is_visible() {
    for (name, mesh) in models() {
        let n = mesh.triangles.len() as u32;
        // Every triangle twice, in random order.
        let order: Vec<u32> = permutation(2 * n as usize, 33).into_iter().map(|t| t % n).collect();
        let doubled = shuffled(&mesh, &order);
        let mut first = vec![NO_PRIMITIVE; n as usize];
        for (number, &t) in order.iter().enumerate().rev() {
            first[t as usize] = number as u32;
        }
        for (view, camera) in views() {
            let settings = everything(140, 100);
            let single = draw(&scene(&mesh), &camera, &settings);
            let mut seen = 0;
            for simd in SimdLevel::available() {
                let settings = Settings { simd: Some(simd), ..settings.clone() };
                let double = draw(&scene(&doubled), &camera, &settings);
                assert!(same_depth(&single, &double), "{name}, {view}, {simd}");
                for (p, (&one, &two)) in single.planes.ids.iter().zip(&double.planes.ids).enumerate() {
                    let expected = first.get(one as usize).copied().unwrap_or(NO_PRIMITIVE);
                    assert_eq!(two, expected, "{name}, {view}, {simd}, pixel {p}, {one} in the single mesh");
                    seen += usize::from(one != NO_PRIMITIVE);
                }
            }
            assert!(seen > 1000, "{name}, {view}: {seen} pixels");
        }
    }
}
