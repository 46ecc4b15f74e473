//! The occlusion of 16 points, from the horizons around them.

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::pattern::{LINES, MAX_RADIUS, Row, STEPS};
use crate::lanes::{Lanes, Vec3, clamp, dot, load, minus, scaled, splat};
use crate::surface::Surface;

/// What is less than this above the tangent plane, in radii, occludes nothing: facets of a smooth surface would darken
/// each other.
const BIAS: f32 = 0.02;

/// 16 visible points.
#[derive(Clone, Copy)]
pub struct Points<S: Simd> {
    /// Where they are in the picture: to the right and upwards from its middle, in units of length at a distance of one
    /// unit for a perspective camera.
    pub at: [Lanes<S>; 2],
    pub depth: Lanes<S>,
    pub position: Vec3<S>,
    pub normal: Vec3<S>,
}

impl<S: Simd> Points<S> {
    /// The points at these pixels, counted from the upper left one, of these finite depths.
    #[inline(always)]
    pub fn new(surface: &Surface, pixels: [Lanes<S>; 2], depth: Lanes<S>, normal: Vec3<S>) -> Self {
        let at = place(surface, pixels);
        let position =
            if surface.perspective { [at[0] * depth, at[1] * depth, -depth] } else { [at[0], at[1], -depth] };
        Self { at, depth, position, normal }
    }

    /// The radius of the occlusion in pixels.
    #[inline(always)]
    pub fn radius(&self, simd: S, surface: &Surface) -> Lanes<S> {
        let scale = splat(simd, surface.scale);
        let radius = if surface.perspective { scale / self.depth } else { scale };
        clamp(simd, radius, 0.0, MAX_RADIUS)
    }
}

/// [`Points::at`] of pixels.
#[inline(always)]
pub fn place<S: Simd>(surface: &Surface, [x, y]: [Lanes<S>; 2]) -> [Lanes<S>; 2] {
    let inverse = 1.0 / surface.scale;
    [(x - (surface.middle[0] - 0.5)) * inverse, (y - (surface.middle[1] - 0.5)) * -inverse]
}

/// The surface that is seen around points.
pub trait Around<S: Simd> {
    /// The depths that are seen in one step along one side of a line, and where, as far from the points as [`Points::at`]
    /// counts.
    fn seen(&self, simd: S, line: usize, side: usize, step: usize) -> ([Lanes<S>; 2], Lanes<S>);
}

/// The share of the light of the surroundings that does not reach the points.
#[inline(always)]
pub fn occlusion<S: Simd, const PERSPECTIVE: bool>(
    simd: S,
    points: &Points<S>,
    row: &Row,
    around: &impl Around<S>,
) -> Lanes<S> {
    let to_viewer = if PERSPECTIVE {
        scaled(points.position, splat(simd, -1.0) / dot(points.position, points.position).sqrt())
    } else {
        [splat(simd, 0.0), splat(simd, 0.0), splat(simd, 1.0)]
    };
    let (mut occluded, mut all) = (splat(simd, 0.0), splat(simd, 0.0));
    for line in 0..LINES {
        let [right, up] = [load(simd, &row.lines[line][0]), load(simd, &row.lines[line][1])];
        // Perpendicular to the line of sight, in the plane of it and the line.
        let along = right * to_viewer[0] + up * to_viewer[1];
        let side = [right - to_viewer[0] * along, up - to_viewer[1] * along, -(to_viewer[2] * along)];
        let side = scaled(side, splat(simd, 1.0) / dot(side, side).sqrt());
        // The normal's part in the plane.
        let (toward, aside) = (dot(points.normal, to_viewer), dot(points.normal, side));
        let length = clamp(simd, toward * toward + aside * aside, 1e-12, 4.0).sqrt();
        let inverse = splat(simd, 1.0) / length;
        let cosine = clamp(simd, toward * inverse, 0.0, 1.0);
        let sine = clamp(simd, aside * inverse, -1.0, 1.0);
        for side in 0..2 {
            let sine = if side == 0 { sine } else { -sine };
            let tilt = Tilt { cosine, sine };
            let seen = |step| around.seen(simd, line, side, step);
            let (part, whole) = of_side::<S, PERSPECTIVE>(simd, points, to_viewer, tilt, seen);
            occluded += part * length;
            all += whole * length;
        }
    }
    clamp(simd, occluded / all, 0.0, 1.0)
}

/// The angle between the line of sight and the normal's part in a plane, positive towards the side that is looked at.
#[derive(Clone, Copy)]
struct Tilt<S: Simd> {
    cosine: Lanes<S>,
    sine: Lanes<S>,
}

/// The light that is occluded on one side of the points in the plane of a line, and all the light there. Each point that is
/// higher than those before it occludes the light between, in proportion to how near it is.
#[inline(always)]
fn of_side<S: Simd, const PERSPECTIVE: bool>(
    simd: S,
    points: &Points<S>,
    to_viewer: Vec3<S>,
    tilt: Tilt<S>,
    seen: impl Fn(usize) -> ([Lanes<S>; 2], Lanes<S>),
) -> (Lanes<S>, Lanes<S>) {
    let (none, one) = (splat(simd, 0.0), splat(simd, 1.0));
    // That of the tangent plane.
    let mut highest = -tilt.sine;
    let all = light_above(simd, highest, tilt);
    let (mut open, mut occluded) = (all, none);
    // The squared distance of the last point.
    let mut before = none;
    for step in 0..STEPS {
        let (away, depth) = seen(step);
        let [x, y] = [points.at[0] + away[0], points.at[1] + away[1]];
        let other = if PERSPECTIVE { [x * depth, y * depth, -depth] } else { [x, y, -depth] };
        let apart = minus(other, points.position);
        let square = dot(apart, apart);
        // Not where nothing is visible: infinite, or no number.
        let counts = square.simd_lt(one) & dot(apart, points.normal).simd_gt(splat(simd, BIAS));
        // As most do on a surface that is convex, or plane.
        if counts.all_false() {
            before = square;
            continue;
        }
        let toward = if PERSPECTIVE { dot(apart, to_viewer) } else { apart[2] };
        let horizon = toward / square.sqrt();
        let rises = counts & horizon.simd_gt(highest);
        if rises.all_false() {
            before = square;
            continue;
        }
        let left = light_above(simd, horizon, tilt);
        // What is between two points is hit between them.
        let nearer = before.simd_lt(square).select(before, square);
        let more = (open - left) * (one - (nearer + square) * 0.5);
        occluded = rises.select(occluded + more, occluded);
        open = rises.select(left, open);
        highest = rises.select(horizon, highest);
        before = square;
    }
    (occluded, all)
}

/// The light that enters between the line of sight and a horizon at an angle h to it, given as its cosine c, weighted by its
/// cosine with a normal in the plane: twice the integral of sin(t) cos(t - n) from 0 to h. That is
/// cos(n) (1 - c^2) + sin(n) (h - c sqrt(1 - c^2)); the last factor is pi/2 less twice the integral of sqrt(1 - t^2) from 0
/// to c, here a polynomial that is off by at most 1.1e-3.
#[inline(always)]
fn light_above<S: Simd>(simd: S, cosine: Lanes<S>, tilt: Tilt<S>) -> Lanes<S> {
    let square = cosine * cosine;
    let upper = square * -0.180_654_14 + 0.160_158_28;
    let polynomial = upper * (square * square) + (square * -0.415_911_24 + 2.008_260_2);
    let beyond = splat(simd, std::f32::consts::FRAC_PI_2) - cosine * polynomial;
    tilt.cosine * (splat(simd, 1.0) - square) + tilt.sine * beyond
}

#[cfg(test)]
mod tests {
    use tercio_raster::SimdLevel;
    use tercio_raster::dispatch;

    use super::*;
    use crate::lanes::LANES;

    #[test]
    fn the_light_above_a_horizon_is_its_integral() {
        let level = SimdLevel::best().level().expect("available");
        for tilt in [-1.2f64, -0.3, 0.0, 0.7, 1.5] {
            for first in 0..8 {
                let cosines: [f32; LANES] =
                    std::array::from_fn(|lane| (first * LANES + lane) as f32 / 63.5 - 1.0);
                let found = dispatch!(level, simd => {
                    let tilt = Tilt { cosine: splat(simd, tilt.cos() as f32), sine: splat(simd, tilt.sin() as f32) };
                    light_above(simd, load(simd, &cosines), tilt).to_array()
                });
                for (cosine, found) in cosines.into_iter().zip(found) {
                    let h = f64::from(cosine).clamp(-1.0, 1.0).acos();
                    let steps = 2000;
                    let at = |k: usize| h * (k as f64 + 0.5) / steps as f64;
                    let sum: f64 = (0..steps).map(|k| at(k).sin() * (at(k) - tilt).cos()).sum();
                    let expected = 2.0 * sum * h / steps as f64;
                    assert!(
                        (f64::from(found) - expected).abs() < 1.2e-3,
                        "{tilt} {cosine}: {found} {expected}"
                    );
                }
            }
        }
    }
}
