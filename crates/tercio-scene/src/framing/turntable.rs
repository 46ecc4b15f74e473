//! Framing of a model round which the camera turns.

use glam::DVec3;
use tercio_mesh::trig;

use super::Framing;
use crate::Camera;

/// Directions round the axis in which a model is measured: between two of them it reaches farther by half a percent at most.
const DIRECTIONS: u32 = 32;

impl Framing {
    /// The largest `direction . (p - center)` of all points `p` that are seen: of the model, or of the body that it sweeps when
    /// it turns round the up axis, if the camera turns round it. `reach` is that of the model.
    pub(super) fn reach_of_seen(&self, direction: DVec3, reach: impl Fn(DVec3) -> f64) -> f64 {
        if !self.all_round {
            return reach(direction);
        }
        let front = self.up_axis.front();
        let up = direction.dot(front.up);
        let across = (direction - front.up * up).length();
        let at = |number: u32| {
            let (sin, cos) = trig::sin_cos_degrees(360.0 * f64::from(number) / f64::from(DIRECTIONS));
            reach((front.right * cos + front.forward * sin) * across + front.up * up)
        };
        // Along the axis, all directions are the same one.
        (0..if across > 0.0 { DIRECTIONS } else { 1 }).map(at).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The same view of a camera that looks at the axis through `center`, if it turns round it: the target is moved along the
    /// line of sight.
    pub(super) fn aimed(&self, camera: Camera, center: DVec3) -> Camera {
        if !self.all_round {
            return camera;
        }
        let up = self.up_axis.front().up;
        let across = |v: DVec3| v - up * v.dot(up);
        let (off, sight) = (across(camera.target - center), across(camera.target - camera.eye));
        // Where the line of sight is parallel to the axis, it is the axis.
        let share = if sight.length_squared() > 0.0 { off.dot(sight) / sight.length_squared() } else { 0.0 };
        let target = camera.target - (camera.target - camera.eye) * share;
        Camera { target: target - across(target - center), ..camera }
    }
}
