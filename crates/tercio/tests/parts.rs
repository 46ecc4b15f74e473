//! Models in parts: all ranks together load what one process loads of the whole model, bit for bit.

use std::path::{Path, PathBuf};

use tercio::mesh::cluster::MAX_TRIANGLES;
use tercio::mesh::{ClusteredMesh, Mesh, OctNormal, builtin};
use tercio::parallel::comm::threads;
use tercio::{LoadOptions, LoadedPart, Normals};

/// A triangle as it is drawn: corners in the order of the whole model's vertices, normals and colours.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    primitive: u64,
    face: u64,
    corners: [[f32; 3]; 3],
    normals: Option<[OctNormal; 3]>,
    vertex_colors: Option<[[u8; 4]; 3]>,
    face_color: Option<[u8; 4]>,
}

fn drawn(mesh: &ClusteredMesh, first_triangle: u64, first_face: u64) -> Vec<Drawn> {
    let mut all = Vec::new();
    for (number, cluster) in mesh.views().enumerate() {
        for t in 0..cluster.triangles() {
            assert!(t < MAX_TRIANGLES);
            let corners = cluster.corners_of(t).map(usize::from);
            all.push(Drawn {
                primitive: first_triangle + u64::from(cluster.primitive(t)),
                face: first_face + u64::from(mesh.face(number, t)),
                corners: cluster.corner_positions(t),
                normals: cluster.normals().map(|n| corners.map(|v| n[v])),
                vertex_colors: cluster.vertex_colors().map(|c| corners.map(|v| c[v])),
                face_color: cluster.face_colors().map(|c| c[t]),
            });
        }
    }
    all.sort_by_key(|drawn| drawn.primitive);
    all
}

fn options() -> [LoadOptions<'static>; 2] {
    let smooth = Normals::FileOrMade { crease_angle: None };
    [LoadOptions::default(), LoadOptions { normals: smooth, ..LoadOptions::default() }]
}

/// Loads the parts and compares them with the whole.
fn check(model: &Path, whole: &Path, ranks: &[usize]) {
    for options in options() {
        let expected = options.load(whole).expect("the whole model");
        let triangles = drawn(&expected.mesh, 0, 0);
        for &count in ranks {
            let parts: Vec<LoadedPart> =
                threads::run(count, |comm| Ok(options.load_part(comm, model).expect("a part")))
                    .expect("ranks");
            let mut all = Vec::new();
            for LoadedPart { loaded, share, .. } in &parts {
                assert_eq!(loaded.mesh.bounds, expected.mesh.bounds, "{count} ranks");
                assert_eq!(loaded.mesh.origin, expected.mesh.origin);
                assert_eq!(loaded.mesh.exponent, expected.mesh.exponent);
                assert_eq!(loaded.mesh.is_translucent(), expected.mesh.is_translucent());
                assert_eq!(share.triangles, triangles.len() as u64);
                all.extend(drawn(&loaded.mesh, share.first_triangle, share.first_face));
            }
            all.sort_by_key(|drawn| drawn.primitive);
            assert_eq!(all.len(), triangles.len(), "{} of {count} ranks", model.display());
            let different = all.iter().zip(&triangles).find(|(part, whole)| part != whole);
            assert_eq!(different, None, "{} of {count} ranks", model.display());
            let most = parts.iter().map(|part| part.loaded.mesh.triangle_count()).max().unwrap_or(0);
            assert!(
                most <= triangles.len() / count + triangles.len() / 50 + 20_000,
                "{most} of {count} ranks"
            );
        }
    }
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("room for a file");
    path
}

/// Binary PLY; faces with four corners where two triangles share the edge of a quad if `quads`.
fn ply(mesh: &Mesh, offset: f64, colors: bool) -> Vec<u8> {
    let kind = if offset == 0.0 { "float" } else { "double" };
    let color = if colors {
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
    } else {
        ""
    };
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty {kind} x\nproperty {kind} y\n\
         property {kind} z\n{color}element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for (number, p) in mesh.positions.iter().enumerate() {
        for c in p {
            match offset {
                0.0 => out.extend(c.to_le_bytes()),
                _ => out.extend((f64::from(*c) + offset).to_le_bytes()),
            }
        }
        if colors {
            out.extend([number as u8, (number >> 8) as u8, 200, 255 - (number % 7) as u8]);
        }
    }
    for t in &mesh.triangles {
        out.push(3);
        out.extend(t.iter().flat_map(|v| v.to_le_bytes()));
    }
    out
}

fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in &mesh.triangles {
        out.extend([0; 12]);
        out.extend(t.iter().flat_map(|&v| mesh.positions[v as usize]).flat_map(f32::to_le_bytes));
        out.extend([0; 2]);
    }
    out
}

/// A mesh with what makes normals hard: creases, a seam of doubled vertices, borders, surfaces that touch, flat triangles and
/// triangles without area; in an order that scatters neighbours over the ranks.
fn hard() -> Mesh {
    let mut mesh = builtin::make("builtin:soup@600").expect("a model");
    for name in ["builtin:terrain@4k", "builtin:sphere@3k"] {
        let other = builtin::make(name).expect("a model");
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&other.positions);
        mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    // A cube with corners of its own for each face.
    for axis in 0..3 {
        for side in [0.0f32, 1.0] {
            let first = mesh.positions.len() as u32;
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                mesh.positions.push(p);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    // Two corners at one place, three corners on a line, and a vertex that no triangle uses.
    mesh.triangles.extend([[0, 1, 1], [5, 5, 5]]);
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([[0.0, 0.0, 0.0], [0.25, 0.0, 0.0], [1.0, 0.0, 0.0], [-9.0, 0.5, 0.25]]);
    mesh.triangles.push([first, first + 1, first + 2]);
    // A step that has no factor in common with the number of triangles.
    let count = mesh.triangles.len();
    let step = (count / 3..)
        .find(|step| (2..=*step).all(|d| step % d > 0 || !count.is_multiple_of(d)))
        .expect("a step");
    let near = mesh.triangles.clone();
    for (number, t) in mesh.triangles.iter_mut().enumerate() {
        if number % 5 == 0 {
            *t = near[number * step % count];
        }
    }
    Mesh { positions: mesh.positions, triangles: mesh.triangles, ..Mesh::default() }
}

const RANKS: [usize; 4] = [1, 2, 3, 7];

#[test]
fn ranks_that_share_a_file_load_the_whole_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let smooth = builtin::make("builtin:gyroid@30k").expect("a model");
    for (name, mesh, offset, colors) in [
        ("hard.ply", &hard(), 0.0, false),
        ("colours.ply", &hard(), 0.0, true),
        ("far.ply", &hard(), 1e7, false),
        ("smooth.ply", &smooth, 0.0, false),
    ] {
        let file = write(folder.path(), name, &ply(mesh, offset, colors));
        check(&file, &file, &RANKS);
    }
    for (name, mesh) in [("hard.stl", &hard()), ("smooth.stl", &smooth)] {
        let file = write(folder.path(), name, &stl(mesh));
        check(&file, &file, &RANKS);
    }
    check("builtin:teapot@5k".as_ref(), "builtin:teapot@5k".as_ref(), &RANKS);
}

#[test]
fn ranks_share_the_clusters_of_a_prepared_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = write(folder.path(), "hard.ply", &ply(&hard(), 0.0, true));
    let file = folder.path().join("hard.tercio");
    let prepared = tercio::load(&source).expect("a model");
    let mut out = std::fs::File::create(&file).expect("a file");
    prepared.write_prepared("hard.ply", &mut out).expect("room for it");
    check(&file, &file, &RANKS);
    // A byte that only one of the ranks reads.
    let mut bytes = std::fs::read(&file).expect("the file");
    let at = bytes.len() * 2 / 3;
    bytes[at] ^= 1;
    let broken = write(folder.path(), "broken.tercio", &bytes);
    let errors = threads::run(3, |comm| {
        Ok(LoadOptions::default().load_part(comm, &broken).expect_err("altered").to_string())
    });
    for error in errors.expect("ranks") {
        assert!(error.contains("as they were written"), "{error}");
    }
}

#[test]
fn ranks_with_files_of_their_own_load_what_the_files_are_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = hard();
    for count in [2usize, 3, 5] {
        // The seams are vertices at the same places, as simulations write them; the whole has them, too.
        let (mut whole, mut all) = (Mesh::default(), Vec::new());
        for rank in 0..count {
            let at = |k: usize| mesh.triangles.len() * k / count;
            let mut part = Mesh::default();
            for t in &mesh.triangles[at(rank)..at(rank + 1)] {
                let mut used: Vec<u32> = Vec::new();
                for &v in t {
                    let place = part.positions.iter().position(|p| *p == mesh.positions[v as usize]);
                    used.push(place.unwrap_or_else(|| {
                        part.positions.push(mesh.positions[v as usize]);
                        part.positions.len() - 1
                    }) as u32);
                }
                part.triangles.push([used[0], used[1], used[2]]);
            }
            let first = whole.positions.len() as u32;
            whole.positions.extend(&part.positions);
            whole.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
            all.push(part);
        }
        for (rank, part) in all.iter().enumerate() {
            write(folder.path(), &format!("part_{rank}.ply"), &ply(part, 0.0, false));
        }
        let file = write(folder.path(), "whole.ply", &ply(&whole, 0.0, false));
        check(&folder.path().join("part_{rank}.ply"), &file, &[count]);
    }
}

/// Of these cells only the hexahedron has several polygons, which edges need and parts do not have.
#[test]
fn parts_with_and_without_cells_of_several_polygons_are_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let head = "# vtk DataFile Version 3.0\ncells\nASCII\nDATASET UNSTRUCTURED_GRID\n";
    let cube = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1";
    let square = "0 0 3 1 0 3 1 1 3 0 1 3";
    for (name, text) in [
        ("part_0.vtk", format!("POINTS 8 float\n{cube}\nCELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n")),
        ("part_1.vtk", format!("POINTS 4 float\n{square}\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n9\n")),
        (
            "whole.vtk",
            format!(
                "POINTS 12 float\n{cube} {square}\nCELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 8 9 10 11\nCELL_TYPES 2\n12\n9\n"
            ),
        ),
    ] {
        write(folder.path(), name, format!("{head}{text}").as_bytes());
    }
    let whole = folder.path().join("whole.vtk");
    let triangles = LoadOptions::default().load(&whole).expect("the whole model").mesh.triangle_count();
    assert_eq!(triangles, 6 * 2 + 2);
    check(&folder.path().join("part_{rank}.vtk"), &whole, &[2]);
}

#[test]
fn parts_that_do_not_fit_together_are_refused_by_all_ranks() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = builtin::make("builtin:sphere@200").expect("a model");
    let mesh = Mesh { positions: mesh.positions, triangles: mesh.triangles, ..Mesh::default() };
    write(folder.path(), "part_0.ply", &ply(&mesh, 0.0, false));
    write(folder.path(), "part_1.ply", &ply(&mesh, 0.0, true));
    let name = folder.path().join("part_{rank}.ply");
    let errors = threads::run(2, |comm| {
        Ok(LoadOptions::default().load_part(comm, &name).expect_err("other colours").to_string())
    });
    for error in errors.expect("ranks") {
        assert!(error.contains("rank 1 has a part of a model with other normals, colours"), "{error}");
    }
}
