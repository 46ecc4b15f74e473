use super::*;
use crate::Projection;

fn key(time: f64, eye: DVec3) -> Keyframe {
    Keyframe { time, eye, target: DVec3::ZERO, up: DVec3::Y, fov_y: 30.0 }
}

#[test]
fn a_turn_keeps_distance_and_height_and_ends_where_it_began() {
    let projection = Projection::Perspective { fov_y: 0.5 };
    let camera = Camera {
        eye: DVec3::new(3.0, 2.0, 1.0),
        target: DVec3::new(0.5, 0.25, -1.0),
        up: DVec3::new(0.1, 1.0, 0.0),
        projection,
        near: None,
        shift: [0.0; 2],
    };
    for degrees in [10.0, 77.7, 359.0] {
        let turned = camera.turned(DVec3::Y, degrees);
        let (before, after) = (camera.eye - camera.target, turned.eye - turned.target);
        assert!((before.length() - after.length()).abs() < 1e-12);
        assert!((before.y - after.y).abs() < 1e-12 && (camera.up.y - turned.up.y).abs() < 1e-12);
        // A closed formula: the angle between the horizontal parts, counted from +z towards +x.
        let angle = |v: DVec3| v.x.atan2(v.z).to_degrees();
        assert!(((angle(after) - angle(before) - degrees).rem_euclid(360.0) + 1e-9) % 360.0 < 2e-9);
    }
    // Exact, where coordinates are.
    assert_eq!(camera.turned(DVec3::Y, 360.0), camera);
    let quarter = camera.turned(DVec3::Y, 90.0);
    assert_eq!(quarter.eye - camera.target, DVec3::new(2.0, 1.75, -2.5));
}

#[test]
fn a_path_through_points_of_a_parabola_is_that_parabola() {
    let parabola = |t: f64| DVec3::new(1.0 + 2.0 * t - 0.5 * t * t, t * t, 7.0 - t);
    let keys = [0.0, 0.5, 2.0, 2.25, 4.0].map(|t| key(t, parabola(t)));
    let path = CameraPath::new(keys.to_vec()).unwrap();
    for step in 0..=400 {
        let t = f64::from(step) / 100.0;
        assert!(path.at(t).eye.distance(parabola(t)) < 1e-12, "{t}");
    }
    assert!(!path.is_closed());
    assert_eq!((path.at(-1.0).eye, path.at(9.0).eye), (parabola(0.0), parabola(4.0)));
}

#[test]
fn a_path_passes_its_keyframes_exactly_and_without_a_jump_of_speed() {
    let points = [[0.0, 0.0, 0.0], [1.0, 3.0, 0.1], [2.0, -1.0, 0.3], [0.1, 0.2, 5.0], [0.0, 0.0, 0.0]];
    let times = [0.0, 1.0, 1.5, 4.0, 4.5];
    let keys: Vec<_> = times.iter().zip(points).map(|(&t, p)| key(t, p.into())).collect();
    let path = CameraPath::new(keys.clone()).unwrap();
    assert!(path.is_closed());
    keys.iter().for_each(|k| assert_eq!(path.at(k.time), *k));
    let speed = |from: f64, to: f64| (path.at(to).eye - path.at(from).eye) / (to - from);
    let h = 1e-6;
    for &t in &times[1..4] {
        assert!(speed(t - h, t).distance(speed(t, t + h)) < 1e-4, "at {t}");
    }
    assert!(speed(0.0, h).distance(speed(4.5 - h, 4.5)) < 1e-4, "from the end to the beginning");
}

#[test]
fn two_keyframes_are_a_straight_line_and_angles_do_not_overshoot() {
    let [mut a, mut b] = [key(1.0, DVec3::X), key(3.0, DVec3::Y)];
    (a.fov_y, b.fov_y) = (20.0, 60.0);
    let path = CameraPath::new(vec![a, b]).unwrap();
    let middle = path.at(2.0);
    assert!(middle.eye.distance(DVec3::new(0.5, 0.5, 0.0)) < 1e-15 && (middle.fov_y - 40.0).abs() < 1e-12);
    let angles = [1.0, 1.0, 179.0, 179.0];
    let keys = angles.iter().zip(0..).map(|(&fov_y, t)| Keyframe { fov_y, ..key(f64::from(t), DVec3::X) });
    let path = CameraPath::new(keys.collect()).unwrap();
    assert!(path.times(301).all(|t| (1.0..=179.0).contains(&path.at(t).fov_y)));
}

#[test]
fn frames_of_a_closed_path_do_not_repeat_the_first_one() {
    let open = CameraPath::new(vec![key(0.0, DVec3::X), key(2.0, DVec3::Y), key(4.0, DVec3::Z)]).unwrap();
    assert_eq!(open.times(5).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(open.times(1).collect::<Vec<_>>(), [0.0]);
    assert_eq!(open.times(0).count(), 0);
    let closed = CameraPath::new(vec![key(0.0, DVec3::X), key(2.0, DVec3::Y), key(4.0, DVec3::X)]).unwrap();
    assert_eq!(closed.times(4).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(closed.duration(), 4.0);
}

#[test]
fn what_is_no_path_is_named() {
    let (a, b) = (key(0.0, DVec3::X), key(1.0, DVec3::Y));
    assert_eq!(CameraPath::new(vec![a]), Err(PathError::TooFew(1)));
    assert_eq!(CameraPath::new(vec![]), Err(PathError::TooFew(0)));
    assert_eq!(CameraPath::new(vec![a, Keyframe { fov_y: f64::NAN, ..b }]), Err(PathError::NotFinite(2)));
    let not_after = Err(PathError::NotAfter { number: 3, time: 1.0, before: 1.0 });
    assert_eq!(CameraPath::new(vec![a, b, b]), not_after);
}
