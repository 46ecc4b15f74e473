//! Exact binning: can a triangle cover a sample of a tile?

use super::PixelRect;
use crate::backend::edges::Edges;

/// False only if one edge leaves every sample of `rect` outside. The bounding box must have been tested
/// before; the corner regions where box and edges pass and still nothing is covered stay in.
pub fn covers_tile(edges: &Edges, rect: PixelRect) -> bool {
    (0..3).all(|k| {
        // The sample of the rectangle that lies farthest inside this edge.
        let x = if edges.a[k] > 0 { rect.x1 } else { rect.x0 };
        let y = if edges.b[k] > 0 { rect.y1 } else { rect.y0 };
        edges.at(k, x, y) >= 0
    })
}
