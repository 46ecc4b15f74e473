//! Writes meshes: positions and triangles, and normals if the mesh has them and the format is PLY.

use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::Path;

use tercio_mesh::Mesh;

/// Writes a mesh as one format.
pub type Writer = fn(&Mesh, &Path) -> Result<()>;

/// Binary little-endian PLY. The rivals of the bench read only this header.
pub fn write_ply(mesh: &Mesh, path: &Path) -> Result<()> {
    let mut file = create(path)?;
    ply_header(mesh, "binary_little_endian", mesh.normals.is_some(), &mut file)?;
    for v in 0..mesh.positions.len() {
        let normal = mesh.normals.as_ref().map(|normals| unit(normals[v].decode()));
        for number in position(mesh, v).into_iter().chain(normal.into_iter().flatten()) {
            file.write_all(&number.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        file.write_all(&[3])?;
        triangle.iter().try_for_each(|corner| file.write_all(&corner.to_le_bytes()))?;
    }
    file.flush()
}

/// ASCII PLY without normals.
pub fn write_ascii_ply(mesh: &Mesh, path: &Path) -> Result<()> {
    let mut file = create(path)?;
    ply_header(mesh, "ascii", false, &mut file)?;
    for [x, y, z] in (0..mesh.positions.len()).map(|v| position(mesh, v)) {
        writeln!(file, "{x} {y} {z}")?;
    }
    mesh.triangles.iter().try_for_each(|[a, b, c]| writeln!(file, "3 {a} {b} {c}"))?;
    file.flush()
}

/// OBJ without normals.
pub fn write_obj(mesh: &Mesh, path: &Path) -> Result<()> {
    let mut file = create(path)?;
    for [x, y, z] in (0..mesh.positions.len()).map(|v| position(mesh, v)) {
        writeln!(file, "v {x} {y} {z}")?;
    }
    mesh.triangles.iter().try_for_each(|t| writeln!(file, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1))?;
    file.flush()
}

/// Binary STL: every triangle with corners of its own.
pub fn write_stl(mesh: &Mesh, path: &Path) -> Result<()> {
    let mut file = create(path)?;
    file.write_all(&[b' '; 80])?;
    let count = u32::try_from(mesh.triangles.len()).expect("triangles are numbered in 32 bits");
    file.write_all(&count.to_le_bytes())?;
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| position(mesh, v as usize));
        let [a, b, c] = corners.map(glam::Vec3::from);
        let normal = (b - a).cross(c - a).normalize_or_zero().to_array();
        for number in std::iter::once(normal).chain(corners).flatten() {
            file.write_all(&number.to_le_bytes())?;
        }
        file.write_all(&[0; 2])?;
    }
    file.flush()
}

fn create(path: &Path) -> Result<BufWriter<File>> {
    Ok(BufWriter::with_capacity(1 << 20, File::create(path)?))
}

fn ply_header(mesh: &Mesh, format: &str, normals: bool, file: &mut impl Write) -> Result<()> {
    writeln!(file, "ply\nformat {format} 1.0\nelement vertex {}", mesh.positions.len())?;
    for name in if normals { &["x", "y", "z", "nx", "ny", "nz"][..] } else { &["x", "y", "z"] } {
        writeln!(file, "property float {name}")?;
    }
    let triangles = mesh.triangles.len();
    writeln!(file, "element face {triangles}\nproperty list uchar int vertex_indices\nend_header")
}

/// World space, rounded to `f32`.
fn position(mesh: &Mesh, vertex: usize) -> [f32; 3] {
    (mesh.origin + glam::Vec3::from(mesh.positions[vertex]).as_dvec3()).as_vec3().to_array()
}

fn unit(normal: [f32; 3]) -> [f32; 3] {
    glam::Vec3::from(normal).normalize_or_zero().to_array()
}

#[cfg(test)]
mod tests {
    use tercio_mesh::io::{ReadOptions, read};

    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = tercio_mesh::builtin::make("builtin:teapot@1k").unwrap();
        let writers: [(&str, Writer); 3] =
            [("a.ply", write_ply), ("b.ply", write_ascii_ply), ("c.obj", write_obj)];
        for (name, write) in writers {
            let path = folder.path().join(name);
            write(&mesh, &path).unwrap();
            let back = read(&path, &ReadOptions::default()).unwrap().mesh;
            assert_eq!(back.triangles, mesh.triangles, "{name}");
            assert_eq!(back.positions, mesh.positions, "{name}");
        }
        let path = folder.path().join("d.stl");
        write_stl(&mesh, &path).unwrap();
        let soup = read(&path, &ReadOptions::default()).unwrap().mesh;
        let corners =
            |m: &Mesh| -> Vec<_> { m.triangles.iter().flatten().map(|&v| m.positions[v as usize]).collect() };
        assert_eq!(corners(&soup), corners(&mesh));
    }
}
