use proptest::prelude::*;
use tercio_mesh::trig::sin_cos_degrees;
use tercio_scene::Projection;
use tercio_scene::color_map::{Category, ColorMap, DataColors, Scale};

use super::*;
use crate::bar::Marks;
use crate::font::Line;
use crate::layout::{Rect, overlap};

mod bars;
mod numbers;
mod room;

/// A model that is as wide as high.
const ROUND: &[Shape] = &[[1.0; 2]];

/// What annotation takes from such a model.
fn margins(annotation: &Annotation, size: (u32, u32)) -> [f64; 4] {
    annotation.room(size, ROUND).margins()
}

fn camera(eye: DVec3, projection: Projection) -> Camera {
    Camera { eye, target: DVec3::ZERO, up: DVec3::Y, projection, near: None, shift: [0.0; 2] }
}

fn bar(range: [f64; 2], scale: Scale) -> ScalarBar {
    let map = ColorMap::named("viridis").expect("a known map");
    let mut colors = DataColors::new("p", map, range);
    colors.scale = scale;
    ScalarBar {
        colors,
        title: "Pressure (Pa)".into(),
        format: NumberFormat::Auto,
        place: Place::named("right").expect("a place"),
        is_upright: true,
        shows_nan: true,
        marks: Marks::Usual,
    }
}

/// No two boxes overlap, nothing is drawn outside of the picture, and boxes contain what is drawn.
fn check(annotation: &Annotation, camera: &Camera, size: (u32, u32), bounds: [DVec3; 2]) -> LaidOut {
    let laid_out = annotation.lay_out(camera, size, bounds, DVec3::Y).expect("a camera");
    let (w, h) = (f64::from(size.0), f64::from(size.1));
    for (number, a) in laid_out.placed.iter().enumerate() {
        let [left, top, right, bottom] = a.rect;
        assert!(left >= 0.0 && top >= 0.0 && right <= w && bottom <= h, "{size:?}: {a:?} leaves the picture");
        for b in &laid_out.placed[number + 1..] {
            assert!(!overlap(&a.rect, &b.rect, 0.0), "{size:?}: {a:?} and {b:?}");
        }
    }
    // Ink of text and bars, not lines of the floor.
    if !annotation.grid
        && let Some([left, top, right, bottom]) = laid_out.onto.bounds()
    {
        let inside = left >= -0.5 && top >= -0.5 && right <= w + 0.5 && bottom <= h + 0.5;
        assert!(inside, "{size:?}: ink at {:?}", [left, top, right, bottom]);
    }
    laid_out
}

fn sizes() -> impl Strategy<Value = (u32, u32)> {
    prop_oneof![
        Just((64, 64)),
        Just((300, 200)),
        Just((1024, 768)),
        Just((200, 1200)),
        Just((8192, 8192)),
        (64u32..1500, 64u32..1500)
    ]
}

fn ranges() -> impl Strategy<Value = [f64; 2]> {
    prop_oneof![
        Just([1e-300, 1e300]),
        Just([-1e300, 1e300]),
        Just([1e-300, 3e-300]),
        Just([1e6, 1e6 + 1e-3]),
        Just([-1e6 - 1e-3, -1e6]),
        Just([0.0, 1.0]),
        (-1e9f64..1e9, 1e-6f64..1e9).prop_map(|(low, span)| [low, low + span]),
        (-12i32..12).prop_map(|e| [0.0, 2.5 * 10f64.powi(e)]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn nothing_overlaps_or_leaves_the_picture(
        size in sizes(), range in ranges(), log in any::<u8>(), place in 0usize..9, is_upright in any::<bool>(),
        ends in any::<[bool; 3]>(), title in "[A-Za-z αβ²()]{0,60}", scale in 0.5f64..3.0, bands in 0u32..14,
        direction in any::<[i8; 3]>(), count in 1usize..5, caption in "[a-z ]{0,80}", flags in any::<[bool; 4]>(),
    ) {
        let kind = match log % 3 {
            1 if range[0] > 0.0 => Scale::Log,
            2 => Scale::SymmetricLog { threshold: (range[1].abs() * 1e-3).max(1e-300) },
            _ => Scale::Linear,
        };
        let mut bar = bar(range, kind);
        let name = Place::names().nth(place).expect("a place");
        (bar.place, bar.is_upright, bar.shows_nan) = (Place::named(name).expect("a place"), is_upright, ends[2]);
        bar.colors.below = ends[0].then_some([255, 0, 0, 255]);
        bar.colors.above = ends[1].then_some([255, 0, 255, 255]);
        bar.colors.bands = (bands > 0).then_some(bands);
        bar.title.clone_from(&title);
        if bands == 13 {
            let color = [9, 9, 9, 255];
            bar.colors.categories = (0..24).map(|i| Category { value: i.into(), label: format!("{title} {i}"), color }).collect();
        }
        let captions = vec![
            Caption::title(&title),
            Caption { text: caption, place: Place { x: 1.0, y: 1.0 }, size: 1.0 },
        ];
        let annotation = Annotation {
            captions,
            bars: vec![bar; count],
            axes: flags[0].then_some(Place { x: 0.0, y: 1.0 }),
            scale_bar: flags[1].then(|| (Place { x: 1.0, y: 1.0 }, "mm".into())),
            bounds: flags[2],
            grid: flags[3],
            text_scale: scale,
            color: DARK,
        };
        let eye = DVec3::from_array(direction.map(f64::from)) + DVec3::new(0.5, 0.25, 0.375);
        let camera = camera(eye.normalize() * 7.0, Projection::Perspective { fov_y: 0.5 });
        check(&annotation, &camera, size, [DVec3::splat(-1.0), DVec3::new(1.0, 2.0, 1.0)]);
    }
}

/// What is asked for is there where there is room.
#[test]
fn usual_pictures_have_all_of_it() {
    for size in [(300, 200), (640, 480), (1024, 768), (1920, 1080), (8192, 8192)] {
        let annotation = Annotation {
            captions: vec![Caption::title("Wing")],
            bars: vec![bar([-1.0, 2.0], Scale::Linear)],
            axes: Some(Place { x: 0.0, y: 1.0 }),
            scale_bar: Some((Place { x: 1.0, y: 1.0 }, String::new())),
            ..Annotation::default()
        };
        let camera = camera(DVec3::new(1.0, 2.0, 7.0), Projection::Orthographic { height: 3.0 });
        let laid_out = check(&annotation, &camera, size, [DVec3::splat(-1.0), DVec3::splat(1.0)]);
        assert_eq!(laid_out.left_out, Vec::<String>::new(), "{size:?}");
        assert_eq!(laid_out.placed.len(), 4);
    }
    let camera = camera(DVec3::new(1.0, 2.0, 7.0), Projection::Orthographic { height: 3.0 });
    let annotation = Annotation { bars: vec![bar([0.0, 1.0], Scale::Linear)], ..Annotation::default() };
    let laid_out = check(&annotation, &camera, (64, 64), [DVec3::splat(-1.0), DVec3::splat(1.0)]);
    assert_eq!(laid_out.left_out, Vec::<String>::new(), "a bar even in a small picture");
}

/// Bars with the same place are beside each other, and the model is framed beside all of them.
#[test]
fn several_bars_are_side_by_side() {
    let camera = camera(DVec3::new(1.0, 2.0, 7.0), Projection::Orthographic { height: 3.0 });
    let bounds = [DVec3::splat(-1.0), DVec3::splat(1.0)];
    for (name, axis) in [("right", 0), ("left", 0), ("bottom", 1), ("top", 1)] {
        let place = Place::named(name).expect("a place");
        let mut one = bar([0.0, 1.0], Scale::Linear);
        (one.place, one.is_upright) = (place, axis == 0);
        let size = (1024, 768);
        let margin = |count: usize| {
            let annotation = Annotation { bars: vec![one.clone(); count], ..Annotation::default() };
            let laid_out = check(&annotation, &camera, size, bounds);
            assert_eq!((laid_out.placed.len(), laid_out.left_out.len()), (count, 0), "{name}");
            assert!(
                laid_out.placed.iter().all(|p| p.rect[1 - axis] == laid_out.placed[0].rect[1 - axis]),
                "{name}"
            );
            margins(&annotation, size).iter().sum::<f64>()
        };
        let (single, double) = (margin(1), margin(2));
        assert!(double > 1.9 * single, "{name}: {single} {double}");
    }
    // Half of the picture stays free; what finds no room is listed.
    let many = Annotation { bars: vec![bar([0.0, 1.0], Scale::Linear); 20], ..Annotation::default() };
    let laid_out = check(&many, &camera, (640, 480), bounds);
    assert!(laid_out.placed.iter().all(|placed| placed.rect[0] >= 320.0));
    assert_eq!(laid_out.placed.len() + laid_out.left_out.len(), 20);
    assert_eq!(laid_out.left_out.last().map(String::as_str), Some("bar 20"));
}

/// Twice the size is the same layout, twice as large, up to whole pixels.
#[test]
fn the_layout_grows_with_the_picture() {
    let annotation = Annotation {
        captions: vec![
            Caption::title("Wing"),
            Caption { text: "a\nb".into(), place: Place { x: 0.0, y: 0.0 }, size: 1.0 },
        ],
        bars: vec![bar([-1.0, 2.0], Scale::Linear)],
        axes: Some(Place { x: 0.0, y: 1.0 }),
        ..Annotation::default()
    };
    let camera = camera(DVec3::new(1.0, 2.0, 7.0), Projection::Orthographic { height: 3.0 });
    let at = |size| check(&annotation, &camera, size, [DVec3::splat(-1.0), DVec3::splat(1.0)]).placed;
    for (a, b) in at((1024, 768)).iter().zip(at((8192, 6144))) {
        assert_eq!(a.what, b.what);
        for k in 0..4 {
            assert!((a.rect[k] * 8.0 - b.rect[k]).abs() < 24.0, "{a:?} {b:?}");
        }
    }
}

/// A point that a camera shows somewhere in a small picture is at the same place in the free part of the large one.
#[test]
fn margins_move_the_camera() {
    let annotation = Annotation {
        captions: vec![Caption::title("Wing")],
        bars: vec![bar([-1.0, 2.0], Scale::Linear)],
        bounds: true,
        ..Annotation::default()
    };
    let size = (800, 600);
    let [left, top, right, bottom] = margins(&annotation, size);
    assert!(right > 60.0 && top > 20.0 && left > 10.0 && bottom > 10.0);
    let placed = annotation.room(size, ROUND);
    let room = placed.size();
    assert_eq!(room, (800 - (left + right) as u32, 600 - (top + bottom) as u32));
    for projection in [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { height: 5.0 }] {
        let camera = camera(DVec3::new(3.0, 2.0, 9.0), projection);
        let small = Projector::new(&camera, [f64::from(room.0), f64::from(room.1)]).expect("a camera");
        let large = Projector::new(&placed.place(&camera), [800.0, 600.0]).expect("a camera");
        for p in [DVec3::ZERO, DVec3::new(1.0, -0.5, 0.25), DVec3::new(-1.0, 1.0, 2.0)] {
            let (a, b) = (small.point(p).expect("seen"), large.point(p).expect("seen"));
            assert!((a[0] + left - b[0]).abs() < 0.01 && (a[1] + top - b[1]).abs() < 0.01, "{a:?} {b:?}");
        }
    }
}

/// A scale bar is as long as the model's edge of that length is in the picture.
#[test]
fn scale_bars_are_true() {
    for projection in [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { height: 5.0 }] {
        let camera = camera(DVec3::new(0.0, 0.0, 9.0), projection);
        let annotation =
            Annotation { scale_bar: Some((Place { x: 1.0, y: 1.0 }, "mm".into())), ..Annotation::default() };
        let laid_out = check(&annotation, &camera, (1000, 700), [DVec3::splat(-1.0), DVec3::splat(1.0)]);
        let scale = laid_out.scale.expect("there is room");
        let projector = Projector::new(&camera, [1000.0, 700.0]).expect("a camera");
        let [a, b] = [0.0, scale.units].map(|x| projector.point(DVec3::new(x, 0.0, 0.0)).expect("seen"));
        assert!((b[0] - a[0] - scale.pixels).abs() < 1e-9, "{scale:?}");
        assert!(scale.pixels > 90.0 && scale.pixels <= 250.0, "{scale:?}");
        // The ink is that long.
        let line = scale_bar::round_length(projector.pixels_per_unit(), 250.0).expect("a length");
        assert_eq!(line, scale);
    }
}

/// The arms of the axes point where points that are moved along the axes go.
#[test]
fn axes_point_along_the_axes() {
    for eye in [DVec3::new(3.0, 2.0, 9.0), DVec3::new(-5.0, 0.3, -1.0), DVec3::new(0.1, -9.0, 0.2)] {
        let camera = camera(eye, Projection::Orthographic { height: 5.0 });
        let projector = Projector::new(&camera, [800.0, 600.0]).expect("a camera");
        for arm in triad::arms(&projector, 1.0) {
            let axis = match arm.name {
                "x" => DVec3::X,
                "y" => DVec3::Y,
                _ => DVec3::Z,
            };
            let [a, b] = [DVec3::ZERO, axis].map(|p| projector.point(p).expect("seen"));
            let scale = projector.pixels_per_unit();
            for k in 0..2 {
                assert!(((b[k] - a[k]) / scale - arm.tip[k]).abs() < 1e-12);
            }
            assert_eq!(arm.depth > 0.0, axis.dot(-eye) > 0.0, "{}", arm.name);
        }
    }
}

/// In small pictures the axes are smaller, down to where they would take too much of these.
#[test]
fn axes_of_small_pictures_are_smaller() {
    let annotation = Annotation { axes: Place::named("bottom-left"), ..Annotation::default() };
    let camera = camera(DVec3::new(3.0, 2.0, 9.0), Projection::Orthographic { height: 5.0 });
    let side = |size| {
        let laid_out = check(&annotation, &camera, size, [DVec3::NEG_ONE, DVec3::ONE]);
        laid_out.placed.first().map(|placed| placed.rect[2] - placed.rect[0])
    };
    assert_eq!([(640, 480), (256, 192), (220, 165)].map(side), [Some(66.0); 3]);
    assert_eq!(side((160, 120)), Some(48.0));
    assert_eq!(side((128, 96)), Some(47.0));
    assert_eq!(side((96, 72)), None);
}

/// A bar that lies across its border takes its room there, as in the usual orientation.
#[test]
fn bars_across_their_border_have_room_of_their_own() {
    for (name, is_upright, side) in
        [("bottom", true, 3), ("top", true, 1), ("left", false, 0), ("right", false, 2)]
    {
        for size in [(640, 480), (1280, 960), (300, 200)] {
            let place = Place::named(name).expect("a place");
            let across = ScalarBar { place, is_upright, ..bar([-1.0, 2.0], Scale::Linear) };
            let annotation = Annotation { bars: vec![across], ..Annotation::default() };
            let layout = annotation.fixed(size.0, size.1).layout;
            let margins = margins(&annotation, size);
            let [bar] = &layout.placed[..] else { panic!("{name} {size:?}: {:?}", layout.left_out) };
            let [w, h] = layout.size;
            let reach = [bar.rect[2], bar.rect[3], w - bar.rect[0], h - bar.rect[1]][side];
            assert!((margins[side] - reach).abs() <= 1.0, "{name} {size:?}: {margins:?} {bar:?}");
        }
    }
}

/// What is cut off is named among what was left out, and nothing is where all is there.
#[test]
fn cut_text_is_reported() {
    let of = |title: &str, text: &str, size: (u32, u32)| {
        let titled = ScalarBar { title: title.into(), ..bar([-1.0, 2.0], Scale::Linear) };
        let caption = Caption { text: text.into(), place: Place { x: 1.0, y: 0.0 }, size: 1.0 };
        Annotation { bars: vec![titled], captions: vec![caption], ..Annotation::default() }
            .fixed(size.0, size.1)
            .layout
            .left_out
    };
    assert_eq!(of("Pressure", "Wing", (640, 480)), Vec::<String>::new());
    let long = "long title word ".repeat(20);
    assert_eq!(of(&long, "Wing", (640, 480)), ["the end of the title of bar"]);
    let letters = "abcdefgh".repeat(40);
    let cut = of("Pressure", &letters, (640, 480));
    assert!(matches!(&cut[..], [one] if one.starts_with("the end of text \"abcdefgh")), "{cut:?}");
}

/// Titles of bars side by side are apart.
#[test]
fn titles_side_by_side_are_apart() {
    let titled = |title: &str| ScalarBar { title: title.into(), ..bar([-0.5, 0.5], Scale::Linear) };
    let annotation =
        Annotation { bars: vec![titled("height@point"), titled("Elevation")], ..Annotation::default() };
    let layout = annotation.fixed(400, 240).layout;
    let [a, b] = &layout.placed[..] else { panic!("{:?}", layout.placed) };
    assert!(!overlap(&a.rect, &b.rect, layout.em * 0.9), "{a:?} {b:?}");
}

/// From no direction a name of an axis lies on an arrow or on another name, or leaves the box of the axes.
#[test]
fn names_of_axes_are_free() {
    let em = 20.0;
    for azimuth in (0..360).step_by(5) {
        for elevation in (-90..=90).step_by(5) {
            let (sin, cos) = sin_cos_degrees(f64::from(azimuth) + 0.3);
            let (up, level) = sin_cos_degrees(f64::from(elevation) * 0.999);
            let eye = DVec3::new(sin * level, up, cos * level) * 9.0;
            let camera = camera(eye, Projection::Orthographic { height: 5.0 });
            let projector = Projector::new(&camera, [800.0, 600.0]).expect("a camera");
            let arms = triad::arms(&projector, em * 2.1);
            let names = triad::names(&arms, em);
            let boxes: Vec<Rect> = arms
                .iter()
                .zip(&names)
                .map(|(arm, [x, y])| {
                    let half = Line::new(arm.name).width * em * 0.5;
                    [x - half, y - em * 0.26, x + half, y + em * if arm.name == "y" { 0.46 } else { 0.26 }]
                })
                .collect();
            for (k, a) in boxes.iter().enumerate() {
                let what = format!("{} at {azimuth}, {elevation}", arms[k].name);
                assert!(a.iter().all(|side| side.abs() <= em * 3.0), "{what}: {a:?}");
                assert!(boxes[k + 1..].iter().all(|b| !overlap(a, b, 0.0)), "{what}: {boxes:?}");
                for shape in arms.iter().flat_map(|arm| triad::shapes(arm, em)) {
                    assert!(!triad::touches(*a, &shape), "{what}: {a:?} {shape:?}");
                }
            }
        }
    }
}

/// A box touches a polygon that has a corner in it, crosses it or contains it, and no other one.
#[test]
fn boxes_touch_polygons() {
    let rect = [0.0, 0.0, 2.0, 1.0];
    for polygon in [
        vec![[1.0, 0.5], [3.0, 3.0], [4.0, 1.0]],
        vec![[-1.0, 0.4], [3.0, 0.4], [3.0, 0.6], [-1.0, 0.6]],
        vec![[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]],
    ] {
        assert!(triad::touches(rect, &polygon), "{polygon:?}");
    }
    for polygon in [vec![[2.1, 0.0], [3.0, 0.0], [3.0, 1.0]], vec![[2.0, -0.6], [3.5, 0.9], [3.5, -0.6]]] {
        assert!(!triad::touches(rect, &polygon), "{polygon:?}");
    }
}

/// Lines behind the model are not nearer than any of its points.
#[test]
fn the_box_is_behind_the_model() {
    let bounds = [DVec3::new(1e6, -2.0, 0.0), DVec3::new(1e6 + 3.0, 2.0, 1.0)];
    let mut camera = camera(DVec3::new(1e6 + 9.0, 7.0, 8.0), Projection::Perspective { fov_y: 0.6 });
    camera.target = (bounds[0] + bounds[1]) * 0.5;
    let annotation = Annotation { bounds: true, grid: true, ..Annotation::default() };
    let laid_out = check(&annotation, &camera, (1024, 768), bounds);
    let numbers = laid_out.placed.iter().filter(|placed| placed.what.starts_with("number")).count();
    assert!(numbers >= 6, "{:?}", laid_out.placed);
    assert_eq!(laid_out.grid_step, Some(0.5));
    assert!(!laid_out.behind.is_empty());
}
