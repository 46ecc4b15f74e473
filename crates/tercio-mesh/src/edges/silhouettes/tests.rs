use std::sync::atomic::AtomicUsize;

use super::*;
use crate::edges::Selection;
use crate::{Mesh, builtin};

fn edges(name: &str) -> Edges {
    Edges::of_mesh(&builtin::make(name).expect("a model"), Selection::All)
}

/// The same with every third triangle wound the other way round, and some without area.
fn broken(name: &str) -> Edges {
    let mut mesh: Mesh = builtin::make(name).expect("a model");
    for (n, triangle) in mesh.triangles.iter_mut().enumerate() {
        match n % 3 {
            0 => triangle.swap(0, 1),
            1 if n % 7 == 0 => triangle[2] = triangle[1],
            _ => {}
        }
    }
    Edges::of_mesh(&mesh, Selection::All)
}

/// Edges of nothing, and of triangles in one point.
fn nothing() -> [Edges; 2] {
    let point =
        Mesh { positions: vec![[1.0; 3]; 4], triangles: vec![[0, 1, 2], [2, 1, 3]], ..Mesh::default() };
    [Mesh::default(), point].map(|mesh| Edges::of_mesh(&mesh, Selection::All))
}

/// Viewers inside, near, and far.
fn viewers(edges: &Edges) -> Vec<Viewer> {
    let [min, max] = edges.bounds.map(|corner| corner.as_dvec3());
    let (middle, size) = ((min + max) * 0.5, (max - min).length());
    let mut all = Vec::new();
    for from in [
        DVec3::new(0.3, -2.0, 0.8),
        DVec3::new(-0.9, 0.1, 0.4),
        DVec3::new(0.0, 0.0, 2.0),
        DVec3::new(0.1, 0.05, -0.1),
        DVec3::new(0.0, 1e5, 3e4),
    ] {
        all.push(Viewer::At(middle + from * size));
        all.push(Viewer::Along(-from));
    }
    all
}

fn expected(edges: &Edges, viewer: Viewer) -> Vec<u32> {
    let is_left = |n: &u32| !edges.is_between(&edges.list[*n as usize], viewer, EDGE_ON * edges.diagonal());
    (0..edges.list.len() as u32).filter(is_left).collect()
}

#[test]
fn cones_leave_out_no_silhouette() {
    // Near to and along a surface, more of it is seen edge-on.
    for (name, most) in [("teapot", 0.07), ("gyroid", 0.25), ("terrain", 0.25)] {
        let name = format!("builtin:{name}@20k");
        for (edges, is_whole) in [(edges(&name), true), (broken(&name), false)] {
            for viewer in viewers(&edges) {
                let expected = expected(&edges, viewer);
                assert!(!expected.is_empty() && expected.len() < edges.list.len());
                for view in 0..VIEWS_WITHOUT_CONES + 2 {
                    assert_eq!(edges.silhouettes(viewer), expected, "{name}, {viewer:?}, view {view}");
                }
                let cones = edges.cones.for_view(&edges).expect("after several viewers");
                let asked = AtomicUsize::new(0);
                cones.candidates(viewer, |_| asked.fetch_add(1, Relaxed) == usize::MAX);
                let share = asked.into_inner() as f64 / edges.list.len() as f64;
                if is_whole {
                    assert!(share < most, "{name}, {viewer:?}: {share} of all edges are looked at");
                }
            }
        }
    }
    for edges in nothing() {
        for viewer in [Viewer::At(DVec3::ONE), Viewer::At(DVec3::ZERO), Viewer::Along(DVec3::Z)] {
            for _ in 0..VIEWS_WITHOUT_CONES + 2 {
                assert_eq!(edges.silhouettes(viewer), expected(&edges, viewer));
            }
        }
    }
}

#[test]
fn viewers_that_are_not_finite_get_all_edges() {
    let edges = edges("builtin:teapot@1k");
    let all: Vec<u32> = (0..edges.list.len() as u32).collect();
    for wrong in [DVec3::NAN, DVec3::INFINITY] {
        for viewer in [Viewer::At(wrong), Viewer::Along(wrong), Viewer::Along(DVec3::ZERO)] {
            for _ in 0..VIEWS_WITHOUT_CONES + 2 {
                assert_eq!(edges.silhouettes(viewer), all);
            }
        }
    }
}

/// While a thread waits for the cones that it makes, it may begin another view.
#[test]
fn views_are_found_side_by_side() {
    let edges = edges("builtin:teapot@20k");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    let viewers: Vec<Viewer> = viewers(&edges).into_iter().cycle().take(64).collect();
    let found: Vec<Vec<u32>> = pool
        .install(|| viewers.par_iter().with_max_len(1).map(|&viewer| edges.silhouettes(viewer)).collect());
    for (viewer, found) in viewers.iter().zip(found) {
        assert_eq!(found, expected(&edges, *viewer));
    }
}

#[test]
fn stored_normals_are_as_near_as_they_should_be() {
    let mut most = 0.0f64;
    for i in 0..200_000 {
        // Spread over the sphere evenly (a Fibonacci lattice).
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 200_000.0;
        let (sin, cos) = sin_cos(f64::from(i) * 2.399_963 % std::f64::consts::TAU);
        let normal = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
        let stored = Vec3::from(OctNormal::from_vector(normal.to_array()).decode()).as_dvec3();
        assert!((0.57..1.000_001).contains(&stored.length()), "{normal}: {stored}");
        most = most.max(normal.cross(stored.normalize()).length());
    }
    assert!((ROUNDING / 4.0..ROUNDING).contains(&most), "{most}");
}
