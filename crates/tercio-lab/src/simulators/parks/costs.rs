//! Costs of scan conversion on a PDP-11 (document 002, section 2.2).

use super::ProcessorRun;
use crate::models::parks::costs;

/// Memory cycles of one processor; multiplications and divisions count as ten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// G_t: a polygon.
    pub polygon: f64,
    /// V_t: a vertex of a polygon.
    pub vertex: f64,
    /// S_t: a segment, which is a scan line of a polygon.
    pub segment: f64,
    /// P_t: a pixel of a segment.
    pub pixel: f64,
}

impl Costs {
    /// Section 2.2: G_t = 42 + 97 (lost in the printed summary, 139 in appendix C), V_t = 24.6 + 25 + 257.2 + 12.5,
    /// S_t = 85 + 15 + 58, P_t = 21.
    pub fn pdp11() -> Self {
        Self {
            polygon: costs::POLYGON.get(),
            vertex: costs::VERTEX.get(),
            segment: costs::SEGMENT.get(),
            pixel: costs::PIXEL.get(),
        }
    }

    /// Memory cycles of counted work: N G_t + V V_t + S S_t + P P_t.
    pub fn cycles(&self, polygons: u64, vertices: u64, segments: u64, pixels: u64) -> f64 {
        polygons as f64 * self.polygon
            + vertices as f64 * self.vertex
            + segments as f64 * self.segment
            + pixels as f64 * self.pixel
    }

    /// Memory cycles of a processor. A polygon without a line on the processor is still charged one segment: the
    /// document does not say so, but four totals of its appendix C (3, 6, 7 and 8) require it.
    pub fn total(&self, run: &ProcessorRun) -> f64 {
        self.cycles(run.polygons(), run.vertices(), run.charged_segments(), run.pixels())
    }
}
