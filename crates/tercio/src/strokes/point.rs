//! Points as squares, discs and spheres.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use tercio_mesh::trig::{acos, sin_cos};

use super::eye::Eye;
use super::sheet::{Ink, Sheet};
use super::{Pen, PointShape};

/// Distance of the outline from a circle, in pixels, at most.
const ROUNDNESS: f64 = 0.12;

/// Draws a point in eye space.
pub fn draw(sheet: &mut Sheet, p: DVec3, shape: PointShape, pen: &Pen, ink: Ink) {
    let eye = sheet.eye();
    if eye.clip([p, p], 0.0).is_none() && !is_near_picture(eye, p, pen) {
        return;
    }
    let radius = 0.5 * pen.width.pixels(eye, p.z);
    match shape {
        PointShape::Square => {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            flat(sheet, p, radius, &corners.map(|(x, y)| DVec2::new(x, y)), ink);
        }
        PointShape::Round => {
            let sides = sides(radius);
            // A polygon with the area of the circle.
            let step = TAU / f64::from(sides);
            let out = (step / sin_cos(step).0).sqrt();
            let corner = |k: u32| {
                let (sin, cos) = sin_cos(step * f64::from(k));
                DVec2::new(cos, sin) * out
            };
            flat(sheet, p, radius, &(0..sides).map(corner).collect::<Vec<_>>(), ink);
        }
        PointShape::Sphere => sphere(sheet, p, radius, ink),
    }
}

/// Does a point whose middle is beside the picture reach into it?
fn is_near_picture(eye: &Eye, p: DVec3, pen: &Pen) -> bool {
    eye.clip([p, p], f64::INFINITY).is_some() && {
        let radius = 0.5 * pen.width.pixels(eye, p.z) + 1.0;
        eye.clip([p, p], radius.min(eye.size().max_element())).is_some()
    }
}

/// Corners of a regular polygon in place of a circle.
pub fn sides(radius: f64) -> u32 {
    let angle = acos(1.0 - (ROUNDNESS / radius.max(ROUNDNESS)).min(1.0));
    (PI / angle).ceil().clamp(6.0, 96.0) as u32
}

/// A convex polygon that faces the viewer, its corners clockwise on the screen. It is in front of the point by its radius, so
/// that it is whole on a surface that is less steep than 45 degrees.
fn flat(sheet: &mut Sheet, p: DVec3, radius: f64, corners: &[DVec2], ink: Ink) {
    let eye = sheet.eye();
    let ahead = p.z - radius * eye.pixel(p.z) - eye.rounding(p.z);
    let z = if p.z > 0.0 { ahead.max(p.z * 1e-3) } else { ahead };
    let (middle, nearness) = (eye.screen(p), eye.nearness(z));
    let mut add = |corner: &DVec2| sheet.vertex(middle + *corner * radius, nearness, ink);
    let numbers: Vec<u32> = corners.iter().map(&mut add).collect();
    for pair in numbers[1..].windows(2) {
        sheet.triangle([numbers[0], pair[0], pair[1]]);
    }
}

/// The half of a sphere that the viewer sees, in rings around the point next to the viewer.
fn sphere(sheet: &mut Sheet, p: DVec3, radius: f64, ink: Ink) {
    let eye = sheet.eye();
    let size = radius * eye.pixel(p.z);
    let towards = eye.to_viewer(p).normalize();
    let side = towards.any_orthonormal_vector();
    let other = towards.cross(side);
    let (sides, middle) = (sides(radius), eye.local(p));
    let rings = (sides / 4).max(2);
    let mut vertex = |ring: u32, k: u32| {
        let (sin, cos) = sin_cos(std::f64::consts::FRAC_PI_2 * f64::from(ring) / f64::from(rings));
        let (up, right) = sin_cos(TAU * f64::from(k) / f64::from(sides));
        let normal = eye.world_axes(towards * cos + (side * right + other * up) * sin);
        sheet.vertex_with_normal(middle + normal * size, normal, ink)
    };
    let top = vertex(0, 0);
    let numbers: Vec<u32> = (1..=rings)
        .flat_map(|ring| (0..sides).map(move |k| (ring, k)))
        .map(|(ring, k)| vertex(ring, k))
        .collect();
    let at = |ring: u32, k: u32| numbers[((ring - 1) * sides + k % sides) as usize];
    for k in 0..sides {
        sheet.outward([top, at(1, k), at(1, k + 1)]);
        for ring in 1..rings {
            sheet.outward([at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)]);
            sheet.outward([at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        }
    }
}
