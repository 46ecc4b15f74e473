//! Tubes, spheres and glyphs against rays and projections in `f64` that share no code with them; data on points and lines against
//! their colours; all of them under the picture law.

mod common;

use std::fmt::Write as _;
use std::fs;

use common::{Place, Random};
use tercio::glam::{DVec2, DVec3};
use tercio::scene::DataColors;
use tercio::scene::color_map::ColorMap;

const WIDTH: usize = 160;
const HEIGHT: usize = 120;

/// A perspective camera of 30 degrees, written a second time.
struct Eye {
    eye: DVec3,
    axes: [DVec3; 3],
}

impl Eye {
    fn new(eye: DVec3, target: DVec3) -> Self {
        let forward = (target - eye).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        Self { eye, axes: [right, right.cross(forward), forward] }
    }

    fn options(&self) -> String {
        let (e, t) = (self.eye, self.eye + self.axes[2] * 4.0);
        format!("--eye {},{},{} --target {},{},{}", e.x, e.y, e.z, t.x, t.y, t.z)
    }

    /// Pixels per unit at distance 1.
    fn scale() -> f64 {
        0.5 * HEIGHT as f64 / 15f64.to_radians().tan()
    }

    /// The direction through a place of the picture, with length 1 along the axis.
    fn ray(&self, at: DVec2) -> DVec3 {
        let [right, up, forward] = self.axes;
        let [x, y] = [at.x - 0.5 * WIDTH as f64, 0.5 * HEIGHT as f64 - at.y].map(|c| c / Self::scale());
        forward + right * x + up * y
    }

    fn screen(&self, p: DVec3) -> DVec2 {
        let [right, up, forward] = self.axes.map(|axis| axis.dot(p - self.eye));
        let scale = Self::scale() / forward;
        DVec2::new(0.5 * WIDTH as f64 + right * scale, 0.5 * HEIGHT as f64 - up * scale)
    }
}

/// The first meeting of a ray with a sphere.
fn meet_sphere(from: DVec3, ray: DVec3, middle: DVec3, radius: f64) -> Option<f64> {
    let m = from - middle;
    let (a, b, c) = (ray.dot(ray), m.dot(ray), m.dot(m) - radius * radius);
    let root = b * b - a * c;
    (root >= 0.0).then(|| (-b - root.sqrt()) / a)
}

/// The first meeting of a ray with everything that is nearer to a segment than the radius.
fn meet_capsule(from: DVec3, ray: DVec3, [p, q]: [DVec3; 2], radius: f64) -> Option<f64> {
    let axis = q - p;
    let across = |v: DVec3| v - axis * (v.dot(axis) / axis.dot(axis));
    let (m, d) = (across(from - p), across(ray));
    let (a, b, c) = (d.dot(d), m.dot(d), m.dot(m) - radius * radius);
    let root = b * b - a * c;
    let side = (root >= 0.0).then(|| (-b - root.sqrt()) / a).filter(|t| {
        let along = (from + ray * *t - p).dot(axis);
        (0.0..=axis.dot(axis)).contains(&along)
    });
    let ends = [p, q].map(|end| meet_sphere(from, ray, end, radius));
    [side, ends[0], ends[1]].into_iter().flatten().min_by(f64::total_cmp)
}

/// Depths of a NumPy file.
fn depths(place: &Place) -> Vec<f32> {
    let bytes = place.read("d.npy");
    let data = &bytes[bytes.len() - 4 * WIDTH * HEIGHT..];
    data.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn tubes_and_spheres_are_where_rays_meet_them() {
    let place = Place::new();
    let mut random = Random(3);
    for (eye, width, size) in [
        (DVec3::new(2.0, 2.5, 5.0), 0.2, 0.3),
        (DVec3::new(-1.0, 0.5, 2.6), 0.11, 0.5),
        (DVec3::new(0.0, 5.0, 0.1), 0.4, 0.45),
    ] {
        let eye = Eye::new(eye, DVec3::ZERO);
        // A line with corners, another one by itself, points.
        let corners: Vec<DVec3> = (0..7).map(|_| random.point(1.0)).collect();
        let points: Vec<DVec3> = (0..6).map(|_| random.point(1.0)).collect();
        let mut obj = String::new();
        corners.iter().chain(&points).for_each(|p| writeln!(obj, "v {} {} {}", p.x, p.y, p.z).unwrap());
        obj += "l 1 2 3 4 5\nl 6 7\np 8 9 10 11 12 13\n";
        fs::write(place.path("a.obj"), &obj).unwrap();
        let command = format!(
            "render a.obj -q --aa 1 --size {WIDTH}x{HEIGHT} {} --line-shape tube --line-width {width}u \
             --point-shape sphere --point-size {size}u --output-depth d.npy",
            eye.options()
        );
        place.run(&command).ok_silently();
        let depths = depths(&place);
        let segments = [[0, 1], [1, 2], [2, 3], [3, 4], [5, 6]].map(|ends| ends.map(|v: usize| corners[v]));
        let meet = |at: DVec2| {
            let ray = eye.ray(at);
            let tubes = segments.iter().map(|s| meet_capsule(eye.eye, ray, *s, 0.5 * width));
            let spheres = points.iter().map(|p| meet_sphere(eye.eye, ray, *p, 0.5 * size));
            let all = tubes.chain(spheres).zip(0..).filter_map(|(t, body)| Some((t?, body)));
            all.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let (mut inside, mut outside) = (0, 0);
        for y in 0..HEIGHT {
            for x in 0..WIDTH {
                let drawn = f64::from(depths[y * WIDTH + x]);
                // Bodies are polygons in two directions, together a third of a pixel from the true form at most.
                let near: Vec<Option<(f64, i32)>> =
                    [(0.0, 0.0), (0.2, 0.2), (-0.2, 0.2), (0.2, -0.2), (-0.2, -0.2)]
                        .map(|(dx, dy)| meet(DVec2::new(x as f64 + 0.5 + dx, y as f64 + 0.5 + dy)))
                        .to_vec();
                if near.iter().all(Option::is_none) {
                    outside += 1;
                    assert!(drawn.is_infinite(), "{x}, {y} is drawn");
                } else if near.iter().all(Option::is_some) {
                    assert!(drawn.is_finite(), "{x}, {y} is empty");
                    // Where one body hides the other, what is behind may be seen from beside it.
                    if near.iter().flatten().any(|hit| Some(hit.1) != near[0].map(|hit| hit.1)) {
                        continue;
                    }
                    let all = || near.iter().flatten().map(|hit| hit.0);
                    let (low, high) = (all().fold(1e9, f64::min), all().fold(0.0, f64::max));
                    let pixel = high / Eye::scale();
                    let fits = (low - 0.4 * pixel..=high + 0.4 * pixel).contains(&drawn);
                    assert!(fits, "{x}, {y}: {drawn}, not {low} to {high}");
                    inside += 1;
                }
            }
        }
        assert!(inside > 1000 && outside > 5000, "{inside} {outside}");
    }
}

/// A picture of three bytes a pixel.
fn picture(place: &Place, command: &str) -> Vec<[u8; 3]> {
    place.run(&format!("render {command} -q --size {WIDTH}x{HEIGHT} -o a.ppm")).ok_silently();
    let bytes = place.read("a.ppm");
    let (pixels, _) = bytes[bytes.len() - 3 * WIDTH * HEIGHT..].as_chunks::<3>();
    pixels.to_vec()
}

fn differ(a: [u8; 3], b: [u8; 4]) -> i32 {
    (0..3).map(|k| (i32::from(a[k]) - i32::from(b[k])).abs()).max().unwrap_or(0)
}

#[test]
fn points_have_the_colours_of_their_values() {
    let place = Place::new();
    let mut random = Random(11);
    let points: Vec<(DVec3, f64)> = (0..40)
        .map(|k| {
            let at =
                DVec3::new(f64::from(k % 8) * 0.25 - 0.9, f64::from(k / 8) * 0.3 - 0.6, 0.1 * random.next());
            (at, if k == 7 { f64::NAN } else { (random.next() * 100.0).round() })
        })
        .collect();
    let mut text = "x y z heat heat2\n".to_owned();
    points.iter().for_each(|(p, v)| writeln!(text, "{} {} {} {v} {}", p.x, p.y, p.z, -v).unwrap());
    fs::write(place.path("a.xyz"), &text).unwrap();
    let eye = Eye::new(DVec3::new(0.0, 0.2, 4.5), DVec3::ZERO);
    let look = format!("a.xyz {} --aa 1 --no-bar --point-size 6 --up-axis y", eye.options());
    let check = |options: &str, value: &dyn Fn(usize) -> f64, colors: &DataColors| {
        for shape in ["square", "round"] {
            let picture = picture(&place, &format!("{look} --point-shape {shape} {options}"));
            for (k, (p, _)) in points.iter().enumerate() {
                let at = eye.screen(*p).floor();
                let (found, expected) =
                    (picture[at.y as usize * WIDTH + at.x as usize], colors.color(value(k)));
                assert!(differ(found, expected) <= 1, "{options}, {k}: {found:?}, not {expected:?}");
            }
        }
    };
    let map = |name: &str| ColorMap::named(name).unwrap();
    let heat = |k: usize| points[k].1;
    let ends = points
        .iter()
        .map(|p| p.1)
        .filter(|v| v.is_finite())
        .fold([1e9, -1e9], |[l, h]: [f64; 2], v| [l.min(v), h.max(v)]);
    check("--color-by heat", &heat, &DataColors::new("heat", map("viridis"), ends));
    let mut bands = DataColors::new("heat", map("turbo"), [20.0, 80.0]);
    (bands.bands, bands.below, bands.above) = (Some(5), Some([0, 0, 0, 255]), Some([9, 8, 7, 255]));
    let options =
        "--color-by heat --colormap turbo --range 20,80 --bands 5 --below-color #000 --above-color #090807";
    check(options, &heat, &bands);
    let mut log = DataColors::new("heat", map("magma"), [1.0, 100.0]);
    log.scale = tercio::scene::color_map::Scale::Log;
    check("--color-by heat@point --colormap magma --range 1,100 --log", &heat, &log);
    let height = |k: usize| f64::from(points[k].0.y as f32);
    check("--color-by @elevation", &height, &DataColors::new("", map("viridis"), [-0.6, 0.6]));
    place.run("render a.xyz -o a.png --color-by cold").failed(
        1,
        &["a.xyz: there is no attribute \"cold\"; there are heat (lines and points), heat2 (lines and points), @elevation"],
    );
    place
        .run("render a.xyz -o a.png --color-by heat --isolines 3")
        .failed(1, &["isolines need values at vertices"]);
}

/// A square of two triangles at the left, a line that crosses the picture above it, and a point at the right.
const MIXED: &str = "# vtk DataFile Version 3.0\nmixed\nASCII\nDATASET POLYDATA\nPOINTS 7 float\n\
    -1 -1 0 0 -1 0 0 0 0 -1 0 0\n-1 0.5 0 1 0.5 0\n0.6 -0.5 0\n\
    VERTICES 1 2\n1 6\nLINES 1 3\n2 4 5\nPOLYGONS 1 5\n4 0 1 2 3\n\
    CELL_DATA 3\nSCALARS v float 1\nLOOKUP_TABLE default\n100 200 300\n\
    POINT_DATA 7\nSCALARS v float 1\nLOOKUP_TABLE default\n2 2 4 4 0 8 9\nVECTORS flow float\n\
    0 0 0  0.4 0 0  0 0.2 0  nan 0 0  0 0 0.1  0 -0.3 0  0.1 0.1 0\n";

#[test]
fn lines_are_coloured_along_their_way_in_the_range_of_all_there_is() {
    let place = Place::new();
    fs::write(place.path("a.vtk"), MIXED).unwrap();
    let view = "--view front --orthographic --no-bar --shading unlit --background #fff --aa 1";
    let range = |options: &str| {
        let outcome = place.run(&format!("render a.vtk -o a.png -q --size 64x48 {options} --stats -"));
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let stats: serde_json::Value = serde_json::from_str(outcome.text()).unwrap();
        stats["look"]["data"]["range"].to_string()
    };
    assert_eq!(range("--color-by v"), "[0.0,9.0]");
    assert_eq!(range("--color-by v@point"), "[0.0,9.0]");
    assert_eq!(range("--color-by v --range 50%,"), "[4.0,9.0]");
    for shape in ["flat --line-width 5", "tube --line-width 9"] {
        let line = |options: &str| {
            let picture = picture(&place, &format!("a.vtk {view} --line-shape {shape} {options}"));
            let rows: Vec<&[[u8; 3]]> = picture.chunks(WIDTH).collect();
            // The upper quarter has the line alone; the row through its middle is the longest.
            let filled = |row: &[[u8; 3]]| row.iter().filter(|c| **c != [255; 3]).count();
            let row = rows[..HEIGHT / 2].iter().max_by_key(|row| filled(row)).unwrap();
            row.iter().copied().filter(|c| *c != [255; 3]).collect::<Vec<_>>()
        };
        if shape.starts_with("flat") {
            let smooth = line("--color-by v --colormap gray --range 0,9");
            let colors = DataColors::new("v", ColorMap::named("gray").unwrap(), [0.0, 9.0]);
            let (first, length) = (2.5, smooth.len() as f64 - 5.0);
            for (i, color) in smooth.iter().enumerate() {
                let value = ((i as f64 + 0.5 - first) / length).clamp(0.0, 1.0) * 8.0;
                assert!(differ(*color, colors.color(value)) <= 3, "{i}: {color:?}, {value}");
            }
            let mut bands = line("--color-by v --bands 4 --range 0,8 --colormap turbo");
            bands.dedup();
            assert_eq!(bands.len(), 4, "{bands:?}");
        } else {
            let tube = line("--color-by v --bands 2 --range 0,8 --colormap bwr");
            let is = |color: &[u8; 3], k: usize| color[k] > 60 && color[2 - k] < color[k] / 3;
            let (left, right) = (&tube[tube.len() / 8], &tube[tube.len() * 7 / 8]);
            assert!(is(left, 2) && is(right, 0), "{left:?} {right:?}");
        }
    }
}

#[test]
fn glyphs_reach_to_the_ends_of_their_vectors() {
    let place = Place::new();
    let mut random = Random(5);
    let arrows: Vec<[DVec3; 2]> = (0..9)
        .map(|k| {
            let at = DVec3::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.4 * random.next());
            [at, random.point(1.0).normalize() * (0.3 + 0.5 * random.next())]
        })
        .collect();
    let mut text = "x,y,z,w_x,w_y,w_z\n".to_owned();
    for [p, v] in &arrows {
        let v = *v * 10.0;
        writeln!(text, "{},{},{},{},{},{}", p.x, p.y, p.z, v.x, v.y, v.z).unwrap();
    }
    text += "0.5,0.5,0,0,0,0\n-0.5,0.5,0,nan,0,0\n";
    fs::write(place.path("a.csv"), &text).unwrap();
    let eye = Eye::new(DVec3::new(1.5, 1.0, 6.5), DVec3::ZERO);
    let camera = format!("{} --aa 16 --background #fff --up-axis y", eye.options());
    for shape in ["arrow", "cone", "line"] {
        let drawn = |options: &str| {
            let options = format!(
                "a.csv {camera} --point-size 0.01 --glyphs w --glyph {shape} --glyph-color #000 {options}"
            );
            picture(&place, &options).iter().map(|c| *c != [255; 3]).collect::<Vec<bool>>()
        };
        let picture = drawn("--glyph-scale 0.1");
        let near = |p: DVec2, reach: f64| {
            (0..WIDTH * HEIGHT).any(|i| {
                let at = DVec2::new((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5);
                picture[i] && at.distance(p) < reach
            })
        };
        for [p, v] in &arrows {
            let [tail, tip] = [eye.screen(*p), eye.screen(*p + *v)];
            assert!(near(tip, 3.0) && near(tail, 3.0), "{shape}: nothing at {tip} or {tail}");
            let along = (tip - tail).normalize_or_zero();
            if tip.distance(tail) > 12.0 && shape != "cone" {
                // Nothing goes on behind the tip, unless it is another one.
                let others = arrows.iter().filter(|[q, _]| q != p);
                let is_alone = others.map(|[q, w]| [eye.screen(*q), eye.screen(*q + *w)]).all(|[a, b]| {
                    (0..=10).all(|k| a.lerp(b, f64::from(k) / 10.0).distance(tip + along * 4.0) > 9.0)
                });
                assert!(!is_alone || !near(tip + along * 4.0, 2.0), "{shape}: beyond {tip}");
            }
        }
        assert!(picture.iter().filter(|d| **d).count() < WIDTH * HEIGHT / 4);
        // Longer by half: more is drawn.
        let count = |picture: &[bool]| picture.iter().filter(|d| **d).count();
        assert!(count(&drawn("--glyph-scale 0.15")) > count(&picture) * 5 / 4);
    }
    let told = place.run(&format!("render a.csv -o a.png -v {camera} --glyphs w"));
    assert!(told.stderr.contains("9 glyphs at 9 places"), "{}", told.stderr);
    assert!(told.stderr.contains("1 vectors are 0; 1 are not numbers"), "{}", told.stderr);
    place.run("render a.csv -o a.png --glyphs q").failed(1, &["no vector \"q\"", "there are w"]);
    place.run("render a.csv -o a.png --glyph cone").failed(2, &["--glyphs"]);
    place
        .run("render a.csv -o a.png --glyphs w --parts")
        .failed(2, &["--glyphs is not possible with --parts"]);
}

#[test]
fn bodies_obey_the_picture_law() {
    let place = Place::new();
    fs::write(place.path("a.vtk"), MIXED).unwrap();
    let looks = [
        "a.vtk --color-by v --line-shape tube --line-width 6 --glyphs flow --glyph-every 1 --aa 4",
        "builtin:sphere@500 --mode wireframe --line-shape tube --aa 1",
        "builtin:sphere@2k --glyphs @normal --color-by @elevation --aa 4",
        "builtin:gyroid@1k --mode points --color-by @normal:x --point-size 5 --aa 1",
    ];
    let ways = [
        "--threads 1 --tile-size 8",
        "--threads 3 --sorting triangles",
        "--ranks 3 --organisation sort-last",
    ];
    for look in looks {
        let expected = picture(&place, look);
        assert!(expected.iter().any(|c| c[0] != expected[0][0]), "{look}: nothing drawn");
        for way in ways {
            assert!(picture(&place, &format!("{look} {way}")) == expected, "{look} {way}");
        }
    }
}
