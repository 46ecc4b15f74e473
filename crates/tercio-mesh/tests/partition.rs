//! What holds for every partition, whatever the mesh and the options.

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use tercio_mesh::cluster::{Cluster, Order, PADDING, PartitionOptions, partition};
use tercio_mesh::{Attribute, AttributeDomain, ClusteredMesh, Mesh, OctNormal};

/// A mesh with every attribute, each value telling whose it is.
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
            },
            Attribute {
                name: "t".into(),
                domain: AttributeDomain::Triangle,
                values: (0..t).map(|i| i as f32).collect(),
            },
        ],
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A bumpy grid of `2 n^2` triangles; `scramble` deals the triangles out in another order.
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

/// Everything that the documentation promises.
fn check(mesh: &Mesh, options: &PartitionOptions) {
    let out = partition(mesh.clone(), options);
    let n = mesh.triangles.len();
    assert_eq!(out.triangle_count(), n);
    assert_eq!(out.origin, mesh.origin);
    assert_eq!(out.face_of_triangle, mesh.face_of_triangle);
    assert_eq!(out.corners[0].len(), n + PADDING);
    assert_eq!(out.x.len(), out.vertex_count() + PADDING);
    assert_eq!(out.triangles().count(), n);
    let (mut seen, mut vertex, mut triangle) = (vec![false; n], 0, 0);
    for (i, c) in out.clusters.iter().enumerate() {
        assert_eq!((c.vertex_range().start, c.triangle_range().start), (vertex, triangle));
        (vertex, triangle) = (c.vertex_range().end, c.triangle_range().end);
        assert!(c.triangles > 0 && usize::from(c.triangles) <= options.max_triangles);
        assert!(c.vertices > 0 && usize::from(c.vertices) <= options.max_vertices.max(3));
        check_vertices(&out, c, mesh);
        for t in c.triangle_range() {
            let p = out.primitive(t) as usize;
            assert_eq!(out.primitive_of_slot((i * 128 + t - c.triangle_range().start) as u32) as usize, p);
            assert!(!std::mem::replace(&mut seen[p], true), "primitive {p} twice");
            let original = Mesh::canonical(mesh.triangles[p]);
            let names = out.attributes[0].values.as_slice();
            assert_eq!(out.corner_places(c, t).map(|v| names[v] as u32), original);
            assert_eq!(out.face_colors.as_ref().unwrap()[t], mesh.face_colors.as_ref().unwrap()[p]);
            assert_eq!(out.triangle_materials.as_ref().unwrap()[t], p as u32 ^ 5);
            assert_eq!(out.attributes[1].values[t], p as f32);
        }
        check_bounds(&out, c);
    }
    assert!(seen.into_iter().all(|s| s));
}

fn check_vertices(out: &ClusteredMesh, c: &Cluster, mesh: &Mesh) {
    let mut names: Vec<u32> = out.attributes[0].values[c.vertex_range()].iter().map(|&v| v as u32).collect();
    for (place, &v) in c.vertex_range().zip(&names) {
        assert_eq!(out.position(place).map(f32::to_bits), mesh.positions[v as usize].map(f32::to_bits));
        assert_eq!(out.normals.as_ref().unwrap()[place], OctNormal(v));
        assert_eq!(out.vertex_colors.as_ref().unwrap()[place], v.to_le_bytes());
        assert_eq!(out.texcoords.as_ref().unwrap()[place], [v as f32, -(v as f32)]);
        let world = out.origin + Vec3::from(out.position(place)).as_dvec3();
        assert!(world.cmpge(out.bounds.min).all() && world.cmple(out.bounds.max).all());
    }
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), usize::from(c.vertices), "a vertex stands twice in a cluster");
}

/// Box, sphere, heights, and the cone test seen from many eyes.
fn check_bounds(out: &ClusteredMesh, c: &Cluster) {
    let (center, radius) = c.sphere();
    let center = Vec3::from(center).as_dvec3();
    for v in c.vertex_range() {
        let p = out.position(v);
        assert!((0..3).all(|k| c.min[k] <= p[k] && p[k] <= c.max[k]));
        assert!(center.distance(Vec3::from(p).as_dvec3()) <= radius.into());
    }
    let corners =
        c.triangle_range().map(|t| out.corner_places(c, t).map(|v| Vec3::from(out.position(v)).as_dvec3()));
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
    // Eyes near the edge of the cone's shadow.
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

/// Every array, bit for bit.
fn print(m: &ClusteredMesh) -> impl PartialEq + std::fmt::Debug + use<> {
    let bits = |v: &[f32]| v.iter().map(|f| f.to_bits()).collect::<Vec<_>>();
    (
        m.clusters.clone(),
        [bits(&m.x), bits(&m.y), bits(&m.z)],
        m.corners.clone(),
        m.primitives.clone(),
        m.normals.clone(),
        m.face_colors.clone(),
        m.attributes.clone(),
    )
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
        // Few coordinates: many triangles without area, many that fold back on themselves.
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
    assert!(kept.primitives.is_none());
    assert_eq!(kept.clusters.len(), 400);
    assert!(partition(grid(140, true), &PartitionOptions::default()).primitives.is_some());
    assert!(partition(grid(140, false), &PartitionOptions::default()).primitives.is_some());
}

#[test]
fn a_crowded_cell_is_cut() {
    // Nearly all triangles stand in one cell of the grid, because a few stand far away.
    let mut mesh = grid(200, true);
    let far = mesh.positions.len() - 1;
    mesh.positions[far] = [1e6, 1e6, 1e6];
    check(&mesh, &PartitionOptions { order: Order::Spatial, ..Default::default() });
}

#[test]
fn nothing_at_all() {
    let out = partition(Mesh::default(), &PartitionOptions::default());
    assert_eq!(out.triangle_count(), 0);
    assert!(out.bounds.is_empty());
    assert_eq!(ClusteredMesh::default().triangles().count(), 0);
}

#[test]
fn all_in_one_place() {
    let mesh = mesh(vec![[1.0; 3]; 3], vec![[0, 1, 2]; 50_000]);
    check(&mesh, &PartitionOptions::default());
}
