//! What explains a picture, as areas of a page.

use glam::DVec2;
use tercio_annotate::{Overlay, Paint};
use tercio_mesh::color::srgb_bytes;

use super::page::Shape;

/// Steps of a transition of colours, at most.
const STEPS: usize = 256;

/// The shapes of an overlay; text is outlines. Transitions of colours become stripes.
pub fn areas(overlay: &Overlay) -> Vec<Shape> {
    let mut areas = Vec::new();
    for (polygons, paint) in overlay.areas() {
        let polygons: Vec<Vec<DVec2>> = polygons
            .into_iter()
            .map(|polygon| polygon.into_iter().map(DVec2::from_array).collect())
            .collect();
        match paint {
            Paint::Solid(color) => areas.push(Shape::Area { color: bytes(*color), polygons }),
            Paint::Along { is_upright, ends: [from, to], color } => {
                let at = |k: usize| k as f64 / STEPS as f64;
                let mut last = None;
                for step in 0..STEPS {
                    let color = bytes(color(at(step) + 0.5 / STEPS as f64));
                    if last.replace(color) == Some(color) {
                        continue;
                    }
                    // To the end, so that there is no gap between stripes; the next one is drawn over it.
                    let begin = if step == 0 { f64::NEG_INFINITY } else { at(step) };
                    let inside = |p: DVec2| {
                        let place = if *is_upright { p.y } else { p.x };
                        (place - from) / (to - from) - begin
                    };
                    let polygons: Vec<_> = polygons.iter().map(|polygon| cut(polygon, inside)).collect();
                    areas.push(Shape::Area { color, polygons });
                }
            }
        }
    }
    areas
}

/// The part of a polygon in which a linear function is not negative.
fn cut(polygon: &[DVec2], inside: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::new();
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (a, b) = (inside(p), inside(q));
        if a >= 0.0 {
            kept.push(p);
        }
        if (a >= 0.0) != (b >= 0.0) {
            kept.push(p.lerp(q, a / (a - b)));
        }
    }
    kept
}

/// sRGB of linear light.
fn bytes([r, g, b, alpha]: [f32; 4]) -> [u8; 4] {
    let [r, g, b] = srgb_bytes([r, g, b]);
    [r, g, b, (f64::from(alpha).clamp(0.0, 1.0) * 255.0).round() as u8]
}
