//! Arrows and other bodies along a vector, lit, with their true depth.

use std::f64::consts::TAU;

use glam::DVec3;
use tercio_mesh::trig::sin_cos;
use tercio_scene::Instance;

use super::eye::Eye;
use super::line;
use super::point::sides;
use super::sheet::{self, Ink, Sheet};
use super::{Length, Pen, colored, free, lit, plain};
use crate::data::StrokeData;
use crate::glyphs::{Glyph, Glyphs};

/// The form of a glyph. Its size is the length of its vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum GlyphShape {
    /// A shaft and a head, from the place to the end of the vector.
    #[default]
    Arrow,
    /// A line from the place to the end of the vector.
    Line,
    /// A sphere around the place, with the length as its diameter.
    Sphere,
    /// A cone from the place to the end of the vector, which is its tip.
    Cone,
}

/// Shares of an arrow's length: the radius of the shaft, that of the head, and the length of the head.
const ARROW: [f64; 3] = [0.025, 0.08, 0.28];
/// The radius of a cone's base as a share of its length.
const CONE: f64 = 0.2;

/// Glyphs as instances for the camera of `eye`; lines have the width of the pen, and all of them its colour where there are no data.
pub fn draw(eye: &Eye, glyphs: &Glyphs, pen: &Pen) -> Vec<Instance> {
    let data = glyphs.data.as_ref();
    let look = match glyphs.shape {
        GlyphShape::Line => plain(),
        _ => lit(),
    };
    let ink = |glyph: &Glyph, number: usize| match data {
        Some(StrokeData::Mapped { values, .. }) => Ink { color: pen.color, value: values[number] },
        Some(StrokeData::Direct(colors)) => colors[number].into(),
        None => glyph.color.unwrap_or(pen.color).into(),
    };
    let all: Vec<(Glyph, Ink)> =
        glyphs.list.iter().enumerate().map(|(number, glyph)| (*glyph, ink(glyph, number))).collect();
    sheet::draw(eye, &colored(look, data), &all, |sheet, (glyph, ink)| match glyphs.shape {
        GlyphShape::Line => {
            let ends = [glyph.place, glyph.place + glyph.vector].map(|p| eye.eye_space(p));
            line::draw(sheet, &free(ends), pen, [*ink; 2]);
        }
        GlyphShape::Sphere => {
            let pen = Pen { width: Length::Units(glyph.vector.length()), ..*pen };
            let middle = eye.eye_space(glyph.place);
            super::point::draw(sheet, middle, super::PointShape::Sphere, &pen, *ink);
        }
        GlyphShape::Arrow => {
            let [shaft, head, length] = ARROW;
            body(
                sheet,
                glyph,
                *ink,
                &[[0.0, 0.0], [0.0, shaft], [1.0 - length, shaft], [1.0 - length, head], [1.0, 0.0]],
            );
        }
        GlyphShape::Cone => body(sheet, glyph, *ink, &[[0.0, 0.0], [0.0, CONE], [1.0, 0.0]]),
    })
}

/// A body of revolution: places along the vector and radii, both as shares of its length.
fn body(sheet: &mut Sheet, glyph: &Glyph, ink: Ink, profile: &[[f64; 2]]) {
    let eye = sheet.eye();
    let length = glyph.vector.length();
    let axis = glyph.vector / length;
    let side = axis.any_orthonormal_vector();
    let other = axis.cross(side);
    let widest = profile.iter().map(|[_, radius]| *radius).fold(0.0, f64::max) * length;
    let z = eye.eye_space(glyph.place).z;
    // Glyphs are many: those that are small have few corners.
    let count = sides((widest / eye.pixel(z).abs().max(f64::MIN_POSITIVE)).min(1e4)).clamp(6, 48);
    let origin = eye.origin();
    let out = |k: u32| {
        let (sin, cos) = sin_cos(TAU * f64::from(k % count) / f64::from(count));
        side * cos + other * sin
    };
    for pair in profile.windows(2) {
        let [[from, inner], [to, outer]] = [pair[0], pair[1]];
        // Perpendicular to the line between both in the plane of the axis.
        let (along, outwards) = (inner - outer, to - from);
        let normal = |k: u32| (axis * along + out(k) * outwards).normalize();
        let at = |share: f64, radius: f64, k: u32| {
            (glyph.place - origin) + (axis * share + out(k) * radius) * length
        };
        let rings = [(from, inner), (to, outer)].map(|(share, radius)| {
            let first = sheet.vertex_with_normal(at(share, radius, 0), normal(0), ink);
            (1..count).for_each(|k| {
                sheet.vertex_with_normal(at(share, radius, k), normal(k), ink);
            });
            first
        });
        for k in 0..count {
            let next = (k + 1) % count;
            let [a, b, c, d] = [rings[0] + k, rings[0] + next, rings[1] + next, rings[1] + k];
            if inner > 0.0 {
                sheet.outward([a, b, c]);
            }
            if outer > 0.0 {
                sheet.outward([a, c, d]);
            }
        }
    }
}

/// Is a vector one that a glyph shows?
pub(crate) fn is_shown(vector: DVec3) -> bool {
    vector.is_finite() && vector != DVec3::ZERO
}
