//! Depth between the corners of a triangle.

use super::ScreenTriangle;

/// The depth of a triangle as a function of the screen.
#[derive(Clone, Copy, Debug)]
pub struct DepthPlane {
    /// Screen coordinates of the corner from which it is reckoned.
    pub anchor: [i32; 2],
    /// Depth there.
    pub base: f32,
    /// Growth a sub-pixel to the right.
    pub dx: f32,
    /// Growth a sub-pixel downwards.
    pub dy: f32,
    /// Depths of the corners: no sample is farther or nearer, however steep the plane.
    pub range: [f32; 2],
}

impl DepthPlane {
    /// Of a triangle with area.
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
