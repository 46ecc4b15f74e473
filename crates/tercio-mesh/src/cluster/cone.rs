//! Culling tests with the bounds of a cluster.

use super::Cluster;

impl Cluster {
    /// `cone_cutoff` of a cluster without a useful normal cone.
    pub const NO_CONE: i8 = 127;

    /// Centre of the box, computed in `f32`, and the radius of a sphere around it that contains all vertices.
    #[inline]
    pub fn sphere(&self) -> ([f32; 3], f32) {
        (std::array::from_fn(|k| middle(self.min[k], self.max[k])), self.radius)
    }

    /// True only if every triangle is back-facing for an eye in object space.
    ///
    /// Conservative for an eye that was rounded to `f32` once: if true, it holds for the eye before rounding too. It
    /// refers to exact geometry; whether a triangle keeps its facing when its corners are snapped to sub-pixels is
    /// for the caller to prove, with [`Cluster::min_height`].
    #[inline]
    pub fn faces_away(&self, eye: [f32; 3]) -> bool {
        let (along, limit) = self.cone_terms(eye);
        along > limit
    }

    /// True only if every triangle with an area is front-facing for an eye in object space; conservative in the same
    /// way as [`Cluster::faces_away`].
    #[inline]
    pub fn faces_towards(&self, eye: [f32; 3]) -> bool {
        let (along, limit) = self.cone_terms(eye);
        along < -limit
    }

    /// [`Cluster::faces_away`] for parallel projection along `direction` (from the eye into the scene, of
    /// any length).
    #[inline]
    pub fn faces_away_along(&self, direction: [f32; 3]) -> bool {
        let (along, length) = self.axis_terms(direction);
        along > length * self.slack_cutoff()
    }

    /// [`Cluster::faces_towards`] for parallel projection along `direction`.
    #[inline]
    pub fn faces_towards_along(&self, direction: [f32; 3]) -> bool {
        let (along, length) = self.axis_terms(direction);
        along < -length * self.slack_cutoff()
    }

    #[inline]
    fn cone_terms(&self, eye: [f32; 3]) -> (f32, f32) {
        let (center, radius) = self.sphere();
        let d: [f32; 3] = std::array::from_fn(|k| center[k] - eye[k]);
        let (along, length) = self.axis_terms(d);
        // An eye rounded to f32 has an error of 2^-24 of its coordinates, and of sqrt(3) times that along one
        // direction.
        let eye_error = (eye[0].abs() + eye[1].abs() + eye[2].abs()) * 1.2e-7;
        (along, length * self.slack_cutoff() + (radius + eye_error))
    }

    /// Dot product with the axis, and the length.
    #[inline]
    fn axis_terms(&self, d: [f32; 3]) -> (f32, f32) {
        let a = self.cone_axis.map(|v| f32::from(v) * (1.0 / 127.0));
        let along = d[0] * a[0] + d[1] * a[1] + d[2] * a[2];
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        (along, length)
    }

    /// The rounding errors of subtraction, products, sums and root add up to less than 16 half ulps of the distance:
    /// 1e-6 of it.
    #[inline]
    fn slack_cutoff(&self) -> f32 {
        f32::from(self.cone_cutoff) * (1.0 / 127.0) + 2e-6
    }
}

/// The centre of the box along one axis. Each bound is halved before the addition, so that it does not overflow.
#[inline]
pub(super) fn middle(min: f32, max: f32) -> f32 {
    min * 0.5 + max * 0.5
}
