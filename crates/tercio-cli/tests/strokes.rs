//! Lines, edges and points against computations in `f64` that share no code with them, and under the picture law.

mod common;

use std::fmt::Write as _;
use std::fs;

use common::{Place, Random};
use tercio::glam::{DVec2, DVec3};
use tercio_testkit::ray_caster::RayCaster;

const WIDTH: usize = 160;
const HEIGHT: usize = 120;

/// A picture of three bytes a pixel.
struct Picture(Vec<u8>);

impl Picture {
    fn render(place: &Place, arguments: &str) -> Self {
        let command = format!("render {arguments} --size {WIDTH}x{HEIGHT} -o a.ppm -q");
        let outcome = place.run(&command);
        assert_eq!(outcome.code, Some(0), "{command}: {}", outcome.stderr);
        let bytes = place.read("a.ppm");
        Self(bytes[bytes.len() - 3 * WIDTH * HEIGHT..].to_vec())
    }

    fn at(&self, x: usize, y: usize) -> [u8; 3] {
        let at = 3 * (y * WIDTH + x);
        [self.0[at], self.0[at + 1], self.0[at + 2]]
    }
}

/// The camera of the options, written a second time.
#[derive(Clone, Copy)]
struct Eye {
    eye: DVec3,
    axes: [DVec3; 3],
    orthographic: Option<f64>,
}

impl Eye {
    const FOV: f64 = 30.0;

    fn new(eye: DVec3, target: DVec3) -> Self {
        let forward = (target - eye).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        Self { eye, axes: [right, right.cross(forward), forward], orthographic: None }
    }

    fn options(&self) -> String {
        let (e, t) = (self.eye, self.eye + self.axes[2] * 4.0);
        let more = if self.orthographic.is_some() { " --orthographic" } else { "" };
        format!("--eye {},{},{} --target {},{},{}{more}", e.x, e.y, e.z, t.x, t.y, t.z)
    }

    fn screen(&self, p: DVec3) -> DVec2 {
        let [right, up, forward] = self.axes.map(|axis| axis.dot(p - self.eye));
        let tangent = (0.5 * Self::FOV).to_radians().tan();
        let scale = match self.orthographic {
            None => 0.5 * HEIGHT as f64 / tangent / forward,
            Some(height) => HEIGHT as f64 / height,
        };
        DVec2::new(0.5 * WIDTH as f64 + right * scale, 0.5 * HEIGHT as f64 - up * scale)
    }
}

fn distance(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let along = b - a;
    let t = if along == DVec2::ZERO {
        0.0
    } else {
        ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0)
    };
    p.distance(a + t * along)
}

/// Every pixel is drawn where its middle is nearer than half of the width to a line, or to a point, and only there.
#[test]
fn lines_and_points_cover_what_is_near_them() {
    let place = Place::new();
    let mut random = Random(7);
    let center = DVec3::new(0.3, -0.2, 0.1);
    let views = [(5.0, false), (2.2, false), (4.0, true)];
    for (view, (far, orthographic)) in views.into_iter().enumerate() {
        let mut eye = Eye::new(center + DVec3::new(0.4, 0.5, 1.0).normalize() * far, center);
        // As high as what a camera with the default angle sees at its target.
        eye.orthographic = orthographic.then(|| 8.0 * (0.5 * Eye::FOV).to_radians().tan());
        for width in [1.0, 1.5, 3.0, 17.0] {
            let lines: Vec<[DVec3; 2]> = (0..12).map(|_| [random.point(1.0), random.point(1.0)]).collect();
            let points: Vec<DVec3> = (0..12).map(|_| random.point(1.0)).collect();
            let mut obj = String::new();
            for p in lines.as_flattened().iter().chain(&points) {
                writeln!(obj, "v {} {} {}", p.x, p.y, p.z).unwrap();
            }
            for k in 0..lines.len() {
                writeln!(obj, "l {} {}", 2 * k + 1, 2 * k + 2).unwrap();
            }
            let first = 2 * lines.len() + 1;
            (first..first + points.len()).for_each(|k| writeln!(obj, "p {k}").unwrap());
            fs::write(place.path("lines.obj"), &obj).unwrap();
            let options = format!(
                "lines.obj {} --line-width {width} --point-size {} --aa 1 --background #000 --color #fff",
                eye.options(),
                2.0 * width
            );
            let picture = Picture::render(&place, &options);
            let lines: Vec<[DVec2; 2]> = lines.iter().map(|l| l.map(|p| eye.screen(p))).collect();
            let points: Vec<DVec2> = points.iter().map(|&p| eye.screen(p)).collect();
            let (mut inside, mut outside) = (0, 0);
            for y in 0..HEIGHT {
                for x in 0..WIDTH {
                    let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let line =
                        lines.iter().map(|&l| distance(p, l) - 0.5 * width).fold(f64::INFINITY, f64::min);
                    let point = points.iter().map(|&q| p.distance(q) - width).fold(f64::INFINITY, f64::min);
                    let beyond = line.min(point);
                    let drawn = picture.at(x, y) != [0; 3];
                    // Round ends and discs are polygons with errors of a tenth of a pixel.
                    if beyond < -0.11 {
                        inside += 1;
                        assert!(drawn, "view {view}, width {width}: {x}, {y} is empty, {beyond} inside");
                    } else if beyond > 0.1 {
                        outside += 1;
                        assert!(!drawn, "view {view}, width {width}: {x}, {y} is drawn, {beyond} outside");
                    }
                }
            }
            assert!(inside > 200 && outside > 2000, "{inside} inside, {outside} outside");
        }
    }
}

/// A triangle mesh of a test, with its edges.
struct Model {
    name: &'static str,
    vertices: Vec<DVec3>,
    faces: Vec<Vec<usize>>,
}

impl Model {
    /// A sheet of squares over x and z, with a height.
    fn sheet(name: &'static str, n: usize, place: impl Fn(f64, f64) -> DVec3) -> Self {
        let at = |k: usize| k as f64 / n as f64 * 2.0 - 1.0;
        let vertices =
            (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| place(at(i), at(j))).collect();
        let m = n + 1;
        let square =
            |(i, j): (usize, usize)| vec![j * m + i, (j + 1) * m + i, (j + 1) * m + i + 1, j * m + i + 1];
        let faces = (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).map(square).collect();
        Self { name, vertices, faces }
    }

    /// A box with corners.
    fn plate(name: &'static str, size: DVec3, at: DVec3) -> Self {
        let corner = |k: usize| {
            DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -1.0 } else { 1.0 })) * size + at
        };
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Self {
            name,
            vertices: (0..8).map(corner).collect(),
            faces: faces.iter().map(|f| f.to_vec()).collect(),
        }
    }

    /// A sphere of squares on a cube.
    fn sphere(name: &'static str, n: usize, radius: f64) -> Self {
        let mut all = Self { name, vertices: Vec::new(), faces: Vec::new() };
        for side in 0..6 {
            let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
            let face = Self::sheet(name, n, |u, v| {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, v * sign, u);
                DVec3::from(p) * (radius / (1.0 + (u * u + v * v)).sqrt())
            });
            let first = all.vertices.len();
            all.vertices.extend(face.vertices);
            all.faces.extend(face.faces.iter().map(|f| f.iter().map(|v| v + first).collect()));
        }
        all
    }

    fn obj(&self) -> String {
        let mut text = String::new();
        self.vertices.iter().for_each(|p| writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z).unwrap());
        for face in &self.faces {
            let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
            writeln!(text, "f {}", corners.join(" ")).unwrap();
        }
        text
    }

    fn edges(&self) -> Vec<[DVec3; 2]> {
        let of_face = |f: &Vec<usize>| (0..f.len()).map(|k| [f[k], f[(k + 1) % f.len()]]).collect::<Vec<_>>();
        self.faces.iter().flat_map(of_face).map(|e| e.map(|v| self.vertices[v])).collect()
    }

    /// A prism of so many sides, as polygons.
    fn prism(name: &'static str, sides: usize) -> Self {
        let corner = |k: usize, y: f64| {
            let (z, x) = (k as f64 * std::f64::consts::TAU / sides as f64).sin_cos();
            DVec3::new(x, y, z)
        };
        let vertices =
            (0..sides).map(|k| corner(k, -0.5)).chain((0..sides).map(|k| corner(k, 0.5))).collect();
        let side = |k: usize| vec![k, k + sides, (k + 1) % sides + sides, (k + 1) % sides];
        let ends = [(0..sides).collect(), (sides..2 * sides).rev().collect()];
        Self { name, vertices, faces: (0..sides).map(side).chain(ends).collect() }
    }

    /// The same faces as triangles, all of whose sides are edges.
    fn split(mut self) -> Self {
        let of_face = |f: Vec<usize>| (1..f.len() - 1).map(move |k| vec![f[0], f[k], f[k + 1]]);
        self.faces = self.faces.into_iter().flat_map(of_face).collect();
        self
    }

    fn triangles(&self) -> Vec<[DVec3; 3]> {
        let p = |v: usize| self.vertices[v];
        let of_face =
            |f: &Vec<usize>| (1..f.len() - 1).map(|k| [p(f[0]), p(f[k]), p(f[k + 1])]).collect::<Vec<_>>();
        self.faces.iter().flat_map(of_face).collect()
    }

    fn caster(&self) -> RayCaster {
        RayCaster::new(self.triangles().into_iter().map(|corners| corners.map(|p| p.to_array())).collect())
    }
}

/// Where the ray caster sees an edge, it is drawn; of a line that is shaded with triangles, on these and on the side where it has none.
/// Where it sees none within the width, none shines through.
#[test]
fn edges_are_seen_where_nothing_hides_them() {
    let wave = |x: f64, z: f64| DVec3::new(x, 0.25 * (4.0 * x).sin() * (3.0 * z).cos(), z);
    let flat = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let far = DVec3::new(4e6, 5e6, -3e6);
    let front = DVec3::new(0.5, 0.6, 1.0);
    let cases = [
        (Model::sheet("wave", 12, wave), front, 5.0, DVec3::ZERO),
        (Model::sheet("wave of triangles", 12, wave).split(), front, 5.0, DVec3::ZERO),
        (Model::sheet("flat", 10, flat), front, 5.0, DVec3::ZERO),
        (Model::sheet("grazing", 6, flat), DVec3::new(0.1, 0.05, 1.0), 5.0, DVec3::ZERO),
        (Model::sheet("almost from the side", 6, flat), DVec3::new(0.3, 0.012, 1.0), 5.0, DVec3::ZERO),
        (Model::plate("cube", DVec3::ONE, DVec3::ZERO), front, 7.0, DVec3::ZERO),
        (Model::plate("plate", DVec3::new(1.0, 0.01, 1.0), DVec3::ZERO), front, 5.0, DVec3::ZERO),
        (
            Model::plate("long", DVec3::new(0.5, 0.5, 40.0), DVec3::ZERO),
            DVec3::new(0.1, 0.08, 1.0),
            46.0,
            DVec3::ZERO,
        ),
        (Model::plate("far away", DVec3::ONE, far), front, 7.0, far),
        (Model::sphere("sphere", 8, 1.0), front, 5.0, DVec3::ZERO),
        (Model::sphere("sphere of triangles", 8, 1.0).split(), front, 5.0, DVec3::ZERO),
        (Model::sphere("tiny", 8, 1e-7).split(), front, 5e-7, DVec3::ZERO),
        (Model::sphere("huge", 8, 1e9).split(), front, 5e9, DVec3::ZERO),
        (Model::prism("prism", 48), DVec3::new(0.0, 0.2, 1.0), 7.0, DVec3::ZERO),
    ];
    let place = Place::new();
    for (model, direction, away, target) in cases {
        let eye = Eye::new(target + direction.normalize() * away, target);
        fs::write(place.path("m.obj"), model.obj()).unwrap();
        let options = format!(
            "m.obj {} --edges --edge-color #f00 --line-width 2 --aa 1 --shading unlit --color #00f --background #000",
            eye.options()
        );
        let picture = Picture::render(&place, &options);
        // Beside the surface, a line covers a pixel or not; on it, by half a pixel less its distance, and 1 for half of the width.
        let cover = |x: usize, y: usize| (f64::from(picture.at(x, y)[0]) / 255.0).powf(2.2);
        let caster = model.caster();
        let triangles = model.triangles();
        let corners = |face: &[usize]| face.iter().map(|&v| model.vertices[v]).collect::<Vec<_>>();
        let face_of: Vec<&[usize]> =
            model.faces.iter().flat_map(|face| vec![&face[..]; face.len() - 2]).collect();
        // A triangle draws the lines of the others of its polygon, too, where they reach over a diagonal.
        let is_of_face = |triangle: usize, ends: [DVec3; 2]| {
            let corners = corners(face_of[triangle]);
            ends.iter().all(|end| corners.contains(end))
        };
        let first = |direction: DVec3| caster.first_hit(eye.eye.to_array(), direction.to_array(), 0.0);
        // Distance of what a ray hits first, in lengths of the direction.
        let hit = |direction: DVec3| first(direction).map_or(f64::INFINITY, |hit| hit.distance);
        let pixel = |x: usize, y: usize| {
            let tangent = (0.5 * Eye::FOV).to_radians().tan() * 2.0 / HEIGHT as f64;
            let [right, up, forward] = eye.axes;
            let (x, y) = (x as f64 + 0.5 - 0.5 * WIDTH as f64, y as f64 + 0.5 - 0.5 * HEIGHT as f64);
            forward + right * (x * tangent) - up * (y * tangent)
        };
        let size = 2.0 * (0.5 * Eye::FOV).to_radians().tan() / HEIGHT as f64;
        let mut near = vec![false; WIDTH * HEIGHT];
        let (mut seen, mut missing) = (0, 0);
        for [a, b] in model.edges() {
            let has_edge = |corners: &[DVec3; 3]| corners.contains(&a) && corners.contains(&b);
            // On which side of the plane through the viewer and the edge directions are, and its triangles.
            let side = |direction: DVec3| (a - eye.eye).cross(b - eye.eye).dot(direction).signum();
            let apex = |t: &[DVec3; 3]| t.iter().find(|&&p| p != a && p != b).map(|&p| side(p - eye.eye));
            let sides: Vec<f64> = triangles.iter().filter(|t| has_edge(t)).filter_map(apex).collect();
            let steps = (eye.screen(a).distance(eye.screen(b)) * 4.0).ceil().max(2.0) as usize;
            for step in 0..=steps {
                let p = a.lerp(b, step as f64 / steps as f64);
                let s = eye.screen(p);
                // The point itself, or the surface a hundredth of a pixel beside it.
                let is_seen = [(0.0, 0.0), (0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)].iter().any(
                    |&(x, y)| {
                        let direction = p
                            + (eye.axes[0] * x + eye.axes[1] * y) * size * (p - eye.eye).dot(eye.axes[2])
                            - eye.eye;
                        hit(direction) >= 1.0 - 1e-6
                    },
                );
                if !is_seen {
                    continue;
                }
                let (x, y) = (s.x.floor() as isize, s.y.floor() as isize);
                for (x, y) in (-2..=2).flat_map(|i| (-2..=2).map(move |j| (x + i, y + j))) {
                    if (0..WIDTH as isize).contains(&x) && (0..HEIGHT as isize).contains(&y) {
                        let beyond = DVec2::new(x as f64 + 0.5, y as f64 + 0.5).distance(s) - 1.0;
                        near[y as usize * WIDTH + x as usize] |= beyond < 0.15;
                    }
                }
                if s.x < 0.0 || s.y < 0.0 || s.x >= WIDTH as f64 || s.y >= HEIGHT as f64 {
                    continue;
                }
                let (x, y) = (x as usize, y as usize);
                // What is nearer at the middle of the pixel by more than two pixels, hides it there.
                let depth = (p - eye.eye).dot(eye.axes[2]);
                let is_free = hit(pixel(x, y)) > depth * (1.0 - 2.0 * size);
                // A line on triangles is not seen beyond them.
                let is_beside = !sides.contains(&side(pixel(x, y)));
                let is_own = || first(pixel(x, y)).is_some_and(|hit| is_of_face(hit.triangle, [a, b]));
                if is_free
                    && (is_beside || is_own())
                    && DVec2::new(x as f64 + 0.5, y as f64 + 0.5).distance(s) < 0.75
                {
                    seen += 1;
                    missing += usize::from(cover(x, y) < 0.72);
                }
            }
        }
        let places = (0..WIDTH * HEIGHT).map(|k| (k % WIDTH, k / WIDTH));
        let through: Vec<_> = places.filter(|&(x, y)| cover(x, y) > 0.5 && !near[y * WIDTH + x]).collect();
        assert!(seen > 100, "{}: {seen} seen", model.name);
        // Where a quadrilateral is folded, its front half hides half of a line behind the fold: on one crest of the wave.
        let most = if model.name == "wave" { seen / 100 } else { 0 };
        assert!(missing <= most, "{}: {missing} of {seen} are not drawn", model.name);
        assert!(through.is_empty(), "{}: {through:?} shine through", model.name);
    }
}

/// The same bytes from every number of threads and ranks, tile size and order of work, with samples and translucent lines.
#[test]
fn strokes_obey_the_picture_law() {
    let place = Place::new();
    let looks = [
        "builtin:teapot@2k --edges=feature --edge-color #20408080 --line-width 3 --aa 4",
        "builtin:sphere@500 --mode hidden-line --aa 1",
        "builtin:gyroid@1k --mode points --point-shape sphere --aa 4",
        "builtin:teapot@1k --mode wireframe --edges=silhouette --stereo anaglyph",
        "builtin:teapot@2k --edges --aa 4",
        "builtin:sphere@1k --edges --line-width 2.5 --color-by @elevation --aa 1",
        "builtin:teapot@1k --mode wireframe --color-by @elevation --aa 4",
        "builtin:teapot@1k --mode edges --edges=feature,silhouette --color-by @face --aa 1",
        "builtin:sphere@300 --mode wireframe --line-shape tube --color-by @normal:y --opacity-map 0.4,1 --aa 4",
        "bent.obj --edges --line-width 2 --aa 4",
        "flat.obj --mode hidden-line --aa 4",
    ];
    fs::write(place.path("bent.obj"), Model::sphere("sphere", 8, 1.0).obj()).unwrap();
    fs::write(place.path("flat.obj"), Model::prism("prism", 12).obj()).unwrap();
    let ways = [
        "--threads 1 --tile-size 8",
        "--threads 3 --sorting triangles --simd scalar",
        "--no-cluster-culling --binning bbox --tile-size 128",
        "--ranks 3 --organisation sort-last",
        "--ranks 4 --organisation sort-twice",
        "--ranks 2 --organisation sort-middle",
        "--ranks 2 --organisation sort-first",
    ];
    for look in looks {
        let expected = Picture::render(&place, look);
        assert!(expected.0.iter().any(|&c| c < 100), "{look}: nothing dark");
        for way in ways {
            assert!(Picture::render(&place, &format!("{look} {way}")).0 == expected.0, "{look} {way}");
        }
    }
}

/// The edges of cells, of which a hexahedron has several polygons and a quad one, and no diagonal of either: from every number of
/// ranks and from the prepared model as from one process. Parts of a model have none, and that is said.
#[test]
fn edges_of_mixed_cells_are_those_of_their_polygons() {
    let place = Place::new();
    let points: [[f64; 3]; 10] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
    ];
    let mut vtk =
        "# vtk DataFile Version 3.0\ncells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 10 float\n".to_owned();
    points.iter().for_each(|p| writeln!(vtk, "{} {} {}", p[0], p[1], p[2]).unwrap());
    vtk += "CELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 1 8 9 2\nCELL_TYPES 2\n12\n9\n";
    fs::write(place.path("mixed.vtk"), vtk).unwrap();
    place.run("prepare mixed.vtk -o mixed.tercio").ok_silently();

    let eye = Eye::new(DVec3::new(3.1, 2.3, 4.4), DVec3::new(1.0, 0.5, 0.4));
    let look = format!("{} --aa 1 --line-width 2 --background #fff --edge-color #000", eye.options());
    let sides =
        [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
    let sides = sides.into_iter().chain([[1, 8], [8, 9], [9, 2]]);
    let lines: Vec<_> = sides.map(|side| side.map(|k| eye.screen(DVec3::from(points[k])))).collect();
    let picture = Picture::render(&place, &format!("mixed.vtk --mode wireframe {look}"));
    let is_drawn = |x: usize, y: usize| picture.at(x, y)[0] < 128;
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let nearest = lines.iter().map(|&line| distance(middle, line)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1.1 || !is_drawn(x, y), "{x}, {y}: drawn, {nearest} pixels beside");
            assert!(nearest > 0.9 || is_drawn(x, y), "{x}, {y}: not drawn, {nearest} pixels beside");
        }
    }

    for mode in [
        "--mode edges",
        "--mode wireframe",
        "--mode hidden-line",
        "--edges",
        "--edges=feature,boundary,silhouette",
    ] {
        let expected = Picture::render(&place, &format!("mixed.vtk {mode} {look}"));
        assert!(expected.0.iter().any(|&c| c < 100), "{mode}: nothing dark");
        for way in [
            "mixed.vtk --ranks 2 --organisation sort-first",
            "mixed.vtk --ranks 3 --organisation sort-middle",
            "mixed.vtk --ranks 3 --organisation sort-last",
            "mixed.vtk --ranks 4 --organisation sort-twice",
            "mixed.tercio",
            "mixed.tercio --ranks 2 --organisation sort-last",
        ] {
            assert!(
                Picture::render(&place, &format!("{way} {mode} {look}")).0 == expected.0,
                "{mode}: {way}"
            );
        }
        place
            .run(&format!("render mixed.vtk {mode} -o a.png --parts"))
            .failed(2, &["--mode and --edges are not possible with --parts: the edges of a part are not those of the model"]);
    }
}

#[test]
fn options_without_effect_are_mistakes() {
    let place = Place::new();
    let cases = [
        ("--mode points --edges", "--edges has no effect"),
        ("--edge-color #f00", "--edge-color has no effect"),
        ("--edges --feature-angle 20", "--feature-angle has no effect"),
        ("--line-width 0", "expected pixels"),
        ("--edges=some", "all, feature, boundary, non-manifold, silhouette"),
        ("--mode faces", "surface, wireframe, hidden-line, points, edges"),
    ];
    for (options, reason) in cases {
        place.run(&format!("render model.off -o a.png {options}")).failed(2, &[reason]);
    }
    place
        .run("render model.off -o a.png --mode edges --edges=boundary")
        .failed(1, &["nothing was drawn", "edges"]);
}

/// An edge has the colours of its data: those of a closed formula along it, in tubes and strips; an edge's own colour wins.
#[test]
fn edges_show_data() {
    let place = Place::new();
    // Its left side is vertical, from the lower to the upper border, 40 pixels from the middle.
    fs::write(place.path("t.obj"), "v -1 -1.5 0\nv 1 -1.5 0\nv -1 1.5 0\nf 1 2 3\n").unwrap();
    let view = "t.obj --eye 0,0,5 --target 0,0,0 --fov 33.398488 --aa 1 --background #fff";
    let data = "--color-by @elevation --range -1.5,1.5 --colormap gray --no-bar --line-width 4";
    let flat = Picture::render(&place, &format!("{view} {data} --mode wireframe"));
    for y in 4..HEIGHT - 4 {
        let expected = 255.0 * (1.0 - (y as f64 + 0.5) / HEIGHT as f64);
        let found = flat.at(39, y);
        assert!(
            found.iter().all(|&c| (f64::from(c) - expected).abs() <= 2.0),
            "row {y}: {found:?}, {expected}"
        );
    }
    let edges = Picture::render(&place, &format!("{view} {data} --mode edges"));
    assert!(edges.0 == flat.0, "all of its edges are features");
    let own = Picture::render(&place, &format!("{view} {data} --mode wireframe --edge-color #ff0000"));
    assert_eq!(own.at(39, HEIGHT / 2), [255, 0, 0]);
    // The middle of a lit tube is darker or brighter, and grey.
    let tube = Picture::render(&place, &format!("{view} {data} --mode wireframe --line-shape tube"));
    let levels: Vec<u8> = [100, 60, 20].map(|y| tube.at(39, y)).iter().map(|c| c[0]).collect();
    assert!(levels.is_sorted() && levels[2] > levels[0] + 40, "{levels:?}");
    // Lines of equal value are those of surfaces.
    let isolines = Picture::render(&place, &format!("{view} {data} --mode wireframe --isolines 5"));
    assert!(isolines.0 == flat.0);
    // What cannot show them says so.
    for own in ["--edge-color #f00 -o a.png", "-o a.svg"] {
        let command = format!("render t.obj --mode wireframe --color-by @elevation {own}");
        let outcome = place.run(&command);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert!(outcome.stderr.contains("nothing shows the data of --color-by"), "{}", outcome.stderr);
    }
}

/// Categories of an edge that leaves the picture are those of its ends: nothing is between them.
#[test]
fn categories_of_edges_are_not_interpolated() {
    let place = Place::new();
    // The left side, 40 pixels from the middle, goes far beyond both borders, and is of category 1 below and 3 above its middle.
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property float q\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        -1 -4 0 1\n1 -4 0 1\n-1 4 0 3\n3 0 1 2\n";
    fs::write(place.path("t.ply"), ply).unwrap();
    let view = "t.ply --up-axis y --eye 0,0,5 --target 0,0,0 --fov 33.398488 --aa 1 --background #fff";
    let data = "--color-by q --categories --nan-color #f0f --no-bar --line-width 4";
    for shape in ["", " --line-shape tube --shading unlit"] {
        let picture = Picture::render(&place, &format!("{view} {data} --mode wireframe{shape}"));
        let colors: Vec<[u8; 3]> = [2, 30, 90, HEIGHT - 3].map(|y| picture.at(39, y)).to_vec();
        assert_eq!((colors[0], colors[2]), (colors[1], colors[3]), "{colors:?}");
        assert!(colors[0] != colors[3] && !colors.contains(&[255, 0, 255]), "{colors:?}");
        assert!(!colors.contains(&[255; 3]), "{colors:?}");
    }
}

/// `--opacity` is that of lines and points, too, and of edges that are drawn alone: as if their colours had it.
#[test]
fn opacity_is_that_of_lines_points_and_edges_alone() {
    let place = Place::new();
    for (name, opacity) in [("pale", 0.2), ("full", 1.0)] {
        let text = format!(
            "mtllib {name}.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv 0 0 0\nusemtl m\nl 1 2 3\np 3\nusemtl none\nl 1 4\n"
        );
        fs::write(place.path(&format!("{name}.obj")), text).unwrap();
        let library = format!("newmtl m\nKd 1 0 0\nd {opacity}\n");
        fs::write(place.path(&format!("{name}.mtl")), library).unwrap();
    }
    let look = "--view front --background white --line-width 9 --point-size 20";
    let draw = |what: &str| Picture::render(&place, &format!("{what} {look}")).0;
    let farthest =
        |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().expect("a picture");
    let [pale, full, faded] = ["pale.obj", "full.obj", "full.obj --opacity 0.2"].map(draw);
    // Lines and points with a material are on the right; the line without one has the usual colour, which only --opacity fades.
    let right: Vec<usize> = (0..WIDTH * HEIGHT).filter(|at| at % WIDTH > WIDTH / 2 + 20).collect();
    let of =
        |picture: &[u8]| -> Vec<u8> { right.iter().flat_map(|at| picture[3 * at..][..3].to_vec()).collect() };
    assert!(farthest(&of(&full), &of(&pale)) > 100 && farthest(&of(&faded), &of(&pale)) <= 1);
    let usual = 3 * ((HEIGHT / 2 + 15) * WIDTH + WIDTH / 2 - 15);
    assert!([&pale, &full].iter().all(|picture| picture[usual] < 100) && faded[usual] > 180);
    let model = "builtin:sphere@200 --mode wireframe";
    let [by_color, by_opacity] =
        ["--edge-color #20242833", "--opacity 0.2"].map(|options| draw(&format!("{model} {options}")));
    assert!(farthest(&by_color, &by_opacity) <= 1 && by_color.iter().any(|&level| level < 250));
    place.run("render full.obj --opacity 0.2 --view front -o a.svg -q").ok_silently();
    let drawing = String::from_utf8(place.read("a.svg")).unwrap();
    assert!(drawing.contains("stroke-opacity=\"0.2\""), "{drawing}");
}

/// Vertices drawn as points have the colours of faces and of their materials, if they have none of their own.
#[test]
fn vertices_have_the_colours_of_their_faces() {
    let place = Place::new();
    // A triangle on the left, and one on the right.
    let vertices = [[-3, 0], [-2, 0], [-2, 1], [2, 0], [3, 0], [2, 1]];
    let lines = |before: &str| vertices.map(|[x, y]| format!("{before}{x} {y} 0\n")).concat();
    fs::write(place.path("m.mtl"), "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n").unwrap();
    let obj = format!("mtllib m.mtl\n{}usemtl red\nf 1 2 3\nusemtl blue\nf 4 5 6\n", lines("v "));
    fs::write(place.path("materials.obj"), obj).unwrap();
    // Textures are not drawn on points: they have the usual colour, not that of the material alone.
    let library = "newmtl red\nKd 1 1 1\nmap_Kd red.png\nnewmtl blue\nKd 1 1 1\nmap_Kd blue.png\n";
    fs::write(place.path("t.mtl"), library).unwrap();
    let obj = fs::read_to_string(place.path("materials.obj")).unwrap().replace("m.mtl", "t.mtl");
    fs::write(place.path("textured.obj"), obj).unwrap();
    let header = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\nend_header\n";
    let ply = format!("{header}{}3 0 1 2 255 0 0\n3 3 4 5 0 0 255\n", lines(""));
    fs::write(place.path("faces.ply"), ply).unwrap();
    let look = "--mode points --point-size 12 --view front --up-axis y --background white --aa 1";
    let textured = "textured.obj --no-textures";
    for model in ["materials.obj", "faces.ply", textured] {
        let draw = |options: &str| Picture::render(&place, &format!("{model} {look} {options}"));
        let count = |picture: &Picture, color: [u8; 3], half: usize| {
            let columns = half * WIDTH / 2..(half + 1) * WIDTH / 2;
            (0..HEIGHT)
                .flat_map(|y| columns.clone().map(move |x| (x, y)))
                .filter(|&(x, y)| picture.at(x, y) == color)
                .count()
        };
        let picture = draw("");
        if model == textured {
            assert!(picture.0 == draw("--no-mesh-colors").0 && picture.0.iter().any(|&level| level < 100));
            continue;
        }
        // Three points of 12 x 12 pixels or a little less, each.
        for (color, half) in [([255, 0, 0], 0), ([0, 0, 255], 1)] {
            let found = [count(&picture, color, half), count(&picture, color, 1 - half)];
            assert!(found[0] > 200 && found[1] == 0, "{model}: {color:?} {found:?}");
        }
        let plain = draw("--no-mesh-colors");
        assert_eq!(count(&plain, [255, 0, 0], 0) + count(&plain, [0, 0, 255], 1), 0, "{model}");
    }
}
