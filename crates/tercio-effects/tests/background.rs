//! Pixels at the edge of a model: effects darken the model's share only.

mod common;

use common::*;
use tercio_effects::{AmbientOcclusion, EyeDome, add_background};
use tercio_raster::{Frame, Settings};
use tercio_scene::{Background, Scene};

const WHITE: Background = Background::Solid([1.0; 4]);

fn before(background: Background) -> Scene {
    let mut scene = scene(&room());
    scene.instances[0].surface.base_color = [0.25; 3];
    Scene { background, ..scene }
}

/// Drawn on a transparent background, changed, and put before a background.
fn composed(change: impl Fn(&mut Frame, &Scene, &Settings), background: Background) -> Frame {
    let scene = before(Background::Solid([0.0; 4]));
    let (mut frame, settings) = draw(&scene, &into_room(), &Settings::new(90, 70));
    change(&mut frame, &scene, &settings);
    add_background(&mut frame.planes, 90, &background);
    frame
}

#[test]
fn without_effects_the_picture_is_the_one_drawn_on_the_background() {
    let gradient = Background::Gradient { top: [0.9, 0.2, 0.1, 1.0], bottom: [0.1, 0.3, 0.8, 1.0] };
    for background in [WHITE, gradient] {
        let expected = draw(&before(background), &into_room(), &Settings::new(90, 70)).0;
        let found = composed(|_, _, _| {}, background);
        let mut edges = 0;
        for index in 0..90 * 70 {
            let planes = [&expected.planes, &found.planes];
            let [a, b] = planes.map(|p| p.linear[index]);
            assert!((0..4).all(|k| (a[k] - b[k]).abs() < 1e-6), "{index}: {a:?} {b:?}");
            let [a, b] = planes.map(|p| p.color[index]);
            assert!((0..4).all(|k| a[k].abs_diff(b[k]) <= 1), "{index}: {a:?} {b:?}");
            let [a, b] = planes.map(|p| p.color16[index]);
            assert!((0..4).all(|k| a[k].abs_diff(b[k]) <= 1), "{index}: {a:?} {b:?}");
            edges += usize::from(expected.planes.linear[index][0] > 0.26 && b[0] < 65_000);
        }
        assert!(edges > 100, "{edges}");
    }
}

/// A pixel is as bright as the background's share of it, whatever its depth says.
#[test]
fn the_background_keeps_its_light_at_edges() {
    let occlusion = AmbientOcclusion { radius: 0.5, strength: 1.0 };
    let eye_dome = EyeDome { strength: 100.0, radius: Some(3) };
    let plain = composed(|_, _, _| {}, WHITE);
    let darkened = composed(
        |frame, scene, settings| {
            occlusion.apply(frame, scene, &into_room(), settings).expect("the planes");
            eye_dome.apply(frame, scene, &into_room(), settings).expect("the planes");
        },
        WHITE,
    );
    let (mut edges, mut darker) = (0, 0);
    for (plain, darkened) in plain.planes.linear.iter().zip(&darkened.planes.linear) {
        // Grey before white: the share of white is known.
        let white = (plain[0] - 0.25) / 0.75;
        assert!(darkened[0] > white - 1e-5, "{plain:?} {darkened:?}");
        edges += usize::from(white > 0.1 && white < 0.9);
        darker += usize::from(darkened[0] < 0.8 * plain[0]);
    }
    assert!(edges > 50 && darker > 300, "{edges} {darker}");
}
