use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::topology::analyze;
use crate::weld::weld;
use crate::{Attribute, AttributeDomain, builtin};

fn plane(x: f64, y: f64, z: f64, offset: f64) -> ClipPlane {
    ClipPlane::new(DVec3::new(x, y, z), offset).expect("a plane")
}

fn opposite(p: &ClipPlane) -> ClipPlane {
    ClipPlane::new(-p.normal(), -p.distance(DVec3::ZERO)).expect("a plane")
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> {
    let world = |v: u32| mesh.origin + glam::Vec3::from(mesh.positions[v as usize]).as_dvec3() * mesh.unit();
    mesh.triangles.iter().map(move |t| t.map(world))
}

fn area(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| (b - a).cross(c - a).length() * 0.5).sum()
}

/// By the divergence theorem, relative to a point near the mesh.
fn volume(mesh: &Mesh) -> f64 {
    let o = mesh.bounds().center();
    corners(mesh).map(|[a, b, c]| (a - o).dot((b - o).cross(c - o)) / 6.0).sum()
}

/// A mesh and its caps.
fn joined(mesh: &Mesh, caps: Option<&Mesh>) -> Mesh {
    let mut all = Mesh { face_of_triangle: None, ..bare(mesh) };
    if let Some(caps) = caps {
        assert_eq!((caps.origin, caps.exponent), (mesh.origin, mesh.exponent));
        let first = all.positions.len() as u32;
        all.positions.extend(&caps.positions);
        all.triangles.extend(caps.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

fn bare(mesh: &Mesh) -> Mesh {
    let (positions, triangles) = (mesh.positions.clone(), mesh.triangles.clone());
    Mesh { origin: mesh.origin, exponent: mesh.exponent, positions, triangles, ..Mesh::default() }
}

#[track_caller]
fn assert_closed(mesh: &Mesh, caps: Option<&Mesh>, what: &str) {
    let found = analyze(&joined(mesh, caps));
    assert!(found.closed && found.consistently_wound, "{what}: {found:?}");
}

#[track_caller]
fn near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found}, not {expected}");
}

/// A box from one corner to another, 12 triangles.
fn block(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let at = |i: usize, k: usize| if i >> k & 1 == 0 { low[k] } else { high[k] };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(|i| [0, 1, 2].map(|k| at(i, k))).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

/// All triangles of both.
fn with(mut a: Mesh, b: &Mesh) -> Mesh {
    let first = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + first)));
    a
}

fn moved(mut mesh: Mesh, by: [f32; 3], scale: f32) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p = [0, 1, 2].map(|k| p[k] * scale + by[k]));
    mesh
}

fn inverted(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh
}

fn sphere(count: u32) -> Mesh {
    bare(&builtin::make(&format!("builtin:sphere@{count}")).expect("a sphere"))
}

/// Clips a copy on both sides and checks what holds for every closed mesh; returns the kept part with its caps.
#[track_caller]
fn check_both_sides(mesh: &Mesh, at: &ClipPlane, what: &str) -> (Mesh, Option<Mesh>) {
    let (mut kept, mut other) = (mesh.clone(), mesh.clone());
    let clipped = clip(&mut kept, &[*at], true).expect("a part");
    let rest = clip(&mut other, &[opposite(at)], true).expect("the rest");
    assert_eq!((clipped.open_outlines, rest.open_outlines), (0, 0), "{what}");
    assert_closed(&kept, clipped.caps.as_ref(), what);
    assert_closed(&other, rest.caps.as_ref(), what);
    assert_eq!(clipped.cut, rest.cut, "{what}");
    let [a, b] = [&kept, &other].map(area);
    near(a + b, area(mesh), 1e-5);
    let [a, b] = [(&kept, &clipped), (&other, &rest)].map(|(m, c)| volume(&joined(m, c.caps.as_ref())));
    near(a + b, volume(mesh), 1e-5);
    let [a, b] = [&clipped, &rest].map(|c| c.caps.as_ref().map_or(0.0, area));
    assert!((a - b).abs() <= 1e-5 * (a + b), "{what}: caps of {a} and {b}");
    for p in kept.positions.iter().chain(clipped.caps.iter().flat_map(|c| &c.positions)) {
        let world = kept.origin + glam::Vec3::from(*p).as_dvec3() * kept.unit();
        assert!(
            at.distance(world) >= -1e-6 * (world.length() + mesh.bounds().size().length()),
            "{what}: {world}"
        );
    }
    (kept, clipped.caps)
}

#[test]
fn a_plane_keeps_the_side_of_its_normal() {
    let mut cube = block([0.0; 3], [1.0; 3]);
    let clipped = clip(&mut cube, &[plane(2.0, 0.0, 0.0, -0.5)], true).expect("a part");
    assert_eq!(cube.bounds().min, DVec3::new(0.25, 0.0, 0.0));
    assert_eq!((clipped.removed, clipped.cut), (2, 8));
    assert_eq!((clipped.outlines, clipped.open_outlines), (1, 0));
    let caps = clipped.caps.expect("a cap");
    near(area(&caps), 1.0, 1e-7);
    let normals = caps.normals.as_deref().expect("normals");
    assert!(normals.iter().all(|n| *n == OctNormal::from_vector([-1.0, 0.0, 0.0])));
    assert_eq!(caps.bounds().max.x, 0.25);
    near(volume(&joined(&cube, Some(&caps))), 0.75, 1e-6);
    assert_closed(&cube, Some(&caps), "cube");
}

#[test]
fn a_mesh_of_which_nothing_is_cut_away_is_not_changed() {
    let mut mesh = builtin::make("builtin:terrain@2k").expect("a terrain");
    mesh.positions.push([7.0; 3]);
    mesh.normals.as_mut().expect("normals").push(OctNormal::default());
    mesh.vertex_colors.as_mut().expect("colours").push([0; 4]);
    let before = mesh.clone();
    let clipped = clip(&mut mesh, &[plane(0.0, 1.0, 0.0, 1e3)], true).expect("no change");
    assert_eq!((clipped.removed, clipped.cut, clipped.outlines), (0, 0, 0));
    assert!(mesh.positions == before.positions && mesh.triangles == before.triangles);
    assert_eq!(mesh.face_of_triangle, None);
    // And of which all is cut away, nothing is left.
    let clipped = clip(&mut mesh, &[plane(0.0, -1.0, 0.0, -1e3)], true).expect("nothing");
    assert_eq!(clipped.removed, before.triangles.len() as u64);
    assert!(mesh.positions.is_empty() && mesh.triangles.is_empty() && clipped.caps.is_none());
    assert!(mesh.vertex_colors.is_some_and(|c| c.is_empty()));
}

#[test]
fn triangles_that_are_not_cut_keep_their_bits_and_faces() {
    let mesh = builtin::make("builtin:terrain@5k").expect("a terrain");
    let mut part = mesh.clone();
    clip(&mut part, &[plane(1.0, 0.3, -0.2, 0.1)], false).expect("a part");
    let faces = part.face_of_triangle.as_deref().expect("numbers");
    assert!(faces.is_sorted());
    assert_eq!(part.normals.as_ref().map(Vec::len), Some(part.positions.len()));
    assert_eq!(part.vertex_colors.as_ref().map(Vec::len), Some(part.positions.len()));
    let data = |mesh: &Mesh, t: usize| {
        let vertices = Mesh::canonical(mesh.triangles[t]).map(|v| v as usize);
        let (normals, colors) = (mesh.normals.as_ref().unwrap(), mesh.vertex_colors.as_ref().unwrap());
        vertices.map(|v| (mesh.positions[v].map(f32::to_bits), normals[v], colors[v]))
    };
    let mut whole = 0;
    for (t, &face) in faces.iter().enumerate() {
        whole += usize::from(data(&part, t) == data(&mesh, face as usize));
    }
    let kept = |t: &[u32; 3]| {
        t.iter().all(|&v| {
            plane(1.0, 0.3, -0.2, 0.1).distance(glam::Vec3::from(mesh.positions[v as usize]).into()) > 0.0
        })
    };
    assert_eq!(whole, mesh.triangles.iter().filter(|t| kept(t)).count());
}

#[test]
fn cut_edges_get_what_is_between_their_ends() {
    let attribute =
        |domain, values| Attribute { name: "a".into(), domain, values, offset: 0.0, component: None };
    let mut mesh = Mesh {
        positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: Some(
            [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
                .map(OctNormal::from_vector)
                .into(),
        ),
        vertex_colors: Some(vec![[0, 0, 100, 0], [255, 0, 100, 200], [255, 0, 100, 200], [0, 0, 100, 0]]),
        face_colors: Some(vec![[1; 4], [2; 4]]),
        texcoords: Some(vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]),
        attributes: vec![
            attribute(AttributeDomain::Vertex, vec![0.0, 8.0, 8.0, 0.0]),
            attribute(AttributeDomain::Triangle, vec![10.0, 20.0]),
        ],
        triangle_materials: Some(vec![5, 6]),
        face_of_triangle: Some(vec![3, 3]),
        ..Mesh::default()
    };
    clip(&mut mesh, &[plane(-1.0, 0.0, 0.0, 2.0)], false).expect("a part");
    let cut: Vec<usize> = (0..mesh.positions.len()).filter(|&v| mesh.positions[v][0] == 2.0).collect();
    assert_eq!(cut.len(), 3);
    for v in cut {
        let [_, y, _] = mesh.positions[v];
        assert_eq!(mesh.texcoords.as_ref().unwrap()[v], [0.5, 1.0 - y / 4.0]);
        // Half of the light is 188 of 255 levels; alpha is linear.
        assert_eq!(mesh.vertex_colors.as_ref().unwrap()[v], [188, 0, 100, 100]);
        assert_eq!(mesh.attributes[0].values[v], 4.0);
        let normal = glam::Vec3::from(mesh.normals.as_ref().unwrap()[v].decode()).normalize();
        assert!(normal.dot(glam::Vec3::new(1.0, 0.0, 1.0).normalize()) > 0.999_999);
    }
    let of_first = mesh.triangles.len() - 2;
    assert_eq!(of_first, 1);
    assert_eq!(mesh.face_colors, Some(vec![[1; 4], [2; 4], [2; 4]]));
    assert_eq!(mesh.triangle_materials, Some(vec![5, 6, 6]));
    assert_eq!(mesh.face_of_triangle, Some(vec![3; 3]));
    assert_eq!(mesh.attributes[1].values, [10.0, 20.0, 20.0]);
    near(area(&mesh), 8.0, 1e-7);
}

#[test]
fn vertices_in_the_plane_are_not_cut_beside() {
    // 0.1 is no f32: the plane is a little beside the vertices.
    let mut mesh = block([0.0; 3], [0.1; 3]);
    mesh = with(mesh, &block([0.1, 0.0, 0.0], [0.2, 0.1, 0.1]));
    let (kept, caps) = check_both_sides(&mesh, &plane(1.0, 0.0, 0.0, -0.1), "boxes");
    assert_eq!((kept.positions.len(), kept.triangles.len()), (8, 12));
    assert!(caps.is_none(), "each box is whole, as it was");
    // Through all vertices of the equator, and through two opposite edges.
    let mesh = Mesh {
        positions: vec![
            [1., 0., 0.],
            [0., 1., 0.],
            [-1., 0., 0.],
            [0., -1., 0.],
            [0., 0., 1.],
            [0., 0., -1.],
        ],
        triangles: (0..4).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]).collect(),
        ..Mesh::default()
    };
    for at in [plane(0.0, 0.0, 1.0, 0.0), plane(1.0, 0.0, 0.0, 0.0), plane(1.0, 1.0, 0.0, 0.0)] {
        let (kept, caps) = check_both_sides(&mesh, &at, "octahedron");
        near(volume(&joined(&kept, caps.as_ref())), 2.0 / 3.0, 1e-6);
    }
    let mut half = mesh.clone();
    let clipped = clip(&mut half, &[plane(0.0, 0.0, 1.0, 0.0)], true).expect("a half");
    assert_eq!((clipped.removed, clipped.cut, half.positions.len()), (4, 0, 5));
    // Once more at the same plane changes nothing, and neither does touching a vertex.
    let again =
        clip(&mut half, &[plane(0.0, 0.0, 1.0, 0.0), plane(0.0, 0.0, -1.0, 1.0)], true).expect("the same");
    assert_eq!((again.removed, again.cut, again.outlines), (0, 0, 0));
}

#[test]
fn triangles_in_the_plane_are_kept_unless_they_end_what_was_cut_away() {
    let at = plane(0.0, 0.0, 1.0, -1.0);
    let cube = block([0.0; 3], [1.0; 3]);
    let mut lid = cube.clone();
    let clipped = clip(&mut lid, &[at], false).expect("a lid");
    assert_eq!((clipped.removed, clipped.cut, lid.triangles.len()), (10, 0, 2));
    let mut nothing = cube.clone();
    let clipped = clip(&mut nothing, &[at], true).expect("nothing");
    assert_eq!((nothing.triangles.len(), clipped.outlines, clipped.open_outlines), (0, 0, 0));
    // A step whose tread is in the plane: what stands on it gets a cap.
    let mut step = with(block([0.0; 3], [2.0, 1.0, 1.0]), &block([0.0, 0.0, 1.0], [1.0, 1.0, 2.0]));
    let clipped = clip(&mut step, &[at], true).expect("the upper part");
    near(volume(&joined(&step, clipped.caps.as_ref())), 1.0, 1e-6);
}

#[test]
fn parts_of_closed_models_have_their_volume_and_are_closed() {
    let ball = sphere(20_000);
    let planes = [(1.0, 0.0, 0.0, 0.0), (0.3, -0.9, 0.5, 0.2), (0.0, 1.0, 0.0, -0.7), (-1.0, 1.0, 1.0, 1.6)];
    for (x, y, z, d) in planes {
        let at = plane(x, y, z, d);
        let (kept, caps) = check_both_sides(&ball, &at, "sphere");
        // The volume of a cap of a sphere; flat triangles lack a little of it, most in a thin one.
        let distance = d / DVec3::new(x, y, z).length();
        let height = 1.0 + distance;
        let expected = std::f64::consts::PI * height * height * (3.0 - height) / 3.0;
        near(volume(&joined(&kept, caps.as_ref())), expected, 5e-3);
        let disc = std::f64::consts::PI * (1.0 - distance * distance);
        near(caps.as_ref().map_or(0.0, area), disc, 5e-3);
    }
    let shell = gyroid_shell();
    for (x, y, z, d) in planes {
        check_both_sides(&shell, &plane(x, y, z, 0.3 * d), "gyroid");
    }
    // Its handle and spout are open where they reach into the body, which ends at the lid.
    let mut teapot = bare(&builtin::make("builtin:teapot@20k").expect("a teapot"));
    assert!(!analyze(&teapot).closed);
    let clipped = clip(&mut teapot, &[plane(0.0, 0.0, 1.0, 0.01)], true).expect("a half");
    assert!(clipped.open_outlines > 0 && clipped.caps.is_none());
}

/// The gyroid, which is a surface with a border, as a solid: with its own image a little behind it, and walls between
/// the borders of both.
fn gyroid_shell() -> Mesh {
    let gyroid = builtin::make("builtin:gyroid@40k").expect("a gyroid");
    let mut shell = bare(&gyroid);
    let count = shell.positions.len() as u32;
    for (p, normal) in gyroid.positions.iter().zip(gyroid.normals.iter().flatten()) {
        let normal = glam::Vec3::from(normal.decode()).normalize();
        shell.positions.push([0, 1, 2].map(|k| p[k] - 0.004 * normal[k]));
    }
    let edges = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let all: std::collections::BTreeSet<(u32, u32)> = gyroid.triangles.iter().flat_map(edges).collect();
    shell.triangles.extend(gyroid.triangles.iter().map(|&[a, b, c]| [a + count, c + count, b + count]));
    for &(a, b) in all.iter().filter(|(a, b)| !all.contains(&(*b, *a))) {
        shell.triangles.extend([[b, a, a + count], [b, a + count, b + count]]);
    }
    let found = analyze(&shell);
    assert!(found.closed && found.consistently_wound, "{found:?}");
    shell
}

#[test]
fn a_hollow_ball_keeps_its_cavity() {
    let hollow = with(sphere(5_000), &inverted(moved(sphere(3_000), [0.1, 0.0, 0.0], 0.5)));
    let (_, caps) = check_both_sides(&hollow, &plane(0.1, 1.0, 0.2, 0.05), "hollow");
    let expected = area(&check_both_sides(&sphere(5_000), &plane(0.1, 1.0, 0.2, 0.05), "outer").1.unwrap())
        - area(
            &check_both_sides(
                &moved(sphere(3_000), [0.1, 0.0, 0.0], 0.5),
                &plane(0.1, 1.0, 0.2, 0.05),
                "inner",
            )
            .1
            .unwrap(),
        );
    near(area(&caps.unwrap()), expected, 1e-5);
    // The same with triangles of which some run the wrong way round: then what is between two surfaces is inside.
    let mut mixed = with(sphere(5_000), &moved(sphere(3_000), [0.1, 0.0, 0.0], 0.5));
    for t in mixed.triangles.iter_mut().step_by(7) {
        t.swap(1, 2);
    }
    let clipped = clip(&mut mixed, &[plane(0.1, 1.0, 0.2, 0.05)], true).expect("a part");
    assert_eq!((clipped.outlines, clipped.open_outlines), (2, 0));
    near(area(&clipped.caps.unwrap()), expected, 1e-5);
}

#[test]
fn solids_that_penetrate_each_other_have_one_cut() {
    let ball = sphere(4_000);
    let both = with(ball.clone(), &moved(ball.clone(), [0.9, 0.1, 0.05], 1.0));
    let at = plane(0.0, 0.1, 1.0, 0.02);
    let mut mesh = both.clone();
    let clipped = clip(&mut mesh, &[at], true).expect("a part");
    assert_eq!((clipped.outlines, clipped.open_outlines), (2, 0));
    // Two discs less their intersection, each of a little more than the unit circle.
    let d: f64 = 0.906;
    let lens = 2.0 * (d / 2.0).acos() - d / 2.0 * (4.0 - d * d).sqrt();
    near(area(&clipped.caps.unwrap()), 2.0 * std::f64::consts::PI - lens, 5e-3);
    // A second plane cuts that cap where the outlines cross, and both caps are whole.
    let second = plane(0.2, 1.0, 0.1, -0.1);
    let mut mesh = both;
    let clipped = clip(&mut mesh, &[at, second], true).expect("a part");
    assert_eq!(clipped.open_outlines, 0);
    let found = analyze(&joined(&mesh, clipped.caps.as_ref()));
    assert_eq!(found.boundary_edges, 0, "{found:?}");
}

#[test]
fn caps_of_several_planes_cut_each_other() {
    let mut corner = block([0.0; 3], [1.0; 3]);
    let is_cut_away = |t: &[u32; 3]| t.iter().all(|&v| corner.positions[v as usize][0] == 0.0);
    let (last, mut triangles): (Vec<_>, Vec<_>) = corner.triangles.iter().copied().partition(is_cut_away);
    triangles.extend(last);
    corner.triangles = triangles;
    let planes = [plane(1.0, 0.0, 0.0, -0.5), plane(0.0, 1.0, 0.0, -0.25), plane(0.0, 0.0, -1.0, 0.75)];
    let clipped = clip(&mut corner, &planes, true).expect("a part");
    let caps = clipped.caps.as_ref();
    assert_closed(&corner, caps, "corner");
    near(volume(&joined(&corner, caps)), 0.5 * 0.75 * 0.75, 1e-6);
    let faces = caps.and_then(|c| c.face_of_triangle.clone()).expect("planes");
    // Behind the 12 of the whole block, of which the last ones are cut away.
    let left = corner.face_of_triangle.as_ref().and_then(|f| f.last()).expect("a triangle") + 1;
    assert!(left < 12, "{left}");
    let mut of_planes: Vec<u32> = faces.iter().map(|face| left + face - 12).collect();
    assert!(of_planes.is_sorted());
    of_planes.dedup();
    assert_eq!(of_planes, [0, 1, 2]);
    for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2]] {
        let all = [plane(1.0, 0.1, 0.0, 0.1), plane(0.0, 1.0, 0.2, -0.1), plane(-0.3, 0.0, 1.0, 0.3)];
        let mut part = sphere(20_000);
        let clipped = clip(&mut part, &order.map(|i| all[i]), true).expect("a part");
        assert_eq!(clipped.open_outlines, 0);
        assert_closed(&part, clipped.caps.as_ref(), "part of a sphere");
    }
}

#[test]
fn open_outlines_are_counted_and_left_open() {
    let mut terrain = builtin::make("builtin:terrain@5k").expect("a terrain");
    let whole = area(&terrain);
    let mut other = terrain.clone();
    let at = plane(1.0, 0.0, 0.4, 0.03);
    let clipped = clip(&mut terrain, &[at], true).expect("a part");
    assert!(clipped.caps.is_none() && clipped.open_outlines == 1 && clipped.outlines == 0);
    clip(&mut other, &[opposite(&at)], true).expect("the rest");
    near(area(&terrain) + area(&other), whole, 1e-6);
    // An open box whose rim is just in the plane, from both sides.
    let mut open = block([0.0; 3], [1.0; 3]);
    open.triangles.truncate(10);
    let mut rest = open.clone();
    let clipped = clip(&mut open, &[plane(-1.0, 0.0, 0.0, 1.0)], true).expect("all");
    assert_eq!((clipped.removed, clipped.caps.is_none()), (0, true));
    let clipped = clip(&mut rest, &[plane(1.0, 0.0, 0.0, -1.0)], true).expect("nothing");
    assert!(rest.triangles.is_empty() && clipped.caps.is_none());
    // A closed ball and an open one: the closed one is capped.
    let mut balls = moved(sphere(2_000), [5.0, 0.0, 0.0], 1.0);
    balls.triangles.retain(|t| balls.positions[t[0] as usize][0] > 4.2);
    let clipped = clip(&mut with(balls, &sphere(2_000)), &[plane(0.0, 0.0, 1.0, 0.1)], true).expect("a part");
    assert_eq!((clipped.outlines, clipped.open_outlines), (1, 1));
    near(area(&clipped.caps.unwrap()), std::f64::consts::PI * 0.99, 1e-2);
}

#[test]
fn models_far_away_and_of_odd_sizes_are_clipped_in_their_coordinates() {
    let mut far = sphere(5_000);
    far.origin = DVec3::new(4_500_000.0, -700_000.0, 300.0);
    let at = plane(1.0, 1.0, 0.0, -3_800_000.2);
    let (kept, caps) = check_both_sides(&far, &at, "far");
    let height = 1.0 - 0.2 / 2f64.sqrt();
    let expected = std::f64::consts::PI * height * height * (3.0 - height) / 3.0;
    near(volume(&joined(&kept, caps.as_ref())), expected, 5e-3);
    for exponent in [-300i32, -60, 60, 120] {
        let mut odd = sphere(5_000);
        odd.exponent = exponent;
        let at = plane(1.0, 0.5, 0.0, 0.1 * odd.unit());
        let (kept, _) = check_both_sides(&odd, &at, "odd");
        let mut usual = sphere(5_000);
        clip(&mut usual, &[plane(1.0, 0.5, 0.0, 0.1)], true).expect("a part");
        assert!(kept.positions == usual.positions && kept.triangles == usual.triangles, "{exponent}");
    }
}

#[test]
fn an_outline_of_many_points_is_capped_in_little_time() {
    // A gear with teeth of different lengths, and a smaller one inside it as its hole.
    let sides = 100_000u32;
    let ring = |scale: f64| {
        let point = |i: u32| {
            let (sin, cos) = crate::trig::sin_cos(f64::from(i) / f64::from(sides) * std::f64::consts::TAU);
            let r = scale * if i.is_multiple_of(2) { 1.0 } else { 0.6 + 0.3 * f64::from(i % 1000) / 1000.0 };
            [(r * cos) as f32, (r * sin) as f32]
        };
        let at = |z: f32| (0..sides).map(move |i| (point(i), z)).map(|([x, y], z)| [x, y, z]);
        let walls = (0..sides).flat_map(|i| {
            let j = (i + 1) % sides;
            [[i, j, j + sides], [i, j + sides, i + sides]]
        });
        Mesh { positions: at(0.0).chain(at(1.0)).collect(), triangles: walls.collect(), ..Mesh::default() }
    };
    // It is open above and below, which is not seen in the middle.
    let mut gear = with(ring(1.0), &inverted(ring(0.5)));
    let clipped = clip(&mut gear, &[plane(0.0, 0.0, -1.0, 0.5)], true).expect("a part");
    assert_eq!((clipped.outlines, clipped.open_outlines), (2, 0));
    let polygon = |scale: f64| {
        let mesh = ring(scale);
        let p = |i: u32| glam::Vec3::from(mesh.positions[(i % sides) as usize]).as_dvec3();
        (0..sides).map(|i| p(i).x * p(i + 1).y - p(i).y * p(i + 1).x).sum::<f64>() / 2.0
    };
    near(area(&clipped.caps.unwrap()), polygon(1.0) - polygon(0.5), 1e-6);
}

#[test]
fn threads_do_not_change_a_byte() {
    let mesh = with(sphere(50_000), &moved(sphere(30_000), [0.5, 0.2, 0.1], 1.0));
    let planes = [plane(0.3, 1.0, 0.1, 0.1), plane(1.0, 0.0, 0.2, 0.2)];
    let clip_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut part = mesh.clone();
            let caps = clip(&mut part, &planes, true).expect("a part").caps.expect("caps");
            [part, caps].map(|m| (m.positions, m.triangles, m.normals, m.face_of_triangle))
        })
    };
    let one = clip_with(1);
    for threads in [2, 3, 7] {
        assert!(clip_with(threads) == one, "{threads} threads");
    }
}

#[test]
fn planes_by_fraction_and_bad_planes() {
    let bounds = crate::Aabb { min: DVec3::new(-2.0, 0.0, 1.0), max: DVec3::new(6.0, 1.0, 3.0) };
    let at =
        |axis, fraction, keeps_lower| Clip::Fraction { axis, fraction, keeps_lower }.plane(&bounds).unwrap();
    assert_eq!(at(Axis::X, 0.25, false), plane(1.0, 0.0, 0.0, 0.0));
    assert_eq!(at(Axis::X, 0.25, true), plane(-1.0, 0.0, 0.0, 0.0));
    assert_eq!(at(Axis::Z, 1.0, true), plane(0.0, 0.0, -1.0, 3.0));
    assert_eq!(Clip::Plane(plane(1.0, 2.0, 3.0, 4.0)).plane(&bounds), Some(plane(1.0, 2.0, 3.0, 4.0)));
    assert_eq!(
        Clip::Fraction { axis: Axis::Y, fraction: 0.5, keeps_lower: true }.plane(&crate::Aabb::EMPTY),
        None
    );
    for (normal, offset) in [
        (DVec3::ZERO, 1.0),
        (DVec3::NAN, 1.0),
        (DVec3::new(f64::INFINITY, 0.0, 0.0), 0.0),
        (DVec3::X, f64::NAN),
        (DVec3::X, f64::INFINITY),
        (DVec3::X * 1e101, 0.0),
        (DVec3::X * 1e-101, 0.0),
    ] {
        assert_eq!(ClipPlane::new(normal, offset), None, "{normal} {offset}");
    }
}

#[test]
fn an_empty_mesh_and_one_of_slivers_are_clipped() {
    let mut empty = Mesh::default();
    let clipped = clip(&mut empty, &[plane(1.0, 0.0, 0.0, 0.0)], true).expect("nothing");
    assert_eq!((clipped.removed, clipped.caps.is_none()), (0, true));
    // Every triangle has its corners on a line through the plane, or on the plane.
    let mut line = Mesh {
        positions: (0..30).map(|i| [i as f32 - 10.0, 0.0, 0.0]).collect(),
        triangles: (0..10)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .chain([[0, 10, 20], [10, 10, 29]])
            .collect(),
        ..Mesh::default()
    };
    clip(&mut line, &[plane(1.0, 0.0, 0.0, 0.0), plane(1.0, 1.0, 0.0, -0.5)], true).expect("a part");
    assert!(line.positions.iter().all(|p| p[0] >= 0.5));
}

/// Tetrahedra at whole coordinates: they touch, overlap and share edges in every way.
fn tetrahedra() -> impl Strategy<Value = Mesh> {
    let corner = prop::array::uniform3(-4i8..=4);
    prop::collection::vec(prop::array::uniform4(corner), 1..12).prop_map(|all| {
        let mut mesh = Mesh::default();
        for t in all {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(t.map(|p| p.map(f32::from)));
            let [a, b, c, d] = t.map(|p| glam::I64Vec3::from(p.map(i64::from)).as_dvec3());
            let [a, b, c, d] =
                if (b - a).cross(c - a).dot(d - a) < 0.0 { [0, 1, 2, 3] } else { [1, 0, 2, 3] };
            mesh.triangles.extend([[a, b, c], [a, d, b], [b, d, c], [a, c, d]].map(|t| t.map(|v| v + first)));
        }
        weld(&mut mesh);
        mesh
    })
}

/// Edges of the outlines cross each other as near to a point as coordinates are exact.
#[test]
fn crossings_that_round_to_points_are_capped() {
    let positions = [
        [2, -1, 3],
        [-2, -1, -1],
        [1, -1, 1],
        [4, 3, 4],
        [-1, -2, 0],
        [-1, 0, -1],
        [1, -2, 3],
        [-3, 3, 0],
        [0, 4, -3],
        [0, 0, 0],
        [-1, -3, 3],
        [1, 0, -1],
    ];
    let triangles = vec![
        [0, 1, 2],
        [0, 3, 1],
        [1, 3, 2],
        [0, 2, 3],
        [4, 5, 6],
        [4, 7, 5],
        [5, 7, 6],
        [4, 6, 7],
        [9, 8, 10],
        [9, 11, 8],
        [8, 11, 10],
        [9, 10, 11],
    ];
    let positions = positions.map(|p| p.map(|k: i8| f32::from(k))).to_vec();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    let first = plane(-3.0, 1.0, -1.0, -0.5);
    for second in [plane(2.0, 3.0, 2.0, 0.3), opposite(&plane(2.0, 3.0, 2.0, 0.3))] {
        let clipped = clip(&mut mesh.clone(), &[first, second], true).expect("a part");
        assert_eq!(clipped.open_outlines, 0);
    }
}

proptest! {
    /// Whatever solids do to each other: what is left, with caps as often as solids end there, has the volume of
    /// the parts, and the same on the other side.
    #[test]
    fn parts_of_any_solids_add_up(
        mesh in tetrahedra(),
        n in prop::array::uniform3(-3i8..=3),
        d in -6i8..=6,
        second in prop::array::uniform3(-3i8..=3),
    ) {
        let n = DVec3::from(n.map(f64::from));
        prop_assume!(n != DVec3::ZERO);
        let at = ClipPlane::new(n, f64::from(d) * 0.5).expect("a plane");
        let closed = |mesh: &mut Mesh, planes: &[ClipPlane]| {
            let mut caps = Caps::new(mesh);
            for (number, plane) in planes.iter().enumerate() {
                let local = LocalPlane::new(plane, mesh);
                let mut edges = Vec::new();
                if let Some(cut) = cut::cut(mesh, &local, true).expect("a cut") {
                    edges.extend(cut.outline);
                }
                if let Some(cut) = cut::cut(&mut caps.mesh, &local, true).expect("a cut") {
                    let weights = &caps.weights;
                    edges.extend(cut.outline.into_iter().map(|e| {
                        let weight = weights[e.triangle as usize];
                        Edge { segment: Segment { weight, ..e.segment }, ..e }
                    }));
                    caps.inherit(&cut.sources);
                }
                if !edges.is_empty() {
                    caps.add(&outline(edges, [mesh, &caps.mesh], &local), plane, &local, number as u32);
                }
            }
            let six = |[a, b, c]: [DVec3; 3]| a.dot(b.cross(c)) / 6.0;
            let of_caps: f64 =
                corners(&caps.mesh).zip(&caps.weights).map(|(c, &w)| six(c) * f64::from(w)).sum();
            (corners(mesh).map(six).sum::<f64>() + of_caps, caps.open_outlines)
        };
        let whole = corners(&mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum::<f64>();
        let (a, open_a) = closed(&mut mesh.clone(), &[at]);
        let (b, open_b) = closed(&mut mesh.clone(), &[opposite(&at)]);
        prop_assert_eq!((open_a, open_b), (0, 0));
        prop_assert!((a + b - whole).abs() < 1e-3, "{} + {}, not {}", a, b, whole);
        prop_assert!(a > -1e-3 && b > -1e-3, "{} {}", a, b);
        // And what is left in two steps.
        let second = DVec3::from(second.map(f64::from));
        if let Some(second) = ClipPlane::new(second, 0.3) {
            let (c, open_c) = closed(&mut mesh.clone(), &[at, second]);
            let (d, open_d) = closed(&mut mesh.clone(), &[at, opposite(&second)]);
            prop_assert_eq!((open_c, open_d), (0, 0));
            prop_assert!((c + d - a).abs() < 1e-3, "{} + {}, not {}", c, d, a);
        }
    }

    /// Triangles of any kind are cut without a panic, and what is left has the area that it should have.
    #[test]
    fn parts_of_any_triangles_cover_them(
        corners_of in prop::collection::vec(prop::array::uniform3(prop::array::uniform3(-50i8..50)), 1..60),
        n in prop::array::uniform3(-1.0f64..1.0),
        d in -30.0f64..30.0,
        shared in 0usize..3,
    ) {
        prop_assume!(DVec3::from(n).length() > 0.1);
        let mut mesh = Mesh::default();
        for t in &corners_of {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(t.map(|p| p.map(|c| f32::from(c) / 3.0)));
            mesh.triangles.push([first.saturating_sub(shared as u32), first + 1, first + 2]);
        }
        let at = ClipPlane::new(DVec3::from(n), d).expect("a plane");
        let (mut a, mut b) = (mesh.clone(), mesh.clone());
        clip(&mut a, &[at], true).expect("a part");
        clip(&mut b, &[opposite(&at)], true).expect("the rest");
        let whole = area(&mesh);
        prop_assert!((area(&a) + area(&b) - whole).abs() <= 1e-4 * whole, "{} + {}, not {}", area(&a), area(&b), whole);
    }
}
