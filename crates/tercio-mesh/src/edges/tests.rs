use super::*;
use crate::cluster::{PartitionOptions, partition};
use crate::{Attribute, AttributeDomain, builtin, topology};

/// A cube of six squares, each of two triangles.
fn cube() -> Mesh {
    let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|c| c as f32)).collect();
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let face_of_triangle = Some((0..12).map(|t| t / 2).collect());
    Mesh { positions, triangles, face_of_triangle, ..Mesh::default() }
}

#[test]
fn a_cube_has_twelve_edges_of_each_kind_that_it_has() {
    let mut mesh = cube();
    for selection in [Selection::All, Selection::Feature(1.57), Selection::Silhouette] {
        let edges = Edges::of_mesh(&mesh, selection);
        assert!(edges.is_solid);
        assert_eq!((edges.list.len(), edges.count(EdgeKind::Inner), edges.positions.len()), (12, 12, 8));
    }
    assert!(Edges::of_mesh(&mesh, Selection::Feature(1.58)).list.is_empty());
    assert!(Edges::of_mesh(&mesh, Selection::Boundary).list.is_empty());
    // As one cell, the surface of a hexahedron, whose polygons are numbered.
    mesh.face_of_triangle = Some(vec![0; 12]);
    let (name, domain) = (Attribute::POLYGON.into(), AttributeDomain::Triangle);
    mesh.attributes.push(Attribute {
        name,
        domain,
        values: (0..12).map(|t| (t / 2) as f32).collect(),
        offset: 0.0,
        component: None,
    });
    assert_eq!(Edges::of_mesh(&mesh, Selection::All).list.len(), 12);
    let clusters = partition(mesh.clone(), &PartitionOptions::default());
    assert_eq!(Edges::of_clusters(&clusters, Selection::All).list.len(), 12);
    mesh.attributes.clear();
    assert!(Edges::of_mesh(&mesh, Selection::All).list.is_empty(), "one polygon, whatever its angles");
    // Without polygons, the diagonals are edges, but not features.
    mesh.face_of_triangle = None;
    assert_eq!(Edges::of_mesh(&mesh, Selection::All).list.len(), 18);
    assert_eq!(Edges::of_mesh(&mesh, Selection::Silhouette).list.len(), 12);
    // One triangle less, and one that is wound the other way.
    mesh.triangles.pop();
    mesh.triangles[0].swap(0, 1);
    let edges = Edges::of_mesh(&mesh, Selection::Boundary);
    assert_eq!((edges.list.len(), edges.is_solid), (3, false));
    assert_eq!(Edges::of_mesh(&mesh, Selection::Feature(0.5)).list.len(), 13, "12, and the diagonal");
}

#[test]
fn the_fold_of_a_polygon_may_be_an_outline_but_is_no_edge() {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let face_of_triangle = Some(vec![0; 2]);
    let quad = Mesh { positions, triangles, face_of_triangle, ..Mesh::default() };
    let edges = |selection| Edges::of_mesh(&quad, selection).list.len();
    assert_eq!((edges(Selection::Silhouette), edges(Selection::All)), (5, 4));
}

#[test]
fn an_edge_of_three_triangles_is_there_whatever_the_angle() {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let triangles = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    let edges = Edges::of_mesh(&Mesh { positions, triangles, ..Mesh::default() }, Selection::Boundary);
    assert_eq!((edges.count(EdgeKind::NonManifold), edges.count(EdgeKind::Boundary)), (2, 6));
}

/// Counts agree with the topology and with Euler's formula, before and after partition into clusters.
#[test]
fn edges_are_those_of_the_topology_however_the_mesh_is_split() {
    for name in ["builtin:sphere@2k", "builtin:teapot@3k", "builtin:gyroid@5k"] {
        let mesh = builtin::make(name).expect("a built-in model");
        let topology = topology::analyze(&mesh);
        for selection in [Selection::All, Selection::Feature(0.3), Selection::Boundary] {
            let edges = Edges::of_mesh(&mesh, selection);
            if selection == Selection::All {
                assert_eq!(edges.list.len() as u64, topology.edges, "{name}");
                let euler = topology.euler_characteristic() - topology.triangles as i64;
                assert_eq!(topology.vertices as i64 - edges.list.len() as i64, euler);
            }
            assert_eq!(edges.count(EdgeKind::Boundary) as u64, topology.boundary_edges, "{name}");
            for max_triangles in [128, 17] {
                let options = PartitionOptions { max_triangles, ..PartitionOptions::default() };
                let split = Edges::of_clusters(&partition(mesh.clone(), &options), selection);
                assert_eq!((&split.list, &split.positions), (&edges.list, &edges.positions), "{name}");
                assert_eq!(split.is_solid, edges.is_solid);
            }
        }
    }
}

/// Sides of triangles are edges where a pair of vertices is no diagonal, before and after partition into clusters.
#[test]
fn sides_are_those_of_the_edges() {
    let mesh = cube();
    let corners: Vec<[u32; 3]> = mesh.triangles.iter().map(|&t| Mesh::canonical(t)).collect();
    let diagonal = |t: usize, k: usize| {
        let side = [corners[t][(k + 1) % 3], corners[t][(k + 2) % 3]];
        side.iter().all(|v| corners[t ^ 1].contains(v))
    };
    let expected: Vec<u8> = (0..12).map(|t| (0..3).map(|k| u8::from(!diagonal(t, k)) << k).sum()).collect();
    assert!(expected.iter().all(|sides| sides.count_ones() == 2));
    assert_eq!(Edges::of_mesh(&mesh, Selection::All).sides, expected);
    let clusters = partition(mesh, &PartitionOptions { max_triangles: 3, ..PartitionOptions::default() });
    assert_eq!(Edges::of_clusters(&clusters, Selection::All).sides, expected);
    assert_eq!(Edges::of_clusters(&clusters, Selection::Boundary).sides, [0; 12]);
    // A strip of two triangles: four edges of one triangle, and one between them that is no feature.
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let flat = Mesh { positions, triangles: vec![[0, 1, 2], [2, 1, 3]], ..Mesh::default() };
    assert_eq!(Edges::of_mesh(&flat, Selection::All).sides, [0b111, 0b111]);
    assert_eq!(Edges::of_mesh(&flat, Selection::Feature(0.5)).sides, [0b110, 0b101]);
}

/// Two triangles of one polygon for each quadrilateral, whose diagonal is from corner 0 to corner 2.
fn quads(corners: &[[[f32; 3]; 4]]) -> Mesh {
    let triangles =
        (0..corners.len() as u32).flat_map(|q| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| 4 * q + k)));
    let triangles: Vec<_> = triangles.collect();
    let face_of_triangle = Some((0..triangles.len() as u32).map(|t| t / 2).collect());
    let positions = corners.as_flattened().to_vec();
    Mesh { positions, triangles, face_of_triangle, ..Mesh::default() }
}

#[test]
fn the_fourth_corner_of_each_half_is_where_the_other_half_has_it() {
    // Squares, and a trapezium, in any order of their corners.
    for turned in 0..4 {
        let mut trapezium = [[0.0, 0.0, 1.0], [4.0, 0.0, 2.0], [3.0, 1.0, 2.0], [1.0, 1.0, 1.5]];
        trapezium.rotate_left(turned);
        let mesh = quads(&[trapezium]);
        let edges = Edges::of_mesh(&mesh, Selection::All);
        let clustered = partition(mesh.clone(), &PartitionOptions::default());
        assert_eq!(Edges::of_clusters(&clustered, Selection::All).beyond, edges.beyond);
        let Beyond::Quadrilaterals(fourth) = edges.beyond else { panic!("a quadrilateral") };
        assert_eq!([0, 1].map(|t| fourth.of(t)), [3, 1].map(|v| Some(mesh.positions[v])), "{turned}");
        assert!(edges.folds.is_none());
    }
    let of_cube = |selection| Edges::of_mesh(&cube(), selection).beyond;
    let Beyond::Quadrilaterals(fourth) = of_cube(Selection::All) else { panic!("quadrilaterals") };
    assert!((0..12).all(|t| fourth.of(t).is_some()));
    assert_eq!(of_cube(Selection::Feature(0.5)), Beyond::Nothing);
    // Bent at the diagonal.
    for degrees in [0.5f64, 2.0, 45.0, 91.0, 179.0] {
        let (y, z) = degrees.to_radians().sin_cos();
        let raised = [1.0, z as f32, y as f32];
        let mesh = quads(&[[[0.0; 3], [1.0, -1.0, 0.0], [2.0, 0.0, 0.0], raised]]);
        let edges = Edges::of_mesh(&mesh, Selection::All);
        let Beyond::Quadrilaterals(fourth) = &edges.beyond else { panic!("a quadrilateral") };
        assert_eq!([0, 1].map(|t| fourth.of(t)), [3, 1].map(|v| Some(mesh.positions[v])), "{degrees}");
        let Some(folds) = edges.folds else {
            assert!(degrees < 1.0);
            continue;
        };
        let [fold] = &folds.sides.list[..] else { panic!("one fold") };
        let at = |v: u32| folds.sides.positions[v as usize];
        let (mut ends, mut apexes) = (fold.ends.map(at), fold.apexes.map(at));
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        apexes.sort_by(|a, b| a[1].total_cmp(&b[1]));
        assert_eq!((ends, apexes), ([[0.0; 3], [2.0, 0.0, 0.0]], [[1.0, -1.0, 0.0], raised]));
        let mut around = folds.edges[0];
        around.sort_unstable();
        assert_eq!(around, [0, 1, 2, 3]);
    }
}

/// A polygon with these corners, of triangles at the first one, or in a strip.
fn polygon(corners: &[[f32; 3]], is_fan: bool) -> Mesh {
    let n = corners.len() as u32;
    let triangle = |t: u32| match is_fan {
        true => [0, t + 1, t + 2],
        false if t.is_multiple_of(2) => [t / 2, t / 2 + 1, n - 1 - t / 2],
        false => [t / 2 + 1, n - 2 - t / 2, n - 1 - t / 2],
    };
    let triangles: Vec<_> = (0..n - 2).map(triangle).collect();
    let face_of_triangle = Some(vec![0; triangles.len()]);
    Mesh { positions: corners.to_vec(), triangles, face_of_triangle, ..Mesh::default() }
}

/// Of each triangle of a polygon, the edges at the ends of a side that is none: their other ends are on the lines that the
/// numbers mean.
#[test]
fn places_are_on_the_edges_of_the_polygon() {
    let convex = [[0.0, 0.0], [3.0, -1.0], [5.0, 1.0], [5.5, 4.0], [3.0, 6.0], [-0.5, 4.5], [-1.0, 2.0]];
    let lift = |[x, y]: [f32; 2]| [x, y, 0.25 * x + 0.5 * y];
    let cases = [(convex.map(lift).to_vec(), true), (convex.map(lift).to_vec(), false)];
    for (corners, is_fan) in cases {
        let n = corners.len();
        let mesh = polygon(&corners, is_fan);
        let edges = Edges::of_mesh(&mesh, Selection::All);
        let clustered = partition(mesh.clone(), &PartitionOptions { max_triangles: 2, ..Default::default() });
        assert_eq!(Edges::of_clusters(&clustered, Selection::All).beyond, edges.beyond);
        let Beyond::Polygons(places) = &edges.beyond else { panic!("a polygon") };
        let mut count = 0;
        for (t, &triangle) in mesh.triangles.iter().enumerate() {
            let c = Mesh::canonical(triangle).map(|v| v as usize);
            for k in 0..3 {
                let (p, q, r) = (c[k], c[(k + 1) % 3], c[(k + 2) % 3]);
                if edges.sides[t] >> k & 1 == 1 {
                    assert_eq!(places[t][k], [0.0; 2], "a side that is an edge");
                    continue;
                }
                for (place, pivot, beside) in [(places[t][k][0], r, q), (places[t][k][1], q, r)] {
                    // The edge at the pivot that is on the other side.
                    let at = |v: usize| DVec3::from(corners[v].map(f64::from));
                    let normal = (at(q) - at(p)).cross(at(r) - at(p));
                    let outwards = (at(r) - at(q)).cross(normal);
                    let ends = [(pivot + 1) % n, (pivot + n - 1) % n];
                    let end =
                        *ends.iter().find(|&&v| outwards.dot(at(v) - at(pivot)) > 1e-9).expect("one beyond");
                    // Barycentric coordinates of its end, times the same.
                    let weight = |a: usize, b: usize| normal.dot((at(b) - at(a)).cross(at(end) - at(a)));
                    let of_p = weight(q, r);
                    let of_beside = if beside == q { weight(r, p) } else { weight(p, q) };
                    let expected = -of_beside / of_p;
                    let place = f64::from(place);
                    assert!(
                        (place - expected.max(0.0)).abs() < 1e-5 * expected.abs().max(1.0),
                        "{t} {k}: {place}, expected {expected}"
                    );
                    count += 1;
                }
            }
        }
        assert_eq!(count, 4 * (n - 3), "two at each side of a diagonal");
    }
}

/// Of polygons that are bent, and of flat ones with a reflex angle, the far ends of edges are the next corners.
#[test]
fn far_ends_are_the_next_corners_of_the_polygon() {
    let convex = [[0.0, 0.0], [3.0, -1.0], [5.0, 1.0], [5.5, 4.0], [3.0, 6.0], [-0.5, 4.5], [-1.0, 2.0]];
    let bent = convex.map(|[x, y]: [f32; 2]| [x, y, 0.1 * (x * x - y * x)]).to_vec();
    let reflex = vec![[0.0; 3], [6.0, 0.0, 0.0], [6.0, 4.0, 0.0], [3.0, 2.5, 0.0], [0.0, 4.0, 0.0]];
    // From the corner with the reflex angle, all triangles run the same way.
    let star = vec![[3.0, 2.5, 0.0], [0.0, 4.0, 0.0], [0.0; 3], [6.0, 0.0, 0.0], [6.0, 4.0, 0.0]];
    for (corners, is_fan, is_bent) in
        [(bent.clone(), true, true), (bent, false, true), (reflex, true, false), (star, true, false)]
    {
        let n = corners.len();
        let mesh = polygon(&corners, is_fan);
        let edges = Edges::of_mesh(&mesh, Selection::All);
        let clustered = partition(mesh.clone(), &PartitionOptions { max_triangles: 2, ..Default::default() });
        let of_clusters = Edges::of_clusters(&clustered, Selection::All);
        let [Beyond::Ends(ends), Beyond::Ends(same)] = [&edges.beyond, &of_clusters.beyond] else {
            panic!("any polygon")
        };
        assert_eq!(edges.folds.is_some(), is_bent);
        let mut count = 0;
        for (t, &triangle) in mesh.triangles.iter().enumerate() {
            assert!(ends.of(t).eq(same.of(t)));
            let c = Mesh::canonical(triangle).map(|v| v as usize);
            for k in 0..3 {
                let far: Vec<_> = ends.of(t).filter(|far| usize::from(far.side) == k).collect();
                if edges.sides[t] >> k & 1 == 1 {
                    assert!(far.is_empty(), "a side that is an edge");
                    continue;
                }
                let [p, q, r] = [0, 1, 2].map(|i| c[(k + i) % 3]);
                // On the way round the polygon from q to r that does not pass p.
                let is_forwards = (1..n).map(|i| (q + i) % n).take_while(|v| *v != r).all(|v| v != p);
                let next = |v: usize, forwards: bool| corners[(v + if forwards { 1 } else { n - 1 }) % n];
                let expected = [next(q, is_forwards), next(r, !is_forwards)];
                assert_eq!(far.iter().map(|far| far.end).collect::<Vec<_>>(), [0, 1]);
                assert_eq!([far[0].position, far[1].position], expected, "{t} {k}");
                count += 2;
            }
        }
        assert_eq!(count, 4 * (n - 3), "two at each side of a diagonal");
    }
}

#[test]
fn only_polygons_have_edges_beyond_sides() {
    let beyond = |mesh: &Mesh| Edges::of_mesh(mesh, Selection::All).beyond;
    // A corner in the middle of a side: lines are those of the sides.
    let hanging =
        |y: f32| polygon(&[[0.0; 3], [1.0, y, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]], true);
    for y in [0.0, 1e-7, -1e-7, 1e-4, -1e-4] {
        let Beyond::Polygons(numbers) = beyond(&hanging(y)) else { panic!("a polygon") };
        // The second triangle has corners 0, 2 and 3; its first side begins at 0.
        assert!(numbers[1][2].iter().all(|number| *number >= 5e3 && *number <= 1e6), "{y}: {numbers:?}");
        assert!(numbers.iter().flatten().flatten().all(|number| (0.0..=1e6).contains(number)), "{numbers:?}");
    }
    // Triangles have none, also beside one that is none.
    let mut triangles = cube();
    triangles.face_of_triangle = None;
    assert_eq!(beyond(&triangles), Beyond::Nothing);
    triangles.triangles.push([1, 1, 2]);
    assert_eq!(beyond(&triangles), Beyond::Nothing);
    // A quadrilateral and a triangle.
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 1.0, 0.0]];
    let mut pentagon = polygon(&corners, true);
    pentagon.face_of_triangle = Some(vec![0, 0, 1]);
    let Beyond::Quadrilaterals(mixed) = beyond(&pentagon) else { panic!("at most four corners") };
    assert_eq!([0, 1, 2].map(|t| mixed.of(t).is_some()), [true, true, false]);
    // Triangles that run against each other, and a corner in the middle of a polygon.
    let mut turned = polygon(&corners, true);
    let straight = beyond(&turned);
    turned.triangles[1].swap(1, 2);
    let (a, b) = (straight.numbers(), beyond(&turned));
    let sorted = |numbers: &[f32]| {
        let mut sorted: Vec<_> = numbers.iter().map(|c| (c * 1e5).round()).collect();
        sorted.sort_by(f32::total_cmp);
        sorted
    };
    assert_eq!(sorted(a), sorted(b.numbers()));
    let mut around =
        polygon(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]], true);
    around.triangles.push([0, 4, 1]);
    around.face_of_triangle = Some(vec![0; 4]);
    let Beyond::Polygons(numbers) = beyond(&around) else { panic!("a polygon") };
    assert!(numbers.iter().flatten().all(|pair| pair.contains(&0.0)), "{numbers:?}");
}

/// A polygon that touches itself has triangles with two vertices that no edge uses; one of them is bent.
#[test]
fn polygons_with_spurs_are_gone_round_once() {
    let corners: Vec<[f32; 3]> =
        (0..10u8).map(|k| [f32::from(k % 4), f32::from(k / 4), f32::from(k * k % 7) * 0.3]).collect();
    let around: [u32; 16] = [3, 2, 1, 0, 9, 0, 4, 5, 7, 8, 7, 5, 6, 5, 4, 0];
    for is_fan in [true, false] {
        let positions: Vec<[f32; 3]> = around.iter().map(|&v| corners[v as usize]).collect();
        let mesh = polygon(&positions, is_fan);
        let edges = Edges::of_mesh(&mesh, Selection::All);
        let Beyond::Ends(ends) = &edges.beyond else { panic!("a bent polygon") };
        let all: Vec<_> = (0..mesh.triangles.len()).flat_map(|t| ends.of(t)).collect();
        assert!(!all.is_empty() && all.iter().all(|far| positions.contains(&far.position)));
    }
}
