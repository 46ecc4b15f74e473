//! The room that annotation leaves the model.

use super::*;

/// The boxes of what is at a side or in a corner, and the room of the model.
fn check_room(annotation: &Annotation, size: (u32, u32), camera: &Camera) -> LaidOut {
    let bounds = [DVec3::splat(-1.0), DVec3::splat(1.0)];
    let laid_out = check(annotation, &annotation.make_room(camera, size), size, bounds);
    let [left, top, right, bottom] = annotation.margins(size.0, size.1);
    let room = [left, top, f64::from(size.0) - right, f64::from(size.1) - bottom];
    // One pixel, because margins are rounded.
    for placed in &laid_out.placed {
        assert!(!overlap(&placed.rect, &room, -1.0), "{size:?}: {placed:?} lies on the model: {room:?}");
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
        direction in any::<[i8; 3]>(),
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
        check_room(&annotation, size, &camera(eye.normalize() * 7.0, Projection::Orthographic { height }));
    }
}

/// A corner is in a strip that something else takes anyway, or at the side where it costs the model the least.
#[test]
fn corners_cost_the_model_little() {
    let axes = Some(Place { x: 0.0, y: 1.0 });
    let margins = |annotation: &Annotation, size: (u32, u32)| annotation.margins(size.0, size.1);
    let alone = Annotation { axes, ..Annotation::default() };
    let [left, top, right, bottom] = margins(&alone, (640, 480));
    assert!(left > 60.0 && [top, right, bottom] == [0.0; 3], "the wider side of the picture");
    let [left, _, _, bottom] = margins(&alone, (480, 640));
    assert!(left == 0.0 && bottom > 60.0, "the higher one");
    let text = Caption {
        text: "a text that is beside the model".into(),
        place: Place { x: 0.0, y: 0.5 },
        size: 1.0,
    };
    let with_text = Annotation { captions: vec![text], axes, ..Annotation::default() };
    let only_text = Annotation { axes: None, ..with_text.clone() };
    assert_eq!(margins(&with_text, (480, 640)), margins(&only_text, (480, 640)), "in the strip of the text");
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
        let laid_out = check_room(&annotation, size, &camera);
        assert_eq!(laid_out.left_out, Vec::<String>::new(), "{size:?}");
        assert!(laid_out.scale.is_some());
        assert_eq!(annotation.room(size).1, size.1, "{size:?}");
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
        let [left, top, right, bottom] = annotation.margins(size.0, size.1);
        let (w, h) = (f64::from(size.0), f64::from(size.1));
        let room = [left, top, w - right, h - bottom];
        assert!(room[2] - room[0] >= w * 0.38 && room[3] - room[1] >= h * 0.38, "{size:?}: {room:?}");
        let layout = annotation.fixed(size.0, size.1).layout;
        for placed in &layout.placed {
            assert!(!overlap(&placed.rect, &room, -1.0), "{size:?}: {placed:?} lies on the model: {room:?}");
        }
        assert!(!layout.left_out.is_empty(), "{size:?}");
    }
}
