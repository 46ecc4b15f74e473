use tercio_raster::{Outputs, Renderer, Settings};
use tercio_scene::{Background, Scene, Stereo};

use super::*;

/// A frame of colours.
fn frame(width: u32, colors: &[[u8; 4]]) -> Frame {
    let planes = Planes { color: colors.to_vec(), ..Planes::default() };
    Frame { width, height: colors.len() as u32 / width, planes, ..Frame::default() }
}

/// A frame with numbers as colours.
fn numbered(from: u8) -> Frame {
    let colors: Vec<_> = (from..from + 6).map(|n| [n, 0, 0, 255]).collect();
    frame(3, &colors)
}

fn reds(frame: &Frame) -> Vec<u8> {
    frame.planes.color.iter().map(|color| color[0]).collect()
}

#[test]
fn the_left_eye_is_on_the_left_and_on_top() {
    let (left, right) = (numbered(0), numbered(10));
    let beside = side_by_side(&left, &right).expect("a frame");
    assert_eq!((beside.width, beside.height), (6, 2));
    assert_eq!(reds(&beside), [0, 1, 2, 10, 11, 12, 3, 4, 5, 13, 14, 15]);
    let above = over_under(&left, &right).expect("a frame");
    assert_eq!((above.width, above.height), (3, 4));
    assert_eq!(reds(&above), [0, 1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 15]);
}

#[test]
fn frames_of_different_sizes_are_refused() {
    let (left, right) = (numbered(0), frame(2, &numbered(10).planes.color));
    for join in [side_by_side, over_under, anaglyph] {
        let error = join(&left, &right).expect_err("two sizes");
        assert!(matches!(error, ImageError::SizesDiffer([3, 2], [2, 3])), "{error}");
    }
    // Nothing of nothing.
    for join in [side_by_side, over_under, anaglyph] {
        assert!(join(&Frame::default(), &Frame::default()).is_ok());
    }
}

/// sRGB level of linear light.
fn level(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn of_one_pixel(left: [u8; 4], right: [u8; 4]) -> [u8; 4] {
    anaglyph(&frame(1, &[left]), &frame(1, &[right])).expect("a frame").planes.color[0]
}

#[test]
fn an_anaglyph_has_the_published_colours() {
    let (black, white) = ([0, 0, 0, 255], [255; 4]);
    assert_eq!(of_one_pixel(black, black), black);
    assert_eq!(of_one_pixel(white, white), white);
    // What only the left eye sees is nearly pure red, of full brightness; for the right eye the other two.
    assert_eq!(of_one_pixel(white, black), [255, 0, 0, 255]);
    assert_eq!(of_one_pixel(black, white), [0, 255, 255, 255]);
    // The columns of the matrices, by primary colours.
    let near = |found: [u8; 4], linear: [f64; 3]| {
        let close = (0..3).all(|k| (f64::from(found[k]) - level(linear[k])).abs() <= 0.56);
        assert!(close && found[3] == 255, "{found:?}, not {linear:?}");
    };
    near(of_one_pixel([255, 0, 0, 255], black), [0.4561, -0.040_082_2, -0.015_216_1]);
    near(of_one_pixel([0, 255, 0, 255], black), [0.500_484, -0.037_824_6, -0.020_597_1]);
    near(of_one_pixel([0, 0, 255, 255], black), [0.176_381, -0.015_758_9, -0.005_468_56]);
    near(of_one_pixel(black, [255, 0, 0, 255]), [-0.043_470_6, 0.378_476, -0.072_152_7]);
    near(of_one_pixel(black, [0, 255, 0, 255]), [-0.087_938_8, 0.733_64, -0.112_961]);
    near(of_one_pixel(black, [0, 0, 255, 255]), [-0.001_555_29, -0.018_450_3, 1.226_4]);
    // In linear light: level 128 is 0.21586, not a half.
    let half = 0.215_860_5;
    near(of_one_pixel([128, 128, 128, 255], black), [half * 1.132_965, 0.0, 0.0]);
    near(of_one_pixel(black, [128, 128, 128, 255]), [0.0, half * 1.093_665_7, half * 1.041_286_3]);
    near(of_one_pixel([255, 0, 0, 255], [0, 0, 255, 255]), [0.454_544_7, -0.058_5, 1.211_183_9]);
}

#[test]
fn greys_that_both_eyes_see_stay() {
    for grey in 0..=255 {
        let color = [grey, grey, grey, 255];
        assert_eq!(of_one_pixel(color, color), color);
    }
    let deep = |grey: u16| {
        let planes = Planes { color16: vec![[grey, grey, grey, 65535]], ..Planes::default() };
        Frame { width: 1, height: 1, planes, ..Frame::default() }
    };
    for grey in (0..=u16::MAX).step_by(251) {
        let found = anaglyph(&deep(grey), &deep(grey)).expect("a frame").planes.color16[0];
        // The published rows add up to 1 with an error of 5e-6.
        assert!(
            found[..3].iter().all(|level| level.abs_diff(grey) <= 1) && found[3] == 65535,
            "{grey}: {found:?}"
        );
    }
}

#[test]
fn what_is_transparent_counts_as_black() {
    assert_eq!(of_one_pixel([9, 9, 9, 0], [9, 9, 9, 0])[3], 0);
    assert_eq!(of_one_pixel([255; 4], [255, 255, 255, 0]), [255, 0, 0, 255]);
    assert_eq!(of_one_pixel([255, 255, 255, 0], [255; 4]), [0, 255, 255, 255]);
    assert_eq!(of_one_pixel([200, 200, 200, 128], [200, 200, 200, 128]), [200, 200, 200, 128]);
}

/// All planes of drawn frames, and the counts of both.
#[test]
fn drawn_frames_are_joined() {
    let mut scene = Scene::from_mesh(crate::load("builtin:teapot@1k").expect("a model").mesh);
    scene.background = Background::Solid([0.2, 0.2, 0.2, 1.0]);
    let settings = Settings { outputs: Outputs::ALL, ..Settings::new(40, 30) };
    let camera = settings.framing().camera_for_scene(&scene);
    let cameras = Stereo::for_camera(&camera).cameras(&camera).expect("two cameras");
    let [left, right] =
        cameras.map(|eye| Renderer::new().render(&scene, &eye, &settings).expect("a picture"));
    assert!(left.difference(&right).is_some(), "the eyes see the same");
    let above = over_under(&left, &right).expect("a frame");
    let beside = side_by_side(&left, &right).expect("a frame");
    for y in 0..30 {
        for x in 0..40 {
            let at = y * 40 + x;
            for (eye, from_above, from_side) in
                [(&left, at, y * 80 + x), (&right, at + 1200, y * 80 + x + 40)]
            {
                assert_eq!(eye.planes.depth[at], above.planes.depth[from_above]);
                assert_eq!(eye.planes.normals[at], above.planes.normals[from_above]);
                assert_eq!(eye.planes.color16[at], beside.planes.color16[from_side]);
                assert_eq!(eye.planes.ids[at], beside.planes.ids[from_side]);
            }
        }
    }
    let visible = left.stats.backend.pixels_visible + right.stats.backend.pixels_visible;
    let glasses = anaglyph(&left, &right).expect("a frame");
    for frame in [&above, &beside, &glasses] {
        assert_eq!(frame.stats.backend.pixels_visible, visible);
    }
    assert_eq!((glasses.planes.color.len(), glasses.planes.color16.len()), (1200, 1200));
    assert!(glasses.planes.depth.is_empty() && glasses.planes.ids.is_empty());
}
