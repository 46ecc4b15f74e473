//! Guarantees of generated normals.

use super::*;

fn cube(quads_by_long_fans: bool) -> Mesh {
    let positions = (0..8).map(|i| [0, 1, 2].map(|k| (i >> k & 1) as f32)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads
        .iter()
        .enumerate()
        .flat_map(|(i, &[a, b, c, d])| {
            if quads_by_long_fans && i % 2 == 0 { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] }
        })
        .collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

fn direction(n: OctNormal) -> DVec3 {
    let [x, y, z] = n.decode();
    DVec3::new(x.into(), y.into(), z.into()).normalize()
}

#[test]
fn a_cube_is_round_without_crease_and_sharp_with_one() {
    for cut in [false, true] {
        let mut m = cube(cut);
        make_normals(&mut m, None);
        assert_eq!(m.positions.len(), 8);
        for (p, &n) in m.positions.iter().zip(m.normals.as_ref().unwrap()) {
            let out = (DVec3::new(p[0].into(), p[1].into(), p[2].into()) - 0.5).normalize();
            assert!((direction(n) - out).length() < 1e-3, "{cut} {p:?}");
        }
        m.vertex_colors = Some((0..8).map(|i| [i; 4]).collect());
        let before = m.clone();
        make_normals(&mut m, Some(1.0));
        assert_eq!(m.positions.len(), 24);
        assert_eq!(m.normals.as_ref().unwrap().len(), 24);
        let (colors, old) = (m.vertex_colors.as_ref().unwrap(), before.vertex_colors.as_ref().unwrap());
        for (t, b) in m.triangles.iter().zip(&before.triangles) {
            let [p, q, r] = t.map(|v| DVec3::from(m.positions[v as usize].map(f64::from)));
            let face = (q - p).cross(r - p).normalize();
            for (&v, &w) in t.iter().zip(b) {
                assert_eq!(m.positions[v as usize], before.positions[w as usize]);
                assert_eq!(colors[v as usize], old[w as usize]);
                assert!((direction(m.normals.as_ref().unwrap()[v as usize]) - face).length() < 1e-4);
            }
        }
        // Nothing is left to split, and split vertices are not joined again.
        make_normals(&mut m, Some(1.0));
        assert_eq!(m.positions.len(), 24);
    }
}

#[test]
fn a_right_angle_is_no_crease_at_a_larger_angle() {
    let mut m = cube(true);
    make_normals(&mut m, Some(1.6));
    assert_eq!(m.positions.len(), 8);
}

#[test]
fn split_vertices_share_their_normal() {
    let whole = cube(false);
    let mut soup = Mesh {
        positions: whole.triangles.iter().flatten().map(|&v| whole.positions[v as usize]).collect(),
        triangles: (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    };
    let mut joined = whole.clone();
    make_normals(&mut joined, None);
    make_normals(&mut soup, None);
    let (a, b) = (soup.normals.unwrap(), joined.normals.unwrap());
    for (i, &v) in whole.triangles.as_flattened().iter().enumerate() {
        assert_eq!(a[i], b[v as usize]);
    }
}

#[test]
fn spheres_point_outwards_for_any_number_of_threads() {
    let mesh = crate::builtin::make("builtin:sphere@200k").unwrap();
    let results: Vec<_> = [1, 2, 3, 7]
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (mut smooth, mut creased) = (mesh.clone(), mesh.clone());
            pool.install(|| {
                make_normals(&mut smooth, None);
                make_normals(&mut creased, Some(0.5));
            });
            assert_eq!(creased.positions.len(), mesh.positions.len());
            assert_eq!(creased.normals, smooth.normals);
            smooth.normals.unwrap()
        })
        .into();
    assert!(results.iter().all(|r| *r == results[0]));
    let error = |(p, &n): (&[f32; 3], &OctNormal)| {
        (direction(n) - DVec3::from(p.map(f64::from)).normalize()).length()
    };
    let mut fine = crate::builtin::make("builtin:sphere@1.5M").unwrap();
    make_normals(&mut fine, None);
    let normals = fine.normals.as_ref().unwrap();
    let worst = fine.positions.iter().zip(normals).map(error).fold(0.0, f64::max);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn tiny_and_huge_models_have_normals() {
    for scale in [1e-30f32, 1e30] {
        let mut m = cube(false);
        m.positions.iter_mut().for_each(|p| *p = p.map(|x| x * scale));
        make_normals(&mut m, None);
        assert!((direction(m.normals.unwrap()[7]) - DVec3::ONE.normalize()).length() < 1e-3);
    }
}

/// Normals and moves by the precise method for every vertex.
fn make_all_precisely(mesh: &Mesh, crease_angle: f64) -> (Vec<OctNormal>, Splits) {
    let blocks = Blocks::new(mesh, Order::Auto);
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
    let doubtful: Vec<u32> = (0..).zip(&used).filter(|u| *u.1).map(|u| u.0).collect();
    let unsettled = OctNormal(smooth::UNSETTLED);
    let mut normals = used.iter().map(|&u| if u { unsettled } else { OctNormal::default() }).collect();
    let splits = creased::settle(mesh, &blocks, &mut normals, &doubtful, crease_angle);
    (normals, splits)
}

#[test]
fn the_fast_and_the_precise_method_agree() {
    for model in ["gyroid@60k", "teapot@20k", "terrain@50k", "soup@2k", "sphere@3k"] {
        let whole = crate::builtin::make(&format!("builtin:{model}")).unwrap();
        for angle in [0.02, 0.5, std::f64::consts::FRAC_PI_3, 3.0] {
            let mut mesh = whole.clone();
            mesh.normals = None;
            let (normals, precise) = make_all_precisely(&mesh, angle);
            let fast = make_creased(&mut mesh, &Blocks::new(&whole, Order::Spatial), angle);
            assert_eq!(mesh.normals.unwrap(), normals, "{model}, {angle}");
            assert_eq!(fast.sources, precise.sources, "{model}, {angle}");
            let moves = |s: &Splits| s.moves.iter().map(|m| (m.triangle, m.from, m.to)).collect::<Vec<_>>();
            assert_eq!(moves(&fast), moves(&precise), "{model}, {angle}");
        }
    }
}

#[test]
fn most_vertices_of_a_closed_surface_are_settled_quickly() {
    let mesh = crate::builtin::make("builtin:gyroid@60k").unwrap();
    let (_, doubtful) = smooth::settle(&mesh, &Blocks::new(&mesh, Order::Spatial), 1.0);
    assert!(doubtful.len() * 5 < mesh.positions.len(), "{} of {}", doubtful.len(), mesh.positions.len());
}

/// Two shallow cones over hexagons with a common tip, rotated relative to each other, and `between` triangles apart
/// in the order of the mesh.
fn two_rings(between: u32) -> Mesh {
    let mut mesh = Mesh { positions: vec![[0.0; 3]], ..Mesh::default() };
    for (first, slope) in [(1u32, -0.1), (7, -0.3)] {
        for i in 0..6 {
            let turn = (f64::from(i) + slope) * std::f64::consts::FRAC_PI_3;
            mesh.positions.push([turn.cos() as f32, turn.sin() as f32, slope as f32]);
            mesh.triangles.push([0, first + i, first + (i + 1) % 6]);
        }
    }
    for i in 0..between {
        mesh.positions.extend([[i as f32, 5.0, 0.0], [i as f32, 6.0, 0.0], [i as f32 + 0.5, 5.0, 0.0]]);
    }
    mesh.triangles.splice(6..6, (0..between).map(|i| [13 + 3 * i, 14 + 3 * i, 15 + 3 * i]));
    mesh
}

#[test]
fn two_closed_rings_at_a_vertex_are_two_surfaces() {
    // In one block, and in two.
    for between in [0, 2 * crate::blocks::order::BLOCK as u32] {
        let mut mesh = two_rings(between);
        let vertices = mesh.positions.len();
        let splits = make_creased(&mut mesh, &Blocks::new(&two_rings(between), Order::File), 1.0);
        assert_eq!(splits.sources, [0]);
        let moved: Vec<u32> = splits.moves.iter().map(|m| m.triangle).collect();
        assert_eq!(moved, Vec::from_iter(6 + between..12 + between));
        assert!(splits.moves.iter().all(|m| (m.from, m.to) == (0, vertices as u32)));
        assert_eq!(mesh.positions[vertices], [0.0; 3]);
    }
}

#[test]
fn blocks_get_the_normals_of_the_mesh() {
    for model in ["gyroid@60k", "teapot@60k"] {
        let mut mesh = crate::builtin::make(&format!("builtin:{model}")).unwrap();
        mesh.normals = None;
        let mut blocks = BlockedMesh::new(mesh.clone(), Order::Spatial);
        blocks.make_normals(0.3);
        make_normals(&mut mesh, Some(0.3));
        assert_eq!(blocks.mesh.normals, mesh.normals);
        assert_eq!(blocks.mesh.positions, mesh.positions);
        for block in &blocks.blocks.list {
            for (t, &corners) in blocks.blocks.corners[block.range()].iter().enumerate() {
                let expected = mesh.triangles[blocks.blocks.number(block, t) as usize];
                assert_eq!(block.name(corners), Mesh::canonical(expected));
            }
        }
    }
}

/// The cube as a soup, so that every corner has a normal of its own.
fn soup() -> Mesh {
    let whole = cube(false);
    Mesh {
        positions: whole.triangles.as_flattened().iter().map(|&v| whole.positions[v as usize]).collect(),
        triangles: (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

#[test]
fn a_broken_normal_becomes_the_one_that_would_be_made_there() {
    for angle in [None, Some(0.5), Some(1.6)] {
        for broken in [&[5][..], &[0, 1, 2, 30], &(0..36).collect::<Vec<_>>()] {
            let mut made = soup();
            make_normals(&mut made, angle);
            // The normals of the file differ from those that would be made.
            let of_file = OctNormal::encode([1.0, 2.0, -3.0]);
            let mut mesh = soup();
            let mut normals = vec![of_file; 36];
            broken.iter().for_each(|&v| normals[v as usize] = OctNormal::NONE);
            mesh.normals = Some(normals);
            assert_eq!(mend_normals(&mut mesh, angle), broken.len() as u64);
            for (v, &n) in (0u32..).zip(mesh.normals.as_ref().unwrap()) {
                let expected =
                    if broken.contains(&v) { made.normals.as_ref().unwrap()[v as usize] } else { of_file };
                assert_eq!(n, expected, "{angle:?} {broken:?} {v}");
            }
            assert_eq!(mend_normals(&mut mesh, angle), 0, "mended once");
        }
    }
}

#[test]
fn only_vertices_with_broken_normals_are_split() {
    let file = OctNormal::encode([1.0, 2.0, -3.0]);
    let mut mesh = cube(false);
    mesh.normals = Some(vec![file; 8]);
    mesh.normals.as_mut().unwrap()[3] = OctNormal::NONE;
    mesh.vertex_colors = Some((0..8).map(|i| [i; 4]).collect());
    let before = mesh.clone();
    let mut blocked = BlockedMesh::new(mesh.clone(), Order::Auto);
    assert_eq!(mend_normals(&mut mesh, Some(0.5)), 1);
    assert_eq!(
        (mesh.positions.len(), mesh.vertex_colors.as_ref().unwrap()[8..].to_vec()),
        (10, vec![[3; 4]; 2])
    );
    for (t, b) in mesh.triangles.iter().zip(&before.triangles) {
        let [p, q, r] = t.map(|v| DVec3::from(mesh.positions[v as usize].map(f64::from)));
        let face = (q - p).cross(r - p).normalize();
        for (&v, &w) in t.iter().zip(b) {
            let normal = mesh.normals.as_ref().unwrap()[v as usize];
            match w {
                3 => assert!((direction(normal) - face).length() < 1e-4),
                _ => assert_eq!((v, normal), (w, file)),
            }
        }
    }
    assert_eq!(blocked.mend_normals(0.5), 1);
    assert_eq!(blocked.mesh().normals, mesh.normals);
    let mut smooth = before;
    assert_eq!(mend_normals(&mut smooth, None), 1);
    assert_eq!(smooth.positions.len(), 8);
    assert!((direction(smooth.normals.unwrap()[3]) - DVec3::new(1.0, 1.0, -1.0).normalize()).length() < 1e-3);
}
