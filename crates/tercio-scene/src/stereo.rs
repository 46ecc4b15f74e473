//! Two eyes beside each other: the cameras of a stereo pair.
//!
//! The lines of sight are parallel, and the image planes are moved in themselves until both show the same part of the
//! plane of zero parallax. So a point has the same height in both pictures. Cameras that are turned towards each other
//! ("toe-in") show a rectangle as two different trapezoids, and eyes cannot fuse points of different heights.
//!
//! A point at distance z along the line of sight is seen by the left eye farther to the right than by the right eye, by
//!
//! > scale * eye distance * (1 / z - 1 / convergence)
//!
//! pixels, with the pixels per unit of the tangent of the viewing angle as `scale`: nothing at the distance of the
//! convergence, where a viewer sees the surface of the display; nearer points are in front of it, farther ones behind.
//!
//! Lights that move with the camera move with each eye. Directional ones are then the same for both; points and spots are
//! half of the eye distance to the side.
//!
//! Sources: Woods, Docherty and Koch, "Image distortions in stereoscopic video systems", Proc. SPIE 1915 (1993), for
//! parallel against converging cameras; the thirtieth is the rule of thumb of stereo photography.

use tercio_mesh::trig;

use crate::camera::{Camera, CameraError, Projection};

/// The default eye distance is the convergence divided by this.
const CONVERGENCE_PER_EYE_DISTANCE: f64 = 30.0;

/// How a stereo pair is placed around a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereo {
    /// Distance of the eyes from each other, world units; at least 0.
    pub eye_distance: f64,
    /// Distance of the plane of zero parallax along the line of sight, world units; above 0.
    pub convergence: f64,
}

impl Stereo {
    /// Zero parallax in the plane through the camera's target, and a thirtieth of its distance between the eyes.
    pub fn for_camera(camera: &Camera) -> Self {
        Self::at(camera.eye.distance(camera.target))
    }

    /// Zero parallax at a distance along the line of sight, and a thirtieth of it between the eyes.
    pub fn at(convergence: f64) -> Self {
        Self { eye_distance: convergence / CONVERGENCE_PER_EYE_DISTANCE, convergence }
    }

    /// The cameras of the left and the right eye, half of the eye distance to either side of `camera`. Both show what
    /// `camera` shows of the plane of zero parallax.
    ///
    /// # Errors
    /// [`CameraError::NoStereo`] for an orthographic camera; [`CameraError::OutOfRange`] for an eye distance or a
    /// convergence that is out of range; errors of [`Camera::basis`]. A shift that is finite, but larger than the
    /// renderer can draw, is found by the renderer.
    pub fn cameras(&self, camera: &Camera) -> Result<[Camera; 2], CameraError> {
        let basis = camera.basis()?;
        let Projection::Perspective { fov_y } = camera.projection else { return Err(CameraError::NoStereo) };
        let out_of_range = |what, range, value| Err(CameraError::OutOfRange { what, range, value });
        if !(self.eye_distance >= 0.0 && self.eye_distance.is_finite()) {
            return out_of_range("distance of the eyes", "0 or more and finite", self.eye_distance);
        }
        if !(self.convergence > 0.0 && self.convergence.is_finite()) {
            return out_of_range("distance of zero parallax", "above 0 and finite", self.convergence);
        }
        let (sin, cos) = trig::sin_cos(fov_y * 0.5);
        let half = 0.5 * self.eye_distance;
        // Half of the eye distance at the convergence, in heights of the picture.
        let shift = half / self.convergence * cos / (2.0 * sin);
        // The left eye's line of sight is to the left of what both see in the middle.
        Ok([-1.0, 1.0].map(|side| {
            let aside = basis.right * (side * half);
            Camera {
                eye: camera.eye + aside,
                target: camera.target + aside,
                shift: [camera.shift[0] + side * shift, camera.shift[1]],
                ..*camera
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn camera() -> Camera {
        Camera {
            eye: DVec3::new(1.0, 2.0, 10.0),
            target: DVec3::new(1.5, 1.0, 2.0),
            up: DVec3::new(0.1, 1.0, 0.0),
            projection: Projection::Perspective { fov_y: 0.7 },
            near: Some(0.5),
            shift: [0.0; 2],
        }
    }

    /// Where a point is in the picture, in heights of the picture to the right of its centre and above it.
    fn seen(camera: &Camera, point: DVec3) -> [f64; 2] {
        let basis = camera.basis().expect("a camera");
        let Projection::Perspective { fov_y } = camera.projection else { panic!("a perspective camera") };
        let away = point - camera.eye;
        let scale = 0.5 / (fov_y * 0.5).tan() / away.dot(basis.forward);
        [away.dot(basis.right) * scale + camera.shift[0], away.dot(basis.up) * scale + camera.shift[1]]
    }

    #[test]
    fn parallax_follows_the_formula() {
        let stereo = Stereo { eye_distance: 0.3, convergence: 6.0 };
        let middle = camera();
        let [left, right] = stereo.cameras(&middle).expect("two cameras");
        let basis = middle.basis().expect("a camera");
        assert!((right.eye - left.eye - basis.right * 0.3).length() < 1e-12);
        for distance in [0.6, 3.0, 6.0, 9.0, 1e6] {
            for aside in [-1.3, 0.0, 0.8] {
                let across = basis.right * (aside * distance) + basis.up * (0.4 * distance);
                let point = middle.eye + basis.forward * distance + across;
                let [l, r] = [&left, &right].map(|camera| seen(camera, point));
                let scale = 0.5 / (0.35f64).tan();
                let parallax = scale * 0.3 * (1.0 / distance - 1.0 / 6.0);
                assert!((l[0] - r[0] - parallax).abs() < 1e-9, "{distance}: {l:?} {r:?} {parallax}");
                assert!((l[1] - r[1]).abs() < 1e-9, "the same height");
                if distance == 6.0 {
                    let alone = seen(&middle, point);
                    assert!((l[0] - alone[0]).abs() < 1e-9, "what one eye between them sees");
                }
            }
        }
    }

    #[test]
    fn without_a_distance_both_eyes_are_the_camera() {
        let stereo = Stereo { eye_distance: 0.0, convergence: 3.0 };
        assert_eq!(stereo.cameras(&camera()), Ok([camera(); 2]));
    }

    #[test]
    fn the_defaults_follow_from_the_target() {
        let stereo = Stereo::for_camera(&camera());
        let distance = camera().eye.distance(camera().target);
        assert_eq!(stereo, Stereo { eye_distance: distance / 30.0, convergence: distance });
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        let parallel = Camera { projection: Projection::Orthographic { height: 2.0 }, ..camera() };
        assert_eq!(Stereo::for_camera(&parallel).cameras(&parallel), Err(CameraError::NoStereo));
        for (eye_distance, convergence) in
            [(-1.0, 1.0), (f64::NAN, 1.0), (1.0, 0.0), (1.0, -2.0), (1.0, f64::INFINITY)]
        {
            let pair = Stereo { eye_distance, convergence }.cameras(&camera());
            assert!(matches!(pair, Err(CameraError::OutOfRange { .. })), "{eye_distance} {convergence}");
        }
        let far = Stereo { eye_distance: 1e300, convergence: 1e-300 }.cameras(&camera()).expect("cameras");
        assert!(matches!(far[0].basis(), Err(CameraError::OutOfRange { what: "shift", .. })));
    }
}
