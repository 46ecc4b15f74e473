//! Lines as round tubes, lit, with their true depth.
//!
//! A tube is a prism around its axis, without ends: spheres of the same diameter close it where lines end, and join it to the next
//! one. A width in pixels makes it as much thicker as it is farther away, so that it is the frustum of a cone.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use tercio_mesh::trig::sin_cos;

use super::point::sides;
use super::sheet::{Ink, Sheet};
use super::{Length, Pen};

/// Draws a tube between two points in eye space.
pub fn draw(sheet: &mut Sheet, ends: [DVec3; 2], pen: &Pen, inks: [Ink; 2]) {
    let eye = sheet.eye();
    let margin = match pen.width {
        Length::Pixels(width) => width + 2.0,
        Length::Units(_) => eye.size().max_element(),
    };
    let Some(shares) = eye.clip_shares(ends, margin) else { return };
    let at = shares.map(|share| ends[0].lerp(ends[1], share.clamp(0.0, 1.0)));
    let inks = shares.map(|share| sheet.between(inks, share));
    let axis = ends[1] - ends[0];
    let Some(axis) = axis.try_normalize() else { return };
    let viewer = eye.to_viewer(at[0]);
    let towards = viewer - axis * viewer.dot(axis);
    let towards = towards.try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
    let side = axis.cross(towards);
    let pixels = at.map(|p| 0.5 * pen.width.pixels(eye, p.z));
    let radii = [0, 1].map(|k| pixels[k] * eye.pixel(at[k].z));
    // Of a cylinder the viewer sees less than the half that faces them; a cone that points at them may be seen from all sides.
    let half = match pen.width {
        Length::Units(_) => FRAC_PI_2,
        Length::Pixels(_) => PI,
    };
    let all = sides(pixels[0].max(pixels[1])).next_multiple_of(2);
    let steps = if half < PI { all / 2 } else { all };
    let mut last = [0; 2];
    for step in 0..=steps {
        let (sin, cos) = sin_cos(half * (2.0 * f64::from(step) / f64::from(steps) - 1.0));
        let outwards = towards * cos + side * sin;
        let normal = eye.world_axes(outwards);
        let next =
            [0, 1].map(|k| sheet.vertex_with_normal(eye.local(at[k] + outwards * radii[k]), normal, inks[k]));
        if step > 0 {
            sheet.outward([last[0], next[0], next[1]]);
            sheet.outward([last[0], next[1], last[1]]);
        }
        last = next;
    }
}
