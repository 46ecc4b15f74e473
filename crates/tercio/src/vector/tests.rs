//! Drawings against closed forms, and against rays that are cast along lines.

use std::collections::BTreeSet;
use std::io::Read;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::edges::{EdgeKind, Edges, Selection};
use tercio_mesh::{Aabb, ClusteredMesh, Mesh, builtin};
use tercio_raster::view::View;
use tercio_scene::color_map::ColorMap;
use tercio_scene::data::DataSource;
use tercio_scene::{Camera, DataColors, Instance, Projection, Scene, SurfaceData};

use super::*;
use crate::strokes::{Eye, Length, Pen, Segment};

const PEN: Pen = Pen { width: Length::Pixels(1.0), color: [0, 0, 0, 255] };

fn camera(eye: [f64; 3], target: [f64; 3], projection: Projection) -> Camera {
    Camera { eye: eye.into(), target: target.into(), up: DVec3::Y, projection, near: None, shift: [0.0; 2] }
}

const WIDE: Projection = Projection::Perspective { fov_y: 0.8 };

fn seen_by(camera: &Camera, bounds: &Aabb) -> Eye {
    Eye::new(View::new(camera, bounds, 400, 300).expect("a camera"))
}

fn bounds(points: impl IntoIterator<Item = DVec3>) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    points.into_iter().filter(|p| p.is_finite()).for_each(|p| bounds.add(p));
    bounds
}

/// A box of six rectangles, each of two triangles.
fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] } as f32);
    let positions = (0..8).map(corner).collect();
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let face_of_triangle = Some((0..12).map(|t| t / 2).collect());
    Mesh { positions, triangles, face_of_triangle, ..Mesh::default() }
}

fn clustered(mesh: Mesh) -> ClusteredMesh {
    partition(mesh, &PartitionOptions::default())
}

fn triangles_of(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    let at = |v: u32| DVec3::from(mesh.positions[v as usize].map(f64::from));
    mesh.triangles.iter().map(|t| t.map(at)).collect()
}

fn lines_of(page: &Page) -> Vec<Vec<DVec2>> {
    let lines = |shape: &Shape| match shape {
        Shape::Lines { lines, .. } => lines.clone(),
        Shape::Area { .. } | Shape::Text(_) => Vec::new(),
    };
    page.shapes.iter().flat_map(lines).collect()
}

#[test]
fn of_a_cube_nine_edges_are_visible() {
    let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
    let edges = Edges::of_mesh(&mesh, Selection::All);
    let scene = Scene::from_mesh(clustered(mesh));
    for projection in [WIDE, Projection::Orthographic { height: 3.0 }] {
        let eye = seen_by(&camera([4.0, 3.0, 5.0], [0.5; 3], projection), &scene.bounds());
        let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
        let visible = |edge: &tercio_mesh::edges::Edge| {
            hiders.visible(edge.ends.map(|v| eye.eye_space(edges.position(v))))
        };
        let all: Vec<_> = edges.list.iter().map(visible).collect();
        assert_eq!(all.iter().filter(|parts| parts.is_empty()).count(), 3);
        assert_eq!(all.iter().filter(|parts| **parts == [[0.0, 1.0]]).count(), 9);
        // Its silhouette is a hexagon, which is one closed line.
        let mut sketch = Sketch::new(&eye, Some(&hiders));
        sketch.edges(&edges, &DAffine3::IDENTITY, &PEN, true);
        let lines = lines_of(&sketch.page(None));
        assert_eq!((lines.len(), lines[0].len()), (1, 7));
        assert_eq!(lines[0].first(), lines[0].last());
        // Nine edges meet in seven corners, four of them with three: at least two lines.
        let mut sketch = Sketch::new(&eye, Some(&hiders));
        sketch.edges(&edges, &DAffine3::IDENTITY, &PEN, false);
        let lines = lines_of(&sketch.page(None));
        assert_eq!(lines.iter().map(|line| line.len() - 1).sum::<usize>(), 9);
        assert!(lines.len() <= 4, "{lines:?}");
    }
    // Exactly from the front, what is behind is behind the front's own edges, and four edges are points.
    let eye = seen_by(
        &camera([0.5, 0.5, 5.0], [0.5; 3], Projection::Orthographic { height: 3.0 }),
        &scene.bounds(),
    );
    let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
    for only_silhouette in [false, true] {
        let mut sketch = Sketch::new(&eye, Some(&hiders));
        sketch.edges(&edges, &DAffine3::IDENTITY, &PEN, only_silhouette);
        let lines = lines_of(&sketch.page(None));
        assert_eq!((lines.len(), lines[0].len()), (1, 5), "{lines:?}");
    }
}

#[test]
fn lines_are_cut_where_closed_forms_say() {
    let triangles = triangles_of(&cuboid(-DVec3::ONE, DVec3::ONE));
    let all = bounds([DVec3::splat(-9.0), DVec3::splat(9.0)]);
    let in_front = camera([0.0, 0.0, 10.0], [0.0; 3], WIDE);
    let near = |found: Vec<[f64; 2]>, expected: &[[f64; 2]]| {
        assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() <= 1e-12, "{found:?} {expected:?}");
        }
    };
    let eye = seen_by(&in_front, &all);
    let hiders = Hiders::of_triangles(&eye, &triangles, 1e-7, 8.0);
    let visible = |a: [f64; 3], b: [f64; 3]| hiders.visible([a, b].map(|p| eye.eye_space(p.into())));
    // Behind the box: its front is 9 away and reaches to 1, the line is 15 away.
    let reach = 15.0 / 9.0;
    near(
        visible([-4.0, 0.3, -5.0], [4.0, 0.3, -5.0]),
        &[[0.0, (4.0 - reach) / 8.0], [(4.0 + reach) / 8.0, 1.0]],
    );
    // Sloping away: (x, z) = (-4 + 8 t, -5 - t); hidden while |x| <= (15 + t) / 9.
    let cuts = [(4.0 * 9.0 - 15.0) / (8.0 * 9.0 + 1.0), (4.0 * 9.0 + 15.0) / (8.0 * 9.0 - 1.0)];
    near(visible([-4.0, 0.3, -5.0], [4.0, 0.3, -6.0]), &[[0.0, cuts[0]], [cuts[1], 1.0]]);
    // Into the front of the box at z = 1, and hidden from there on.
    near(visible([-2.0, 0.1, 4.0], [1.0, 0.2, -3.0]), &[[0.0, 3.0 / 7.0]]);
    // On the front, along its edge, before it, and beside it.
    near(visible([-0.5, 0.3, 1.0], [0.5, -0.2, 1.0]), &[[0.0, 1.0]]);
    near(visible([-1.0, 1.0, 1.0], [1.0, 1.0, 1.0]), &[[0.0, 1.0]]);
    near(visible([-4.0, 0.3, 2.0], [4.0, 0.3, 2.0]), &[[0.0, 1.0]]);
    near(visible([-4.0, 3.0, -5.0], [4.0, 3.0, -5.0]), &[[0.0, 1.0]]);
    near(visible([-0.5, 0.3, -3.0], [0.5, 0.3, -3.0]), &[]);
    // Points.
    near(visible([0.5, 0.3, -3.0], [0.5, 0.3, -3.0]), &[]);
    near(visible([0.5, 0.3, 1.0], [0.5, 0.3, 1.0]), &[[0.0, 1.0]]);
    // An orthographic camera: what is behind is hidden up to 1.
    let flat = camera([0.0, 0.0, 10.0], [0.0; 3], Projection::Orthographic { height: 12.0 });
    let eye = seen_by(&flat, &all);
    let hiders = Hiders::of_triangles(&eye, &triangles, 1e-7, 8.0);
    let visible = |a: [f64; 3], b: [f64; 3]| hiders.visible([a, b].map(|p| eye.eye_space(p.into())));
    near(visible([-4.0, 0.3, -5.0], [4.0, 0.3, -7.0]), &[[0.0, 3.0 / 8.0], [5.0 / 8.0, 1.0]]);
    near(visible([-2.0, 0.1, 4.0], [1.0, 0.2, -3.0]), &[[0.0, 3.0 / 7.0]]);
    // The near plane cuts off the box's front: what is in the box is seen.
    let cut = Camera { near: Some(10.5), ..in_front };
    let eye = seen_by(&cut, &all);
    let hiders = Hiders::of_triangles(&eye, &triangles, 1e-7, 8.0);
    let visible = |a: [f64; 3], b: [f64; 3]| hiders.visible([a, b].map(|p| eye.eye_space(p.into())));
    near(visible([-0.3, 0.3, -0.8], [0.3, 0.3, -0.9]), &[[0.0, 1.0]]);
    near(visible([-0.3, 0.3, -3.0], [0.3, 0.3, -3.0]), &[]);
}

struct Random(u64);

impl Random {
    /// A number from -1 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    }

    fn point(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * size
    }
}

/// How far a ray is from a point when it meets a triangle, in lengths of its direction (Moller and Trumbore).
fn hit(from: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let det = ab.dot(p);
    let s = from - a;
    let u = s.dot(p) / det;
    let q = s.cross(ab);
    let v = direction.dot(q) / det;
    let t = ac.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(t)
}

/// Random scenes: what is visible at thousands of places on each segment, by rays from there to the viewer.
#[test]
fn what_is_visible_is_what_rays_see() {
    let mut random = Random(7);
    let (mut tested, mut cuts) = (0, 0);
    for round in 0..24 {
        let size = [0.3, 1.0, 3.0][round % 3];
        let triangles: Vec<[DVec3; 3]> = (0..30)
            .map(|_| {
                let middle = random.point(2.0);
                [(); 3].map(|()| middle + random.point(size))
            })
            .collect();
        let at = if round % 4 == 3 { random.point(1.0) } else { random.point(1.0).normalize() * 7.0 };
        let projection =
            if round % 2 == 0 { WIDE } else { Projection::Orthographic { height: 4.0 + random.next() } };
        let eye = seen_by(
            &camera(at.into(), random.point(0.5).into(), projection),
            &bounds(triangles.iter().flatten().copied()),
        );
        let hiders = Hiders::of_triangles(&eye, &triangles, 1e-9, 8.0);
        for _ in 0..40 {
            let ends = [random.point(3.0), random.point(3.0)].map(|p| eye.eye_space(p));
            let Some(ends) = eye.clip(ends, 8.0) else { continue };
            let parts = hiders.visible(ends);
            assert!(
                parts.is_sorted_by(|a, b| a[1] < b[0])
                    && parts.iter().all(|[a, b]| 0.0 <= *a && a < b && *b <= 1.0)
            );
            cuts += parts.len();
            let shown: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(|p| eye.eye_space(p))).collect();
            for k in 0..2000 {
                let t = (f64::from(k) + 0.5) / 2000.0;
                let near_cut = |cut: &f64| (t - cut).abs() < 1e-6;
                if parts.iter().flatten().any(near_cut) {
                    continue;
                }
                let p = ends[0].lerp(ends[1], t);
                let towards = if eye.is_perspective() { -p } else { DVec3::NEG_Z };
                // Less far than the near plane there is nothing.
                let most = if eye.is_perspective() { 1.0 - eye.near() / p.z } else { p.z - eye.near() };
                let is_hidden = shown
                    .iter()
                    .any(|&triangle| hit(p, towards, triangle).is_some_and(|d| d > 1e-9 && d < most));
                let is_visible = parts.iter().any(|[a, b]| (*a..*b).contains(&t));
                assert_eq!(is_visible, !is_hidden, "round {round}, {ends:?} at {t}: {parts:?}");
                tested += 1;
            }
        }
    }
    assert!(tested > 500_000 && cuts > 500, "{tested} {cuts}");
}

/// A scene that is turned, enlarged and moved together with its camera has the same drawing.
#[test]
fn drawings_turn_with_the_scene() {
    let mut random = Random(11);
    let triangles: Vec<[DVec3; 3]> = (0..40)
        .map(|_| {
            let middle = random.point(2.0);
            [(); 3].map(|()| middle + random.point(1.0))
        })
        .collect();
    let draw = |place: DAffine3, scale: f64, projection: Projection| {
        let at = |p: DVec3| place.transform_point3(p);
        let placed: Vec<[DVec3; 3]> = triangles.iter().map(|t| t.map(at)).collect();
        let camera = Camera {
            eye: at(DVec3::new(2.0, 3.0, 7.0)),
            target: at(DVec3::ZERO),
            up: place.transform_vector3(DVec3::Y),
            projection,
            near: None,
            shift: [0.0; 2],
        };
        let eye = seen_by(&camera, &bounds(placed.iter().flatten().copied()));
        let hiders = Hiders::of_triangles(&eye, &placed, 1e-8 * scale, 8.0);
        let mut sketch = Sketch::new(&eye, Some(&hiders));
        let side = |t: &[DVec3; 3], k: usize| Segment {
            ends: [t[k], t[(k + 1) % 3]],
            width: Length::Pixels(1.0),
            color: [0, 0, 0, 255],
        };
        let sides: Vec<Segment> = placed.iter().flat_map(|t| [0, 1, 2].map(|k| side(t, k))).collect();
        sketch.segments(&sides);
        sketch.page(None)
    };
    for flat in [false, true] {
        let projection = |scale: f64| {
            if flat { Projection::Orthographic { height: 7.0 * scale } } else { WIDE }
        };
        let plain = draw(DAffine3::IDENTITY, 1.0, projection(1.0));
        assert!(plain.line_count() > 60);
        for (scale, shift) in [(1.0, 0.0), (1e-6, 1e-4), (4e7, 1e9)] {
            let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0)) * scale;
            let place = DAffine3 { matrix3: turn, translation: DVec3::new(1.0, -2.0, 0.5) * shift };
            let turned = draw(place, scale, projection(scale));
            let (a, b) = (lines_of(&plain), lines_of(&turned));
            assert_eq!(
                a.iter().map(Vec::len).collect::<Vec<_>>(),
                b.iter().map(Vec::len).collect::<Vec<_>>()
            );
            let far = a.iter().flatten().zip(b.iter().flatten()).map(|(p, q)| p.distance(*q));
            assert!(far.fold(0.0, f64::max) < 1e-7, "{scale}");
        }
    }
}

/// Whatever the numbers, there is a drawing with finite ones.
#[test]
fn broken_scenes_are_drawn() {
    let mut random = Random(3);
    let odd = [0.0, -0.0, f64::NAN, f64::INFINITY, 1e300, 1e-300, 7.0, -7.0, 1.0];
    for round in 0..200 {
        let coordinate = |random: &mut Random| {
            let r = random.next();
            if r < -0.5 { odd[((r + 1.0) * 18.0) as usize % odd.len()] } else { r * 3.0 }
        };
        let point = |random: &mut Random| DVec3::from_array([(); 3].map(|()| coordinate(random)));
        let mut triangles: Vec<[DVec3; 3]> = (0..30).map(|_| [(); 3].map(|()| point(&mut random))).collect();
        // Without area, and through the eye.
        triangles.extend([[DVec3::X; 3], [DVec3::ZERO, DVec3::X, DVec3::X * 2.0]]);
        triangles.push([DVec3::new(0.0, 0.0, 7.0), DVec3::X, DVec3::Y]);
        let projection = if round % 2 == 0 { WIDE } else { Projection::Orthographic { height: 4.0 } };
        let eye = seen_by(
            &camera([0.0, 0.0, 7.0], [0.0; 3], projection),
            &bounds([DVec3::splat(-3.0), DVec3::splat(3.0)]),
        );
        let hiders = Hiders::of_triangles(&eye, &triangles, 1e-9, 8.0);
        let mut sketch = Sketch::new(&eye, Some(&hiders));
        for width in [Length::Pixels(2.0), Length::Units(0.1)] {
            let segments: Vec<Segment> = (0..60)
                .map(|_| Segment {
                    ends: [point(&mut random), point(&mut random)],
                    width,
                    color: [0, 0, 0, 255],
                })
                .collect();
            sketch.segments(&segments);
        }
        let page = sketch.page(None);
        assert!(page.line_count() > 0);
        for line in lines_of(&page) {
            assert!(line.iter().all(|p| p.is_finite()));
        }
    }
}

/// All edges of a model, by several numbers of threads.
#[test]
fn files_are_the_same_for_all_threads() {
    let mesh = clustered(builtin::make("builtin:teapot@3k").expect("a model"));
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let scene = Scene::from_mesh(mesh.clone());
            let eye = seen_by(&camera([4.0, 5.0, 9.0], [0.0; 3], WIDE), &scene.bounds());
            let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
            let mut sketch = Sketch::new(&eye, Some(&hiders));
            let edges = Edges::of_clusters(&scene.instances[0].mesh, Selection::All);
            sketch.edges(&edges, &DAffine3::IDENTITY, &PEN, false);
            let page = sketch.page(Some([255; 4]));
            VectorFormat::ALL.map(|format| page.to_bytes(format))
        })
    };
    let one = draw(1);
    assert!(one[0].len() > 20_000);
    for threads in [2, 5] {
        assert!(draw(threads) == one, "{threads} threads");
    }
}

/// A sphere's silhouette is a circle, and so are contours, of which the front half is seen.
#[test]
fn lines_on_a_sphere_are_circles() {
    let mesh = clustered(builtin::make("builtin:sphere@8k").expect("a model"));
    let edges = Edges::of_clusters(&mesh, Selection::Silhouette);
    assert_eq!(edges.count(EdgeKind::Boundary), 0);
    let mut scene = Scene::from_mesh(mesh);
    let box_ = scene.bounds();
    let radius = 0.5 * (box_.max.y - box_.min.y);
    let middle = box_.center();
    let at = middle + DVec3::Z * 10.0 * radius;
    let flat = Projection::Orthographic { height: 3.0 * radius };
    let eye = seen_by(&Camera { up: DVec3::Y, ..camera(at.into(), middle.into(), flat) }, &box_);
    // 300 pixels are 3 radii.
    let (r, center) = (100.0, DVec2::new(200.0, 150.0));
    let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
    let mut sketch = Sketch::new(&eye, Some(&hiders));
    sketch.edges(&edges, &DAffine3::IDENTITY, &PEN, true);
    let lines = lines_of(&sketch.page(None));
    let length: f64 = lines.iter().flat_map(|l| l.windows(2)).map(|pair| pair[0].distance(pair[1])).sum();
    for p in lines.iter().flatten() {
        assert!((p.distance(center) / r - 1.0).abs() < 0.004, "{p}");
    }
    assert!((length / (std::f64::consts::TAU * r) - 1.0).abs() < 0.03, "{length}");

    let colors = DataColors::new("y", ColorMap::named("viridis").expect("a map"), [-1.0, 1.0]);
    let source = DataSource::Along(DVec3::Y);
    scene.instances[0].data = Some(Arc::new(SurfaceData::Mapped { source, colors: Arc::new(colors) }));
    let values = [-0.5, 0.1, 0.7].map(|share| middle.y + share * radius);
    let colors = [[1, 0, 0, 255], [2, 0, 0, 255], [3, 0, 0, 255]];
    let mut sketch = Sketch::new(&eye, Some(&hiders));
    let levels: Vec<_> = values.into_iter().zip(colors).collect();
    sketch.contours(&scene.instances[0], &levels, Length::Pixels(1.0));
    let page = sketch.page(None);
    for (level, color) in levels {
        let of_color = page.shapes.iter().filter_map(|shape| match shape {
            Shape::Lines { style, lines } if style.color == color => Some(lines),
            _ => None,
        });
        let points: Vec<DVec2> = of_color.flatten().flatten().copied().collect();
        let height = (level - middle.y) / radius;
        let y = center.y - height * r;
        assert!(points.iter().all(|p| (p.y - y).abs() < 1e-4), "{level}");
        let half = r * (1.0 - height * height).sqrt();
        let (left, right) = points.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.x), b.max(p.x)));
        assert!(
            (left - (center.x - half)).abs() < 0.7 && (right - (center.x + half)).abs() < 0.7,
            "{left} {right}"
        );
        // What is behind is not seen: the line goes from side to side once.
        let length: f64 = lines_of(&page)
            .iter()
            .filter(|line| (line[0].y - y).abs() < 1e-4)
            .flat_map(|line| line.windows(2).map(|pair| pair[0].distance(pair[1])).collect::<Vec<_>>())
            .sum();
        assert!((length / (right - left) - 1.0).abs() < 0.01, "{length} {left} {right}");
    }
}

/// A contour of a linear function on a plane is one straight line, however the plane is divided.
#[test]
fn a_contour_on_a_plane_is_one_line() {
    let n = 12usize;
    let positions = (0..=n * (n + 2)).map(|i| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0]);
    let positions: Vec<[f32; 3]> = positions.collect();
    let square = |x: usize, y: usize| {
        let v = |dx: usize, dy: usize| ((y + dy) * (n + 1) + x + dx) as u32;
        if (x + y).is_multiple_of(2) {
            [[v(0, 0), v(1, 0), v(1, 1)], [v(0, 0), v(1, 1), v(0, 1)]]
        } else {
            [[v(0, 0), v(1, 0), v(0, 1)], [v(1, 0), v(1, 1), v(0, 1)]]
        }
    };
    let triangles = (0..n * n).flat_map(|i| square(i % n, i / n)).collect();
    let mut scene = Scene::from_mesh(clustered(Mesh { positions, triangles, ..Mesh::default() }));
    let direction = DVec3::new(0.6, 0.8, 0.0);
    let colors = Arc::new(DataColors::new("x", ColorMap::named("viridis").expect("a map"), [0.0, 1.0]));
    let source = DataSource::Along(direction);
    scene.instances[0].data = Some(Arc::new(SurfaceData::Mapped { source, colors }));
    let camera = camera([6.0, 6.0, 20.0], [6.0, 6.0, 0.0], Projection::Orthographic { height: 15.0 });
    let eye = seen_by(&camera, &scene.bounds());
    let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
    let mut sketch = Sketch::new(&eye, Some(&hiders));
    // 0.6 x + 0.8 y = 9.7 enters at y = 12 and leaves at x = 12.
    sketch.contours(&scene.instances[0], &[(9.7, [0, 0, 0, 255])], Length::Pixels(1.0));
    let lines = lines_of(&sketch.page(None));
    assert_eq!(lines.len(), 1);
    let expected = [[0.1 / 0.6, 12.0], [12.0, 2.5 / 0.8]].map(|[x, y]| {
        let pixels = 300.0 / 15.0;
        DVec2::new(200.0 + (x - 6.0) * pixels, 150.0 - (y - 6.0) * pixels)
    });
    for corner in expected {
        // Data are `f32`.
        assert!(lines[0].iter().any(|p| p.distance(corner) < 1e-4), "{lines:?} {expected:?}");
    }
    for p in &lines[0] {
        let along = (expected[1] - expected[0]).normalize();
        assert!((*p - expected[0]).perp_dot(along).abs() < 1e-4);
    }
}

/// Both files have the same lines.
#[test]
fn svg_and_pdf_say_the_same() {
    let black = Style { color: [0, 0, 0, 255], width: 1.5, cap: Cap::Round };
    let at = |x: f64, y: f64| DVec2::new(x, y);
    let page = Page {
        size: [200.0, 100.0],
        background: Some([255, 255, 255, 128]),
        shapes: vec![
            Shape::Lines {
                style: black,
                lines: vec![vec![at(10.0, 20.0), at(30.25, 40.00005), at(-5.0, 0.0)], vec![at(7.0, 8.0)]],
            },
            Shape::Area {
                color: [255, 0, 0, 255],
                polygons: vec![vec![at(0.0, 0.0), at(4.0, 0.0), at(4.0, 3.0)]],
            },
        ],
    };
    let svg = String::from_utf8(page.to_bytes(VectorFormat::Svg)).expect("text");
    for part in [
        "width=\"200\" height=\"100\" viewBox=\"0 0 200 100\"",
        "fill=\"#ffffff\" fill-opacity=\"0.502\"",
        "d=\"M10 20l20.25 20.0001 -35.25 -40.0001M7 8h0\"",
        "fill=\"#ff0000\" d=\"M0 0l4 0 0 3z\"",
    ] {
        assert!(svg.contains(part), "{part}: {svg}");
    }
    assert!(svg.ends_with("</svg>\n"));
    let pdf = page.to_bytes(VectorFormat::Pdf);
    assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
    let find = |what: &[u8]| pdf.windows(what.len()).position(|part| part == what);
    assert!(find(b"/MediaBox [0 0 150 75]").is_some());
    let begin = find(b"stream\n").or_else(|| find(b"stream\r\n")).expect("a stream");
    let begin = begin + if pdf[begin + 6] == b'\r' { 8 } else { 7 };
    let mut content = String::new();
    flate2::read::ZlibDecoder::new(&pdf[begin..]).read_to_string(&mut content).expect("text");
    let words: BTreeSet<&str> = content.lines().collect();
    for line in [
        "0.75 0 0 -0.75 0 75 cm",
        "10 20 m",
        "30.25 40.0001 l",
        "-5 0 l",
        "7 8 m",
        "7 8 l",
        "1.5 w",
        "1 0 0 rg",
    ] {
        assert!(words.contains(line), "{line}: {content}");
    }
}

/// Widths in units of the model become those on the page, nearer ones wider.
#[test]
fn widths_in_units_grow_towards_the_viewer() {
    let all = bounds([DVec3::splat(-9.0), DVec3::splat(9.0)]);
    let eye = seen_by(&camera([0.0, 0.0, 10.0], [0.0; 3], WIDE), &all);
    let mut sketch = Sketch::new(&eye, None);
    let ends = [DVec3::new(-1.0, 0.0, 5.0), DVec3::new(1.0, 0.5, -5.0)];
    sketch.segments(&[Segment { ends, width: Length::Units(0.1), color: [0; 4] }]);
    let page = sketch.page(None);
    let widths: Vec<f64> = page
        .shapes
        .iter()
        .filter_map(|shape| if let Shape::Lines { style, .. } = shape { Some(style.width) } else { None })
        .collect();
    assert!(widths.len() > 10 && widths.is_sorted_by(|a, b| a > b), "{widths:?}");
    let scale = 150.0 / 0.4f64.tan();
    assert!((widths[0] / (0.1 * scale / 5.0) - 1.0).abs() < 0.06);
    assert!((widths[widths.len() - 1] / (0.1 * scale / 15.0) - 1.0).abs() < 0.06);
}

/// A mirrored instance, and one in other units, are where their transforms put them.
#[test]
fn instances_hide_where_they_are() {
    let mesh = clustered(cuboid(-DVec3::ONE, DVec3::ONE));
    let mut instance = Instance::new(mesh);
    instance.world_from_object = DAffine3 {
        matrix3: DMat3::from_diagonal(DVec3::new(-2.0, 1.0, 1.0)),
        translation: DVec3::new(1.0, 0.0, 0.0),
    };
    let scene = Scene { instances: vec![instance], ..Scene::default() };
    let flat = camera([0.0, 0.0, 10.0], [0.0; 3], Projection::Orthographic { height: 12.0 });
    let eye = seen_by(&flat, &scene.bounds());
    let hiders = Hiders::of_scene(&eye, &scene, Sketch::MARGIN);
    let found = hiders.visible([[-4.0, 0.0, -3.0], [4.0, 0.0, -3.0]].map(|p| eye.eye_space(p.into())));
    assert_eq!(found.len(), 2);
    for (a, b) in found.iter().flatten().zip([0.0, 3.0 / 8.0, 7.0 / 8.0, 1.0]) {
        assert!((a - b).abs() < 1e-12, "{found:?}");
    }
}
