//! Golden pictures of the annotation alone, on plain backgrounds.

use glam::DVec3;
use tercio_annotate::{Annotation, Caption, Marks, NumberFormat, Place, ScalarBar};
use tercio_raster::color8;
use tercio_raster::frame::Planes;
use tercio_scene::color_map::{Category, ColorMap, DataColors, Scale};
use tercio_scene::{Camera, Projection};
use tercio_testkit::golden;

fn bar(map: &str, range: [f64; 2], title: &str) -> ScalarBar {
    ScalarBar {
        colors: DataColors::new("p", ColorMap::named(map).expect("a known map"), range),
        title: title.into(),
        format: NumberFormat::Auto,
        place: place("right"),
        is_upright: true,
        shows_nan: false,
        marks: Marks::Usual,
    }
}

fn place(name: &str) -> Place {
    Place::named(name).expect("a place")
}

fn camera(eye: [f64; 3], target: [f64; 3], up: DVec3) -> Camera {
    let projection = Projection::Perspective { fov_y: 0.5 };
    Camera { eye: eye.into(), target: target.into(), up, projection, near: None, shift: [0.0; 2] }
}

fn check(
    name: &str,
    annotation: &Annotation,
    camera: &Camera,
    bounds: [[f64; 3]; 2],
    size: (u32, u32),
    paper: [u8; 4],
) {
    let camera = annotation.room(size, &[[1.0; 2]]).place(camera);
    let laid_out = annotation.lay_out(&camera, size, bounds.map(DVec3::from), DVec3::Z).expect("a camera");
    assert_eq!(laid_out.left_out, Vec::<String>::new(), "{name}");
    let (width, height) = size;
    let pixels = width as usize * height as usize;
    let mut planes =
        Planes { color: vec![paper; pixels], linear: vec![[0.0; 4]; pixels], ..Planes::default() };
    if !laid_out.behind.is_empty() {
        laid_out.behind.draw_behind(&mut planes, width, height);
        let paper = paper.map(|v| tercio_scene::srgb_to_linear(f64::from(v) / 255.0) as f32);
        for (color, linear) in planes.color.iter_mut().zip(&planes.linear) {
            let left = 1.0 - linear[3];
            *color = color8(std::array::from_fn(|k| linear[k] + paper[k] * left));
        }
    }
    let mut whole = planes.clone();
    laid_out.onto.draw(&mut whole, width, 0..height);
    golden::check("annotate", name, width, height, whole.color.as_flattened());
    // The same in bands.
    for rows in [1, 7] {
        let mut first = 0;
        while first < height {
            let rows = first..(first + rows).min(height);
            let range = (rows.start * width) as usize..(rows.end * width) as usize;
            let mut band = Planes { color: planes.color[range.clone()].to_vec(), ..Planes::default() };
            laid_out.onto.draw(&mut band, width, rows.clone());
            assert!(band.color == whole.color[range], "{name}: rows {rows:?}");
            first = rows.end;
        }
    }
}

#[test]
fn golden_bar_beside_a_box() {
    let mut bar = bar("viridis", [-1234.5, 8765.0], "Pressure (Pa)");
    (bar.colors.below, bar.colors.above) = (Some([40, 40, 200, 255]), Some([200, 30, 30, 255]));
    let annotation = Annotation {
        captions: vec![
            Caption::title("Static pressure, α = 4.5°"),
            Caption { text: "step 1200\nt = 0.35 s".into(), place: place("top-left"), size: 1.0 },
        ],
        bars: vec![bar],
        axes: Some(place("bottom-left")),
        scale_bar: Some((place("bottom-right"), "mm".into())),
        bounds: true,
        grid: true,
        ..Annotation::default()
    };
    let camera = camera([1e6 + 6.0, -9.0, 5.0], [1e6, 0.0, 0.0], DVec3::Z);
    let bounds = [[1e6 - 2.0, -1.0, -1.0], [1e6 + 2.0, 1.0, 1.0]];
    check("bar-and-box", &annotation, &camera, bounds, (800, 600), [255; 4]);
}

#[test]
fn golden_small_and_dark() {
    let mut bar = bar("magma", [1e-5, 30.0], "k (m²/s²)");
    bar.colors.scale = Scale::Log;
    bar.shows_nan = true;
    let annotation = Annotation {
        captions: vec![Caption::title("Turbulence")],
        bars: vec![bar],
        axes: Some(place("bottom-left")),
        color: tercio_annotate::annotation::BRIGHT,
        ..Annotation::default()
    };
    let camera = camera([6.0, -9.0, 5.0], [0.0; 3], DVec3::Z);
    check("small-and-dark", &annotation, &camera, [[-1.0; 3], [1.0; 3]], (300, 200), [20, 22, 30, 255]);
}

#[test]
fn golden_bands_below_on_nothing() {
    let mut bar = bar("coolwarm", [0.0, 1.0], "Wall distance y⁺");
    (bar.place, bar.is_upright) = (place("bottom"), false);
    bar.colors.bands = Some(8);
    bar.colors.above = Some([0, 0, 0, 255]);
    let annotation = Annotation { bars: vec![bar], ..Annotation::default() };
    let camera = camera([6.0, -9.0, 5.0], [0.0; 3], DVec3::Z);
    check("bands-below", &annotation, &camera, [[-1.0; 3], [1.0; 3]], (640, 200), [0; 4]);
}

#[test]
fn golden_categories_and_a_long_title() {
    let mut categories = bar("viridis", [0.0, 1.0], "Tissue");
    categories.place = place("left");
    let set = ColorMap::named("Set1").expect("a known map");
    let names = ["bone", "skin", "muscle", "fat", "vessels"];
    categories.colors.categories = (0..5)
        .map(|i| {
            let [r, g, b] = set.category(i).map(|c| (c * 255.0) as u8);
            Category { value: i as f64, label: names[i].into(), color: [r, g, b, 255] }
        })
        .collect();
    let annotation = Annotation { bars: vec![categories], ..Annotation::default() };
    let camera = camera([6.0, -9.0, 5.0], [0.0; 3], DVec3::Z);
    check("categories", &annotation, &camera, [[-1.0; 3], [1.0; 3]], (320, 240), [255; 4]);
    let mut turned = bar("cividis", [1e6, 1e6 + 1e-3], "Turbulent kinetic energy (m²/s²)");
    turned.colors.scale = Scale::Linear;
    let annotation = Annotation { bars: vec![turned], ..Annotation::default() };
    check("turned-title", &annotation, &camera, [[-1.0; 3], [1.0; 3]], (320, 400), [255; 4]);
}
