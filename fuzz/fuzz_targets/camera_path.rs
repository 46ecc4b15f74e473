//! Keyframes of a camera, and the path through them.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tercio::glam::DVec3;
use tercio::scene::{CameraPath, Keyframe};

fuzz_target!(|bytes: &[u8]| {
    let Ok(keys) = tercio::camera_path::read(bytes) else { return };
    let full = |key: &tercio::camera_path::FileKeyframe| Keyframe {
        time: key.time,
        eye: key.eye,
        target: key.target.unwrap_or(DVec3::ZERO),
        up: key.up.unwrap_or(DVec3::Y),
        fov_y: key.fov.unwrap_or(30.0),
    };
    let Ok(path) = CameraPath::new(keys.iter().map(full).collect()) else { return };
    for key in path.keyframes() {
        assert_eq!(path.at(key.time), *key);
    }
    for time in path.times(20) {
        // Keyframes that are closer in time than numbers resolve have no finite speed; the camera is refused then.
        let fov = path.at(time).fov_y;
        assert!(!fov.is_finite() || (0.01..=179.0).contains(&fov), "{fov}");
    }
});
