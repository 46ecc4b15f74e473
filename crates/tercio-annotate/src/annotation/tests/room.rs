//! The room that annotation leaves the model.

use super::*;

/// The boxes of what is at a side or in a corner, and that of a model of this shape, framed in its room.
fn check_room(annotation: &Annotation, size: (u32, u32), shape: Shape, camera: &Camera) -> LaidOut {
    let bounds = [DVec3::splat(-1.0), DVec3::splat(1.0)];
    let room = annotation.room(size, &[shape]);
    let laid_out = check(annotation, &room.place(camera), size, bounds);
    let [left, top, right, bottom] = room.margins();
    let inner = [left, top, f64::from(size.0) - right, f64::from(size.1) - bottom];
    let [width, height] = [inner[2] - inner[0], inner[3] - inner[1]];
    let scale = (width / shape[0]).min(height / shape[1]) * 0.5;
    let middle = [inner[0] + width * 0.5, inner[1] + height * 0.5];
    let [x, y] = shape.map(|half| half * scale);
    let model = [middle[0] - x, middle[1] - y, middle[0] + x, middle[1] + y];
    // One pixel, because margins are rounded.
    for placed in &laid_out.placed {
        assert!(!overlap(&placed.rect, &model, -1.0), "{size:?}: {placed:?} lies on the model: {model:?}");
    }
    laid_out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    /// Whatever is at a side or in a corner, the model is framed beside it.
    #[test]
    fn the_model_is_beside_all_of_it(
        size in sizes(), scale in 0.25f64..4.0, places in prop::collection::vec((0usize..9, "[a-z]{1,9}( [a-z]{1,9}){0,9}"), 0..5),
        bar_place in 0usize..9, is_upright in any::<bool>(), flags in any::<[bool; 4]>(), axes in 0usize..9,
        direction in any::<[i8; 3]>(), shape in [0.1f64..10.0, 0.1..10.0],
    ) {
        let place = |number: usize| {
            // What is in the middle of the picture lies on the model.
            let name = Place::names().filter(|name| *name != "center").nth(number % 8).expect("a place");
            Place::named(name).expect("a place")
        };
        let captions = places.into_iter().map(|(number, text)| Caption { text, place: place(number), size: 1.0 });
        let bar = ScalarBar { place: place(bar_place), is_upright, ..bar([-1.0, 2.0], Scale::Linear) };
        let annotation = Annotation {
            captions: captions.collect(),
            bars: if flags[0] { vec![bar] } else { vec![] },
            axes: flags[1].then(|| place(axes)),
            scale_bar: flags[2].then(|| (Place { x: 1.0, y: 1.0 }, "mm".into())),
            text_scale: scale,
            ..Annotation::default()
        };
        let eye = DVec3::from_array(direction.map(f64::from)) + DVec3::new(0.5, 0.25, 0.375);
        let height = if flags[3] { 3.0 } else { 2e-5 };
        let camera = camera(eye.normalize() * 7.0, Projection::Orthographic { height });
        check_room(&annotation, size, shape, &camera);
    }
}

/// A corner takes nothing from a model that does not reach it. Otherwise it is in a strip that something else takes anyway, or at the side
/// where it costs the model the least.
#[test]
fn corners_cost_the_model_little() {
    let axes = Some(Place { x: 0.0, y: 1.0 });
    let alone = Annotation { axes, ..Annotation::default() };
    let of_shape = |size: (u32, u32), shape: Shape| alone.room(size, &[shape]).margins();
    for (size, shape) in [((640, 480), [4.0, 1.0]), ((960, 480), [1.0, 1.0]), ((480, 640), [1.0, 3.0])] {
        assert_eq!(of_shape(size, shape), [0.0; 4], "{size:?} {shape:?}");
    }
    let [left, top, right, bottom] = of_shape((640, 480), [4.0, 3.0]);
    assert!([top, right] == [0.0; 2] && (left == 0.0) != (bottom == 0.0), "one strip");
    let [left, _, _, bottom] = of_shape((640, 480), [6.0, 4.0]);
    assert!(left == 0.0 && bottom > 60.0, "a wide model has room above a strip");
    let [left, _, _, bottom] = of_shape((640, 480), [6.0, 5.0]);
    assert!(left > 60.0 && bottom == 0.0, "a high one beside it");
    // Views of different shapes.
    let both = alone.room((640, 480), &[[4.0, 1.0], [1.0, 3.0]]).margins();
    assert!(both == [0.0; 4]);
    let text = Caption {
        text: "a text that is beside the model".into(),
        place: Place { x: 0.0, y: 0.5 },
        size: 1.0,
    };
    let with_text = Annotation { captions: vec![text], axes, ..Annotation::default() };
    let only_text = Annotation { axes: None, ..with_text.clone() };
    assert_eq!(margins(&with_text, (480, 640)), margins(&only_text, (480, 640)), "in the strip of the text");
}

/// What takes too much is left out, and not what is behind it.
#[test]
fn one_large_text_leaves_the_rest_its_room() {
    let long =
        "a text that is much too long for a picture of this size, and is broken into many lines. ".repeat(6);
    let text = |y: f64| Caption { text: long.clone(), place: Place { x: 0.5, y }, size: 1.0 };
    let annotation = Annotation {
        captions: vec![text(0.0), text(1.0)],
        bars: vec![bar([-1.0, 2.0], Scale::Linear)],
        axes: Some(Place { x: 0.0, y: 1.0 }),
        ..Annotation::default()
    };
    let camera = camera(DVec3::new(1.0, 2.0, 7.0), Projection::Orthographic { height: 3.0 });
    let laid_out = check_room(&annotation, (400, 300), [1.0; 2], &camera);
    let names: Vec<&str> = laid_out.placed.iter().map(|placed| &*placed.what).collect();
    assert!(names.contains(&"bar") && names.contains(&"axes"), "{names:?}, not {:?}", laid_out.left_out);
}

/// The scale bar of a low picture finds its room beside the scalar bar, and takes none from the model's height.
#[test]
fn scale_bars_find_room_beside_a_bar() {
    for size in [(900, 160), (1200, 200), (400, 120)] {
        let annotation = Annotation {
            bars: vec![ScalarBar { shows_nan: false, ..bar([-1.0, 2.0], Scale::Linear) }],
            scale_bar: Some((Place { x: 1.0, y: 1.0 }, "mm".into())),
            ..Annotation::default()
        };
        let camera = camera(DVec3::new(1.0, 2.0, 7.0), Projection::Orthographic { height: 3.0 });
        let laid_out = check_room(&annotation, size, [1.0; 2], &camera);
        assert_eq!(laid_out.left_out, Vec::<String>::new(), "{size:?}");
        assert!(laid_out.scale.is_some());
        assert_eq!(annotation.room(size, ROUND).size().1, size.1, "{size:?}");
    }
}

/// Text and bars leave the model of a small picture its room, or are left out.
#[test]
fn small_pictures_have_room_for_the_model() {
    for size in [(64, 64), (48, 80), (90, 90)] {
        let annotation = Annotation {
            captions: vec![
                Caption::title("Wing of a plane"),
                Caption { text: "step 12".into(), place: Place { x: 0.0, y: 0.0 }, size: 1.0 },
                Caption { text: "below".into(), place: Place { x: 1.0, y: 1.0 }, size: 1.0 },
            ],
            bars: vec![bar([-1.0, 2.0], Scale::Linear)],
            axes: Some(Place { x: 0.0, y: 1.0 }),
            bounds: true,
            ..Annotation::default()
        };
        let [left, top, right, bottom] = margins(&annotation, size);
        let (w, h) = (f64::from(size.0), f64::from(size.1));
        let room = [w - right - left, h - bottom - top];
        assert!(room[0] >= w * 0.38 && room[1] >= h * 0.38, "{size:?}: {room:?}");
        let layout = annotation.fixed(size.0, size.1).layout;
        assert!(!layout.left_out.is_empty(), "{size:?}");
    }
}

/// The widest pictures show the model in their middle, where cameras can see it.
#[test]
fn the_widest_pictures_have_a_camera() {
    let place = Place::named("left").expect("a place");
    let annotation = Annotation {
        bars: vec![ScalarBar { place, ..bar([-1.0, 2.0], Scale::Linear) }],
        ..Annotation::default()
    };
    for (size, difference) in [((65_536, 1024), 0.0), ((65_436, 1024), 100.0)] {
        let [left, _, right, _] = annotation.room(size, ROUND).margins();
        assert!(left > 60.0 && left - right <= difference && right < left + 1.0, "{left} {right}");
    }
    let [left, _, right, _] = annotation.room((2000, 1024), ROUND).margins();
    assert!(left > 60.0 && right == 0.0);
}
