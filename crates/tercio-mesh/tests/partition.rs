//! Invariants of every partition, for any mesh and options.

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use tercio_mesh::cluster::{
    Cluster, ClusterView, LANES, Layout, Line, Order, PartitionOptions, Piece, partition, partition_pieces,
};
use tercio_mesh::{Attribute, AttributeDomain, ClusteredMesh, Mesh, OctNormal};

/// A mesh with every attribute, whose values identify their vertex or triangle.
fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    let (v, t) = (positions.len() as u32, triangles.len() as u32);
    let bytes = |i: u32| i.to_le_bytes();
    Mesh {
        origin: DVec3::new(1e6, -2e6, 0.5),
        normals: Some((0..v).map(OctNormal).collect()),
        vertex_colors: Some((0..v).map(bytes).collect()),
        texcoords: Some((0..v).map(|i| [i as f32, -(i as f32)]).collect()),
        face_colors: Some((0..t).map(bytes).collect()),
        triangle_materials: Some((0..t).map(|i| i ^ 5).collect()),
        face_of_triangle: Some((0..t).map(|i| i / 2).collect()),
        attributes: vec![
            Attribute {
                name: "v".into(),
                domain: AttributeDomain::Vertex,
                values: (0..v).map(|i| i as f32).collect(),
                offset: 0.0,
                component: None,
            },
            Attribute {
                name: "t".into(),
                domain: AttributeDomain::Triangle,
                values: (0..t).map(|i| i as f32).collect(),
                offset: 0.0,
                component: None,
            },
        ],
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A bumpy grid of `2 n^2` triangles; `scramble` changes the order of the triangles.
fn grid(n: u32, scramble: bool) -> Mesh {
    let positions = (0..=n)
        .flat_map(|y| (0..=n).map(move |x| (x as f32, y as f32)))
        .map(|(x, y)| [x, y, (x * 0.3).sin() + (y * 0.2).cos()])
        .collect();
    let mut triangles = Vec::new();
    for (x, y) in (0..n).flat_map(|y| (0..n).map(move |x| (x, y))) {
        let i = y * (n + 1) + x;
        triangles.extend([[i, i + 1, i + n + 2], [i + n + 2, i + n + 1, i]]);
    }
    if scramble {
        let count = triangles.len() as u64;
        triangles = (0..count).map(|i| triangles[(i * 7_654_321 % count) as usize]).collect();
    }
    mesh(positions, triangles)
}

/// Checks everything that the documentation guarantees.
fn check(mesh: &Mesh, options: &PartitionOptions) {
    check_clusters(&partition(mesh.clone(), options), mesh, options);
}

fn check_clusters(out: &ClusteredMesh, mesh: &Mesh, options: &PartitionOptions) {
    let n = mesh.triangles.len();
    assert_eq!(out.triangle_count(), n);
    assert_eq!(out.origin, mesh.origin);
    assert_eq!(out.face_of_triangle.as_deref(), mesh.face_of_triangle.as_deref());
    assert_eq!(out.triangles().count(), n);
    let (mut seen, mut vertices) = (vec![false; n], 0);
    for (i, c) in out.views().enumerate() {
        assert_eq!(*c.head(), out.clusters()[i]);
        assert!(c.triangles() > 0 && c.triangles() <= options.max_triangles);
        assert!(c.vertices() > 0 && c.vertices() <= options.max_vertices.max(3));
        vertices += c.vertices();
        check_vertices(out, &c, mesh);
        assert!(c.corners().iter().all(|k| k.len() == c.triangles().next_multiple_of(LANES)));
        assert!(c.corners().iter().all(|k| k[c.triangles()..].iter().all(|&corner| corner == 0)));
        assert_eq!(c.corners(), [0, 1, 2].map(|k| &c.corner_tables()[k][..c.corners()[k].len()]));
        for t in 0..c.triangles() {
            let p = c.primitive(t) as usize;
            assert_eq!(out.primitive_of_slot((i * 128 + t) as u32) as usize, p);
            assert!(!std::mem::replace(&mut seen[p], true), "primitive {p} twice");
            let original = Mesh::canonical(mesh.triangles[p]);
            let names = c.attribute(0);
            assert_eq!(c.corners_of(t).map(|v| names[usize::from(v)] as u32), original);
            assert_eq!(c.face_colors().unwrap()[t], mesh.face_colors.as_ref().unwrap()[p]);
            assert_eq!(c.triangle_materials().unwrap()[t], p as u32 ^ 5);
            assert_eq!(c.attribute(1)[t], p as f32);
        }
        check_bounds(&c);
        check_moved(out, i, &c);
    }
    assert!(seen.into_iter().all(|s| s));
    assert_eq!(out.vertex_count(), vertices);
}

fn check_vertices(out: &ClusteredMesh, c: &ClusterView, mesh: &Mesh) {
    let mut names: Vec<u32> = c.attribute(0).iter().map(|&v| v as u32).collect();
    assert_eq!(names.len(), c.vertices().next_multiple_of(LANES));
    for (place, &v) in names.iter().enumerate() {
        assert_eq!(c.position(place).map(f32::to_bits), mesh.positions[v as usize].map(f32::to_bits));
        assert_eq!(c.normals().unwrap()[place], OctNormal(v));
        assert_eq!(c.vertex_colors().unwrap()[place], v.to_le_bytes());
        assert_eq!(c.texcoords().unwrap().map(|values| values[place]), [v as f32, -(v as f32)]);
        let world = out.origin + Vec3::from(c.position(place)).as_dvec3();
        assert!(world.cmpge(out.bounds.min).all() && world.cmple(out.bounds.max).all());
    }
    let last = names[c.vertices() - 1];
    assert!(
        names.split_off(c.vertices()).iter().all(|&name| name == last),
        "padding repeats the last vertex"
    );
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), c.vertices(), "a vertex occurs twice in a cluster");
}

/// A cluster's memory means the same at any address.
fn check_moved(out: &ClusteredMesh, number: usize, c: &ClusterView) {
    let mut lines = out.stretch(number).to_vec();
    lines.extend([Line([0xff; 64]); Layout::LINES_BEHIND]);
    let moved = ClusterView::new(&lines, out.layout());
    assert_eq!((moved.head(), moved.positions(), moved.corners()), (c.head(), c.positions(), c.corners()));
    assert_eq!((moved.normals(), moved.texcoords()), (c.normals(), c.texcoords()));
    let last = c.triangles() - 1;
    assert_eq!((moved.primitive(last), moved.attribute(1)[last]), (c.primitive(last), c.attribute(1)[last]));
}

/// Box, sphere, heights, and the cone test for many eyes.
fn check_bounds(view: &ClusterView) {
    let c = view.head();
    let (center, radius) = c.sphere();
    let center = Vec3::from(center).as_dvec3();
    for v in 0..view.vertices() {
        let p = view.position(v);
        assert!((0..3).all(|k| c.min[k] <= p[k] && p[k] <= c.max[k]));
        assert!(center.distance(Vec3::from(p).as_dvec3()) <= radius.into());
    }
    let corners = (0..view.triangles()).map(|t| view.corner_positions(t).map(|p| Vec3::from(p).as_dvec3()));
    let triangles: Vec<[DVec3; 3]> = corners.collect();
    for &[a, b, d] in &triangles {
        let longest = (b - a).length().max((d - b).length()).max((a - d).length());
        let area = (b - a).cross(d - a).length();
        assert!(f64::from(c.min_height) * longest <= area * (1.0 + 1e-12));
    }
    let axis = Vec3::from(c.cone_axis.map(f32::from)).as_dvec3();
    assert!(axis.length() < 127.0);
    let size = f64::from(radius);
    let golden = |i: f64| {
        let z = 1.0 - (2.0 * i + 1.0) / 40.0;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * (i * 2.399_963).cos(), r * (i * 2.399_963).sin(), z)
    };
    for distance in [0.0, 0.5, 1.5, 4.0, 1e3, 1e7] {
        for way in (0..40).map(|i| golden(f64::from(i))) {
            check_eye(c, &triangles, center + way * size * distance);
        }
    }
    // Eyes near the boundary of the region where the cone test is true.
    let side = axis.any_orthogonal_vector().normalize_or_zero();
    for i in 0..40 {
        let way = -axis.normalize_or_zero() + side * (f64::from(i) - 20.0) * 0.05;
        check_eye(c, &triangles, center + way * size * 50.0);
    }
}

fn check_eye(c: &Cluster, triangles: &[[DVec3; 3]], eye: DVec3) {
    let rounded = eye.as_vec3().to_array();
    let (away, towards) = (c.faces_away(rounded), c.faces_towards(rounded));
    assert!(!(away && towards));
    if !away && !towards {
        return;
    }
    for &[a, b, d] in triangles {
        let facing = (a - eye).dot((b - a).cross(d - a));
        assert!(if away { facing >= 0.0 } else { facing <= 0.0 }, "{c:?} seen from {eye}: {facing}");
    }
}

/// All data, for bitwise comparison.
fn print(m: &ClusteredMesh) -> impl PartialEq + std::fmt::Debug + use<> {
    let stretches: Vec<Line> = (0..m.clusters().len()).flat_map(|i| m.stretch(i)).copied().collect();
    (m.clusters().to_vec(), stretches)
}

fn options() -> impl Strategy<Value = (usize, usize, Order, Option<u64>)> {
    let order = prop_oneof![Just(Order::Auto), Just(Order::File), Just(Order::Spatial)];
    (3usize..=64, 1usize..=128, order, prop::option::of(any::<u64>()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_soup_any_options(
        points in prop::collection::vec(prop::array::uniform3(-4i8..=4), 3..200),
        picks in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 0..400),
        scale in -20i32..20,
        (max_vertices, max_triangles, order, shuffle_seed) in options(),
    ) {
        // Few distinct coordinates: many triangles without area, and many overlapping ones.
        let positions: Vec<_> = points.iter().map(|p| p.map(|v| f32::from(v) * 1.1 * 2f32.powi(scale))).collect();
        let triangles = picks.iter().map(|t| t.map(|i| i.index(positions.len()) as u32)).collect();
        let mesh = mesh(positions, triangles);
        check(&mesh, &PartitionOptions { max_vertices, max_triangles, order, shuffle_seed, ..Default::default() });
    }

    #[test]
    fn any_grid_any_options(
        n in 1u32..40,
        scramble: bool,
        (max_vertices, max_triangles, order, shuffle_seed) in options(),
    ) {
        let options = PartitionOptions { max_vertices, max_triangles, order, shuffle_seed, ..Default::default() };
        check(&grid(n, scramble), &options);
    }

    #[test]
    fn pieces_are_packed_in_their_order(sizes in proptest::collection::vec(1u32..9, 1..120), seed: u64) {
        check_pieces(&sizes, seed);
    }
}

/// Separate grids with so many cells along each side, packed in an order that depends on `seed`: clusters are full, no small one is
/// divided, and all have what they had.
fn check_pieces(sizes: &[u32], seed: u64) {
    let (mut positions, mut triangles, mut pieces) = (Vec::new(), Vec::new(), Vec::new());
    for (i, &n) in sizes.iter().enumerate() {
        let part = grid(n, false);
        let (v, t) = (positions.len() as u32, triangles.len() as u32);
        positions.extend(part.positions.iter().map(|[x, y, z]| [x + 1000.0 * i as f32, *y, *z]));
        triangles.extend(part.triangles.iter().map(|corners| corners.map(|c| v + c)));
        pieces.push(Piece { vertices: v..positions.len() as u32, triangles: t..triangles.len() as u32 });
    }
    pieces.sort_by_key(|piece| (u64::from(piece.vertices.start) + 1).wrapping_mul(seed | 1));
    let mesh = mesh(positions, triangles);
    let out = partition_pieces(mesh.clone(), pieces.clone());
    check_clusters(&out, &mesh, &PartitionOptions::default());
    assert!(out.triangles().map(|t| t.0).eq(pieces.iter().flat_map(|piece| piece.triangles.clone())));
    let piece_of = |t: u32| pieces.iter().position(|piece| piece.triangles.contains(&t)).expect("a piece");
    let fits = |piece: &Piece| piece.vertices.len() <= 64 && piece.triangles.len() <= 128;
    let mut last: Option<(usize, usize, usize)> = None;
    for view in out.views() {
        let numbers: Vec<u32> = (0..view.triangles()).map(|t| view.primitive(t)).collect();
        let (first, end) = (piece_of(numbers[0]), piece_of(numbers[numbers.len() - 1]));
        if let Some((before, vertices, triangles)) = last {
            let piece = &pieces[first];
            if fits(piece) {
                assert_ne!(first, before, "a small piece is divided");
                let is_full = vertices + piece.vertices.len() > 64 || triangles + piece.triangles.len() > 128;
                assert!(is_full, "there was room");
            }
        }
        last = Some((end, view.vertices(), view.triangles()));
    }
}

#[test]
fn pieces_of_more_vertices_than_a_block_has() {
    check_pieces(&[5; 2_000], 3);
    check_pieces(&[200, 1, 60], 0);
}

#[test]
fn wrong_pieces_are_refused() {
    let mesh = grid(1, false);
    let piece = |vertices, triangles| Piece { vertices, triangles };
    for (pieces, reason) in [
        (vec![piece(0..4, 0..1)], "all triangles"),
        (vec![piece(0..4, 0..2), piece(0..4, 0..1)], "all triangles"),
        (vec![piece(0..3, 0..2)], "is not in the piece"),
        (vec![piece(1..4, 0..2)], "is not in the piece"),
    ] {
        let error = std::panic::catch_unwind(|| partition_pieces(mesh.clone(), pieces)).expect_err("refused");
        let message = error.downcast_ref::<String>().expect("a message");
        assert!(message.contains(reason), "{message}");
    }
}

#[test]
fn faces_of_a_cluster_are_those_of_its_triangles() {
    let mesh = grid(30, true);
    for faces in [mesh.face_of_triangle.clone(), None] {
        let out = partition(Mesh { face_of_triangle: faces, ..mesh.clone() }, &PartitionOptions::default());
        for (number, view) in out.views().enumerate() {
            assert!(out.faces(number).eq((0..view.triangles()).map(|t| out.face(number, t))));
        }
    }
}

#[test]
fn many_blocks() {
    for scramble in [false, true] {
        for order in [Order::Auto, Order::File, Order::Spatial] {
            for shuffle_seed in [None, Some(7)] {
                check(&grid(180, scramble), &PartitionOptions { order, shuffle_seed, ..Default::default() });
            }
        }
    }
}

#[test]
fn every_number_of_threads_gives_the_same_bytes() {
    for scramble in [false, true] {
        for order in [Order::Auto, Order::File, Order::Spatial] {
            let run = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let options = PartitionOptions { order, ..Default::default() };
                pool.install(|| print(&partition(grid(400, scramble), &options)))
            };
            let one = run(1);
            for threads in [2, 3, 7] {
                assert!(one == run(threads), "{threads} threads, {order:?}");
            }
        }
    }
}

#[test]
fn a_good_order_is_kept_and_a_bad_one_is_not() {
    // Tiles of 7 x 7 squares: 98 triangles over 64 vertices each.
    let mut mesh = grid(140, false);
    let tile = |i: usize| (i / 2 / 140 / 7, i / 2 % 140 / 7);
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    order.sort_by_key(|&i| tile(i));
    mesh.triangles = order.iter().map(|&i| mesh.triangles[i]).collect();
    let kept = partition(mesh, &PartitionOptions::default());
    let keeps_order =
        |mesh: &ClusteredMesh| mesh.triangles().map(|t| t.0).eq(0..mesh.triangle_count() as u32);
    assert!(keeps_order(&kept));
    assert_eq!(kept.clusters().len(), 400);
    assert!(!keeps_order(&partition(grid(140, true), &PartitionOptions::default())));
    assert!(!keeps_order(&partition(grid(140, false), &PartitionOptions::default())));
}

#[test]
fn a_triangle_takes_at_most_16_bytes() {
    for model in ["builtin:gyroid@300k", "builtin:terrain@300k", "builtin:sphere@300k"] {
        let Mesh { positions, triangles, .. } = tercio_mesh::builtin::make(model).unwrap();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        // Also in an order without any locality.
        let count = mesh.triangles.len() as u64;
        let scrambled = (0..count).map(|i| mesh.triangles[(i * 7_654_321 % count) as usize]).collect();
        for triangles in [mesh.triangles.clone(), scrambled] {
            let out = partition(Mesh { triangles, ..mesh.clone() }, &PartitionOptions::default());
            let bytes = out.core_bytes() as f64 / out.triangle_count() as f64;
            assert!(bytes <= 16.0, "{model}: {bytes}");
            // The mesh holds nothing that is not counted.
            assert!(out.memory_bytes() as f64 <= 1.001 * out.core_bytes() as f64 + 1e4, "{model}");
        }
    }
}

#[test]
fn a_crowded_cell_is_split() {
    // Nearly all triangles are in one cell of the grid, because a few are far away.
    let mut mesh = grid(200, true);
    let far = mesh.positions.len() - 1;
    mesh.positions[far] = [1e6, 1e6, 1e6];
    check(&mesh, &PartitionOptions { order: Order::Spatial, ..Default::default() });
}

#[test]
fn an_empty_mesh() {
    let out = partition(Mesh::default(), &PartitionOptions::default());
    assert_eq!(out.triangle_count(), 0);
    assert!(out.bounds.is_empty());
    assert_eq!(ClusteredMesh::default().triangles().count(), 0);
}

#[test]
fn all_vertices_at_one_position() {
    let mesh = mesh(vec![[1.0; 3]; 3], vec![[0, 1, 2]; 50_000]);
    check(&mesh, &PartitionOptions::default());
}
