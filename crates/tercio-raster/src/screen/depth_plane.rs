//! Interpolation of depth between the corners of a triangle.

use super::ScreenTriangle;

/// The depth of a triangle as a linear function of screen coordinates.
#[derive(Clone, Copy, Debug)]
pub struct DepthPlane {
    /// Screen coordinates of the farthest corner, from which depth is interpolated.
    pub anchor: [i32; 2],
    /// Depth of that corner.
    pub base: f32,
    /// Increment per sub-pixel to the right.
    pub dx: f32,
    /// Increment per sub-pixel downwards.
    pub dy: f32,
    /// Smallest and largest depth of the corners, to which depths of samples are clamped.
    pub range: [f32; 2],
}

impl DepthPlane {
    /// The depth plane of a triangle. Precondition: its area is not zero.
    #[inline(always)]
    pub fn new(t: &ScreenTriangle) -> Self {
        let (x1, x2) = ((t.x[1] - t.x[0]) as f32, (t.x[2] - t.x[0]) as f32);
        let (y1, y2) = ((t.y[1] - t.y[0]) as f32, (t.y[2] - t.y[0]) as f32);
        let (d1, d2) = (t.d[1] - t.d[0], t.d[2] - t.d[0]);
        let inverse = 1.0 / t.area() as f32;
        Self {
            anchor: [t.x[0], t.y[0]],
            base: t.d[0],
            dx: (d1 * y2 - d2 * y1) * inverse,
            dy: (d2 * x1 - d1 * x2) * inverse,
            range: [t.d[0], if t.d[1] > t.d[2] { t.d[1] } else { t.d[2] }],
        }
    }
}
