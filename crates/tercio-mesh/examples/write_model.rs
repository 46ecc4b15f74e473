//! Writes a model in several formats, to measure how fast they are read and drawn.
//!
//! `cargo run --release -p tercio-mesh --example write_model -- MODEL SUBDIVISIONS STEM`
//!
//! Reads MODEL (a file, or `builtin:NAME@COUNT`), splits each triangle into four SUBDIVISIONS times, and writes
//! STEM.ply (binary, little-endian), STEM.ascii.ply, STEM.obj and STEM.stl (binary): positions and triangles only.
//! Text files hold as many digits as are needed to read the same `f32` back.

use std::fs::File;
use std::io::{BufWriter, Write};

use tercio_mesh::io::{ReadOptions, read};
use tercio_mesh::{Mesh, builtin, subdivide::subdivide};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [model, subdivisions, stem] = args.as_slice() else {
        return Err("usage: write_model MODEL SUBDIVISIONS STEM".into());
    };
    let mut mesh = match model.starts_with("builtin:") {
        true => builtin::make(model)?,
        false => read(model, &ReadOptions::default())?.mesh,
    };
    for _ in 0..subdivisions.parse()? {
        mesh = subdivide(&mesh);
    }
    let create = |ending: &str| File::create(format!("{stem}.{ending}")).map(BufWriter::new);
    binary_ply(&mesh, &mut create("ply")?)?;
    ascii_ply(&mesh, &mut create("ascii.ply")?)?;
    obj(&mesh, &mut create("obj")?)?;
    stl(&mesh, &mut create("stl")?)?;
    Ok(())
}

fn ply_header(mesh: &Mesh, encoding: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
}

fn bytes(values: [impl Into<[u8; 4]>; 3]) -> [u8; 12] {
    let mut bytes = [0; 12];
    bytes.chunks_exact_mut(4).zip(values).for_each(|(b, v)| b.copy_from_slice(&v.into()));
    bytes
}

fn binary_ply(mesh: &Mesh, out: &mut impl Write) -> std::io::Result<()> {
    out.write_all(ply_header(mesh, "binary_little_endian").as_bytes())?;
    for p in &mesh.positions {
        out.write_all(&bytes(p.map(f32::to_le_bytes)))?;
    }
    for t in &mesh.triangles {
        out.write_all(&[3])?;
        out.write_all(&bytes(t.map(u32::to_le_bytes)))?;
    }
    out.flush()
}

fn ascii_ply(mesh: &Mesh, out: &mut impl Write) -> std::io::Result<()> {
    out.write_all(ply_header(mesh, "ascii").as_bytes())?;
    for [x, y, z] in &mesh.positions {
        writeln!(out, "{x} {y} {z}")?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    out.flush()
}

fn obj(mesh: &Mesh, out: &mut impl Write) -> std::io::Result<()> {
    for [x, y, z] in &mesh.positions {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(out, "f {a} {b} {c}")?;
    }
    out.flush()
}

fn stl(mesh: &Mesh, out: &mut impl Write) -> std::io::Result<()> {
    out.write_all(&[b' '; 80])?;
    let triangles = u32::try_from(mesh.triangles.len()).expect("triangles are numbered in 32 bits");
    out.write_all(&triangles.to_le_bytes())?;
    for t in &mesh.triangles {
        // A zero normal means that the reader computes it.
        out.write_all(&[0; 12])?;
        for v in t {
            out.write_all(&bytes(mesh.positions[*v as usize].map(f32::to_le_bytes)))?;
        }
        out.write_all(&[0; 2])?;
    }
    out.flush()
}
