//! Shares of a file are the whole file together.

use proptest::prelude::*;

use super::Shareable;
use crate::io::input::Input;
use crate::io::{ReadModel, ReadOptions, read_input};
use crate::{Mesh, ReadError};

fn input(bytes: Vec<u8>) -> Input {
    Input::from_bytes("m", bytes, &ReadOptions::default()).expect("bytes")
}

/// A PLY file of faces with these corners, of vertices with a colour; vertex k is at (k, k², 0.5).
fn ply(big: bool, vertices: u32, faces: &[Vec<u32>]) -> Vec<u8> {
    let format = if big { "big" } else { "little" };
    let mut out = format!(
        "ply\nformat binary_{format}_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n\
         property short quality\nproperty list uchar int vertex_indices\nproperty float area\nend_header\n",
        faces.len()
    )
    .into_bytes();
    let mut put = |little: &[u8]| {
        let bytes = little.iter().copied();
        if big { out.extend(bytes.rev()) } else { out.extend(bytes) }
    };
    for v in 0..vertices {
        put(&(v as f32).to_le_bytes());
        put(&((v * v) as f32).to_le_bytes());
        put(&0.5f64.to_le_bytes());
        (0..3).for_each(|k| put(&[(v * 7 + k) as u8]));
    }
    for (number, corners) in faces.iter().enumerate() {
        put(&(number as i16).to_le_bytes());
        put(&[corners.len() as u8]);
        corners.iter().for_each(|&v| put(&(v as i32).to_le_bytes()));
        put(&(number as f32 * 0.5).to_le_bytes());
    }
    out
}

/// A part, and the numbers of its vertices in the file.
type Part = (ReadModel, Option<Vec<u32>>);

/// The parts of a file.
fn parts(input: &Input, of: usize) -> Result<Vec<Part>, ReadError> {
    let shareable = Shareable::open(input)?;
    let ranges: Vec<_> = (0..of).map(|k| shareable.range(k, of)).collect();
    let uniform = ranges.iter().all(|range| shareable.is_uniform(range));
    let marks = ranges.iter().fold(u64::MAX, |marks, range| marks & shareable.marks(range));
    let origin = Some(read_input(input, &ReadOptions::default())?.mesh.origin);
    let options = ReadOptions { is_part: true, origin, ..ReadOptions::default() };
    let part = |range| {
        let share = shareable.take(range, uniform, marks, &options)?;
        Ok((share.read(&options)?, share.vertices))
    };
    ranges.iter().map(part).collect()
}

/// Positions and colours of the corners, and the values of each triangle.
type Triangle = ([[f32; 3]; 3], [[u8; 4]; 3], Vec<f32>);

fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    let colors = mesh.vertex_colors.clone().unwrap_or_else(|| vec![[0; 4]; mesh.positions.len()]);
    let of = |(number, t): (usize, &[u32; 3])| {
        let values = mesh.attributes.iter().map(|a| a.values[number]).collect();
        (t.map(|v| mesh.positions[v as usize]), t.map(|v| colors[v as usize]), values)
    };
    mesh.triangles.iter().enumerate().map(of).collect()
}

proptest! {
    #[test]
    fn shares_of_ply_are_the_whole(
        faces in prop::collection::vec(prop::collection::vec(0u32..30, 3..6), 0..40),
        big: bool, of in 1usize..7, same: bool,
    ) {
        let faces: Vec<Vec<u32>> = faces.into_iter().map(|f| if same { f[..3].to_vec() } else { f }).collect();
        let file = input(ply(big, 30, &faces));
        let whole = read_input(&file, &ReadOptions::default()).expect("a model").mesh;
        let parts = parts(&file, of).expect("parts");
        let mut all = Vec::new();
        for (part, vertices) in &parts {
            all.extend(triangles(&part.mesh));
            let vertices = vertices.as_ref().expect("a list");
            prop_assert_eq!(vertices.len(), part.mesh.positions.len());
            prop_assert!(vertices.is_sorted());
            for (&v, p) in vertices.iter().zip(&part.mesh.positions) {
                prop_assert_eq!(*p, whole.positions[v as usize]);
            }
        }
        prop_assert_eq!(all, triangles(&whole));
    }
}

#[test]
fn a_corner_that_is_no_vertex_is_an_error() {
    let file = input(ply(false, 4, &[vec![0, 1, 2], vec![1, 2, 4], vec![0, 2, 3]]));
    let error = parts(&file, 2).expect_err("vertex 4").to_string();
    assert!(error.contains("0 to 3") && error.ends_with("found 4"), "{error}");
}

#[test]
fn what_cannot_be_shared_is_refused_with_a_way_out() {
    let ascii = b"ply\nformat ascii 1.0\nelement vertex 0\nelement face 0\nend_header\n".to_vec();
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec();
    for (bytes, what) in [(ascii, "an ASCII PLY file"), (obj, "an OBJ file")] {
        let error = Shareable::open(&input(bytes)).err().expect("cannot be shared").to_string();
        assert!(error.contains(what) && error.contains("tercio prepare"), "{error}");
    }
}

/// A binary STL file of so many facets with these attribute bytes.
fn stl(attributes: &[u16]) -> Vec<u8> {
    let mut out = vec![b'x'; 80];
    out.extend((attributes.len() as u32).to_le_bytes());
    for (number, attribute) in attributes.iter().enumerate() {
        let x = number as f32;
        let corners = [[0.0, 0.0, 1.0], [x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
        out.extend(corners.iter().flatten().flat_map(|c: &f32| c.to_le_bytes()));
        out.extend(attribute.to_le_bytes());
    }
    out
}

#[test]
fn shares_of_stl_have_the_colours_of_the_whole() {
    // Colours, nothing, and bytes that mean something else in one of the parts.
    for attributes in [[0x8000, 0, 0x801f, 0, 0, 0, 0xffff], [0; 7], [0x8000, 0, 0, 0, 0, 0, 7]] {
        let file = input(stl(&attributes));
        let whole = read_input(&file, &ReadOptions::default()).expect("a model").mesh;
        for of in [1, 2, 3, 7, 9] {
            let parts = parts(&file, of).expect("parts");
            let colors: Vec<_> =
                parts.iter().flat_map(|(part, _)| part.mesh.face_colors.clone()).flatten().collect();
            let all: Vec<_> = parts.iter().flat_map(|(part, _)| triangles(&part.mesh)).collect();
            assert_eq!(all, triangles(&whole), "{of}");
            assert_eq!(whole.face_colors.clone().unwrap_or_default(), colors, "{of} parts of {attributes:?}");
        }
    }
    let mut cut = stl(&[0; 3]);
    cut.pop();
    assert!(Shareable::open(&input(cut)).err().expect("too short").to_string().contains("234 bytes"));
}
