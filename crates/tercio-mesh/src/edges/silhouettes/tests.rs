use super::*;
use crate::edges::Selection;
use crate::{Mesh, builtin};

fn edges(name: &str) -> Edges {
    Edges::of_mesh(&builtin::make(name).expect("a model"), Selection::All)
}

fn model(name: &str) -> Mesh {
    match name {
        "bumpy" => bumpy(),
        name => builtin::make(&format!("builtin:{name}@20k")).expect("a model"),
    }
}

/// A sphere with hills and valleys.
fn bumpy() -> Mesh {
    let mut mesh = builtin::make("builtin:sphere@20k").expect("a model");
    for p in &mut mesh.positions {
        let [x, y, z] = p.map(|c| sin_cos(f64::from(c) * 12.0).0);
        *p = p.map(|c| c * (1.0 + 0.1 * (x * y * z)) as f32);
    }
    mesh
}

/// The same with every third triangle wound the other way round, and some without area.
fn broken(mut mesh: Mesh) -> Mesh {
    for (n, triangle) in mesh.triangles.iter_mut().enumerate() {
        match n % 3 {
            0 => triangle.swap(0, 1),
            1 if n % 7 == 0 => triangle[2] = triangle[1],
            _ => {}
        }
    }
    mesh
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

fn corners_of(edges: &Edges, edge: &Edge) -> EdgeCorners {
    let at = |v: u32| edges.positions[v as usize];
    let apexes = edge.apexes.map(|v| (v != Edge::NONE).then(|| at(v)));
    EdgeCorners { ends: edge.ends.map(at), apexes, kind: edge.kind }
}

fn expected(edges: &Edges, viewer: Viewer) -> Vec<u32> {
    let is_left = |n: &u32| {
        let corners = corners_of(edges, &edges.list[*n as usize]);
        !is_between(&corners, viewer, EDGE_ON * edges.diagonal())
    };
    (0..edges.list.len() as u32).filter(is_left).collect()
}

#[test]
fn cones_leave_out_no_silhouette() {
    // Near to and along a surface, more of it is seen edge-on.
    for (name, most) in [("teapot", 0.07), ("gyroid", 0.25), ("terrain", 0.25), ("bumpy", 0.12)] {
        let mesh = model(name);
        for (mesh, is_whole) in [(mesh.clone(), true), (broken(mesh), false)] {
            let edges = Edges::of_mesh(&mesh, Selection::All);
            for viewer in viewers(&edges) {
                let expected = expected(&edges, viewer);
                // From its middle, all of the bumpy sphere is seen from one side.
                assert!(expected.len() < edges.list.len() && (name == "bumpy" || !expected.is_empty()));
                assert_eq!(edges.is_outward, is_whole && name == "bumpy", "{name}");
                let is_concave = |n: &u32| {
                    let corners = corners_of(&edges, &edges.list[*n as usize]);
                    edges.is_outward && is_concave(&corners, EDGE_ON * edges.diagonal())
                };
                let outlines: Vec<u32> = expected.iter().copied().filter(|n| !is_concave(n)).collect();
                for view in 0..VIEWS_WITHOUT_CONES + 2 {
                    // Cones are made in one of these views.
                    let edges = if view == 0 { &edges.clone() } else { &edges };
                    assert_eq!(edges.silhouettes(viewer), expected, "{name}, {viewer:?}, view {view}");
                    assert_eq!(edges.outlines(viewer), outlines, "{name}, {viewer:?}, view {view}");
                }
                let cones = edges.cones.for_view(&edges).expect("after several viewers");
                let (_, looked_at) = cones.candidates(viewer, false);
                let share = looked_at.len() as f64 / edges.list.len() as f64;
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

/// What a solid hides of itself is known only if no part of it is turned inside out.
#[test]
fn walls_of_cavities_are_not_outward() {
    let of = |mesh: &Mesh| {
        let edges = Edges::of_mesh(mesh, Selection::All);
        (edges.is_solid, edges.is_outward)
    };
    let outer = bumpy();
    let mut inner = builtin::make("builtin:sphere@1k").expect("a model");
    inner.positions.iter_mut().flatten().for_each(|c| *c *= 0.5);
    let both = |inner: &Mesh| {
        let mut both = outer.clone();
        let first = both.positions.len() as u32;
        both.positions.extend(&inner.positions);
        both.triangles.extend(inner.triangles.iter().map(|t| t.map(|v| first + v)));
        both
    };
    assert_eq!(of(&outer), (true, true));
    assert_eq!(of(&both(&inner)), (true, true));
    inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_eq!(of(&both(&inner)), (true, false));
    assert_eq!(of(&inner), (true, false));
    // One that touches another in a vertex, or in an edge.
    let cube = |from: [f32; 3], is_inside_out: bool| {
        let positions =
            (0..8u8).map(|k| [0, 1, 2].map(|axis| from[axis] + f32::from(k >> axis & 1))).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles = halves.map(|[a, b, c]| if is_inside_out { [a, c, b] } else { [a, b, c] }).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    };
    let outer = cube([0.0; 3], false);
    let beside = |from: [f32; 3], is_inside_out: bool| {
        let (mut both, other) = (outer.clone(), cube(from, is_inside_out));
        both.positions.extend(other.positions);
        both.triangles.extend(other.triangles.iter().map(|t| t.map(|v| 8 + v)));
        of(&both)
    };
    assert_eq!(of(&outer), (true, true));
    assert_eq!([false, true].map(|turned| beside([1.0; 3], turned)), [(true, true), (true, false)]);
    assert_eq!([false, true].map(|turned| beside([1.0, 1.0, 0.0], turned)), [(true, false); 2]);
    inner.triangles.pop();
    assert_eq!(of(&inner), (false, false));
}

/// Nothing that a viewer outside of it sees is left out: the middle of a silhouette edge at which the mesh is concave is behind another
/// triangle.
#[test]
fn concave_edges_of_solids_are_hidden() {
    let mesh = bumpy();
    let edges = Edges::of_mesh(&mesh, Selection::All);
    let at = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    let is_hit = |from: DVec3, to: DVec3| {
        mesh.triangles.iter().any(|t| {
            let [a, b, c] = t.map(at);
            let (direction, u, v) = (to - from, b - a, c - a);
            let normal = direction.cross(v);
            let (det, s) = (u.dot(normal), from - a);
            let [x, y] = [s.dot(normal) / det, direction.dot(s.cross(u)) / det];
            let along = v.dot(s.cross(u)) / det;
            x >= 0.0 && y >= 0.0 && x + y <= 1.0 && (1e-9..1.0 - 1e-6).contains(&along)
        })
    };
    let mut checked = 0;
    for eye in [DVec3::new(0.3, -3.0, 0.8), DVec3::new(2.0, 0.1, 1.4)] {
        let viewer = Viewer::At(eye);
        let kept = edges.outlines(viewer);
        for number in edges.silhouettes(viewer).into_iter().filter(|n| !kept.contains(n)) {
            let middle =
                corners_of(&edges, &edges.list[number as usize]).ends.map(|p| DVec3::from(p.map(f64::from)));
            assert!(is_hit(eye, (middle[0] + middle[1]) * 0.5), "{eye}: edge {number}");
            checked += 1;
        }
        assert!(!kept.is_empty());
    }
    assert!(checked > 50, "{checked}");
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
    // What is left is for the rounding of products with them.
    assert!((ROUNDING / 4.0..0.9 * ROUNDING).contains(&most), "{most}");
}
