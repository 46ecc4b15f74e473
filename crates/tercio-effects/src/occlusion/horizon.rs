//! The occlusion of single points, from the horizons around them.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16, i32x16};
use rayon::prelude::*;
use tercio_mesh::trig::sin_cos;

use crate::lanes::{LANES, Lanes, Vec3, arc_cosine, clamp, dot, load, minus, scaled, splat};
use crate::surface::Surface;

/// Lines through each point.
const LINES: usize = 2;
/// Points that are looked at on each side of a line.
const STEPS: usize = 5;
/// Pixels along the edge of the pattern in which the directions of the lines alternate.
pub const PATTERN: usize = 4;
/// What is less than this above the tangent plane, in radii, occludes nothing: facets of a smooth surface would darken
/// each other.
const BIAS: f32 = 0.02;
/// The largest number of pixels in a radius.
const MAX_RADIUS: f32 = 512.0;
/// Points on a line are at least this many pixels apart from the middle.
const MIN_DISTANCE: f32 = 1.5;

/// Pixels that the coarse planes have beyond the picture, on each side.
pub const MARGIN: usize = 4;

/// The directions and distances of one row of the pattern, by lane.
struct Row {
    /// Cosine and sine of the angle of each line.
    lines: [[[f32; LANES]; 2]; LINES],
    /// Distances along a line, in radii.
    steps: [[f32; LANES]; STEPS],
}

/// What an ordered pattern of 16 numbers has at a pixel: each of 0 to 15 once.
fn order(x: usize, y: usize) -> usize {
    const BAYER: [[usize; PATTERN]; PATTERN] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    BAYER[y % PATTERN][x % PATTERN]
}

fn rows() -> [Row; PATTERN] {
    let share = |x: usize, y: usize| (order(x, y) as f64 + 0.5) / (PATTERN * PATTERN) as f64;
    std::array::from_fn(|y| {
        let angle = |line: usize, x: usize| {
            sin_cos((line as f64 + share(x, y)) * std::f64::consts::PI / LINES as f64)
        };
        let step = |step: usize, x: usize| {
            // Another order than that of the directions.
            let part = (step as f64 + share(x + 2 * y + 1, x + y / 2)) / STEPS as f64;
            part as f32
        };
        Row {
            lines: std::array::from_fn(|l| {
                [std::array::from_fn(|x| angle(l, x).1 as f32), std::array::from_fn(|x| angle(l, x).0 as f32)]
            }),
            steps: std::array::from_fn(|s| std::array::from_fn(|x| step(s, x))),
        }
    })
}

/// The occlusion of every second pixel of every second row: pixels (2x, 2y) of the picture.
pub struct Horizons<'a> {
    /// The visible points; lengths are in radii of the occlusion.
    pub surface: &'a Surface,
    /// Unit normals in world space.
    pub normals: &'a [[f32; 3]],
    rows: [Row; PATTERN],
    /// Length of a row of the coarse planes, with margins. They have every number twice, so that those of neighbouring pixels
    /// lie in a row.
    pub stride: usize,
    /// Coarse pixels across and down.
    size: [usize; 2],
    /// Depths of the coarse pixels, with margins in which nothing is visible.
    pub depth: Vec<f32>,
    /// The share of the light of the surroundings that does not reach them.
    pub occlusion: Vec<f32>,
}

/// 16 visible points.
struct Points<S: Simd> {
    /// Pixels, from the upper left one.
    x: Lanes<S>,
    y: Lanes<S>,
    position: Vec3<S>,
    normal: Vec3<S>,
    /// Unit vectors.
    to_viewer: Vec3<S>,
    /// The occlusion's radius, in pixels.
    radius: Lanes<S>,
}

/// One side of a line through 16 points.
struct Side<S: Simd> {
    /// Its direction in the picture: to the right and upwards.
    direction: [Lanes<S>; 2],
    /// Of the angle between the line of sight and the normal's part in the plane, positive towards this side.
    cosine: Lanes<S>,
    sine: Lanes<S>,
}

impl<'a> Horizons<'a> {
    /// Computes the occlusion of the coarse pixels.
    pub fn new(surface: &'a Surface, normals: &'a [[f32; 3]], level: Level) -> Self {
        let size = [surface.width.div_ceil(2), surface.height.div_ceil(2)];
        let stride = 2 * (size[0].next_multiple_of(LANES) + 2 * MARGIN);
        let length = stride * (size[1] + 2 * MARGIN);
        let mut depth = vec![f32::INFINITY; length];
        let lines =
            depth.par_chunks_mut(stride).skip(MARGIN).zip(surface.depth.par_chunks(2 * surface.width));
        lines.with_min_len(16).for_each(|(to, from)| {
            let even = from[..surface.width].iter().step_by(2);
            to[2 * MARGIN..]
                .as_chunks_mut::<2>()
                .0
                .iter_mut()
                .zip(even)
                .for_each(|(to, from)| *to = [*from; 2]);
        });
        let mut new = Self { surface, normals, rows: rows(), stride, size, depth, occlusion: Vec::new() };
        let mut occlusion = vec![0.0; length];
        let lines = occlusion.par_chunks_mut(stride).skip(MARGIN).take(size[1]).enumerate();
        lines.for_each(|(y, to)| {
            for x in (0..size[0]).step_by(LANES) {
                let first = 2 * (x + MARGIN);
                let at = (y + MARGIN) * stride + first;
                if new.depth[at..at + 2 * LANES].iter().any(|d| d.is_finite()) {
                    let pixels = std::array::from_fn(|i| [2 * (x + i), 2 * y]);
                    let found = new.of_pixels(&pixels, y % PATTERN, level);
                    let to = to[first..].as_chunks_mut::<2>().0;
                    to.iter_mut().zip(found).for_each(|(to, found)| *to = [found; 2]);
                }
            }
        });
        new.occlusion = occlusion;
        new
    }

    /// The occlusion of 16 pixels, given from the upper left one; 0 of those outside the picture or where nothing is
    /// visible. The lane and the row of the pattern select the directions.
    pub fn of_pixels(&self, pixels: &[[usize; 2]; LANES], row: usize, level: Level) -> [f32; LANES] {
        let surface = self.surface;
        let (mut depth, mut normals) = ([f32::INFINITY; LANES], [[0.0; LANES]; 3]);
        for (lane, &[x, y]) in pixels.iter().enumerate() {
            if x < surface.width && y < surface.height {
                let index = y * surface.width + x;
                depth[lane] = surface.depth[index];
                let normal = surface.to_camera(self.normals[index]);
                (0..3).for_each(|k| normals[k][lane] = normal[k]);
            }
        }
        let mut places = [[0.0; LANES]; 2];
        for (lane, &[x, y]) in pixels.iter().enumerate() {
            (places[0][lane], places[1][lane]) = (x as f32, y as f32);
        }
        dispatch!(level, simd => self.of_lanes(simd, &places, &depth, &normals, row).to_array())
    }

    #[inline(always)]
    fn of_lanes<S: Simd>(
        &self,
        simd: S,
        places: &[[f32; LANES]; 2],
        depth: &[f32; LANES],
        normals: &[[f32; LANES]; 3],
        row: usize,
    ) -> Lanes<S> {
        let depth = load(simd, depth);
        let is_visible = depth.simd_lt(splat(simd, f32::INFINITY));
        let depth = is_visible.select(depth, splat(simd, 1.0));
        let normal = [load(simd, &normals[0]), load(simd, &normals[1]), load(simd, &normals[2])];
        let [x, y] = [load(simd, &places[0]), load(simd, &places[1])];
        let position = self.position(simd, x, y, depth);
        let (to_viewer, radius) = if self.surface.perspective {
            let inverse = splat(simd, -1.0) / dot(position, position).sqrt();
            (scaled(position, inverse), splat(simd, self.surface.scale) / depth)
        } else {
            let none = splat(simd, 0.0);
            ([none, none, splat(simd, 1.0)], splat(simd, self.surface.scale))
        };
        let radius = clamp(simd, radius, 0.0, MAX_RADIUS);
        let points = Points { x, y, position, normal, to_viewer, radius };
        let (mut occluded, mut all) = (splat(simd, 0.0), splat(simd, 0.0));
        let row = &self.rows[row];
        for [right, up] in &row.lines {
            let (part, whole) = self.of_line(simd, &points, [load(simd, right), load(simd, up)], &row.steps);
            occluded += part;
            all += whole;
        }
        let share = clamp(simd, occluded / all, 0.0, 1.0);
        is_visible.select(share, splat(simd, 0.0))
    }

    /// The point at the middle of a pixel, at this distance.
    #[inline(always)]
    pub fn position<S: Simd>(&self, simd: S, x: Lanes<S>, y: Lanes<S>, depth: Lanes<S>) -> Vec3<S> {
        let Surface { perspective, scale, middle, .. } = self.surface;
        let to_side = if *perspective { depth * (1.0 / scale) } else { splat(simd, 1.0 / scale) };
        [(x - (middle[0] - 0.5)) * to_side, (splat(simd, middle[1] - 0.5) - y) * to_side, -depth]
    }

    /// The light that is occluded in the plane of a line and the line of sight, and all the light there.
    #[inline(always)]
    fn of_line<S: Simd>(
        &self,
        simd: S,
        points: &Points<S>,
        [right, up]: [Lanes<S>; 2],
        steps: &[[f32; LANES]; STEPS],
    ) -> (Lanes<S>, Lanes<S>) {
        let Points { normal, to_viewer, .. } = points;
        // Perpendicular to the line of sight, in the plane.
        let along = right * to_viewer[0] + up * to_viewer[1];
        let side = [right - to_viewer[0] * along, up - to_viewer[1] * along, -(to_viewer[2] * along)];
        let inverse = splat(simd, 1.0) / dot(side, side).sqrt();
        let side = scaled(side, inverse);
        // The normal's part in the plane.
        let (toward, aside) = (dot(*normal, *to_viewer), dot(*normal, side));
        let square = toward * toward + aside * aside;
        let length = clamp(simd, square, 1e-12, 4.0).sqrt();
        let inverse = splat(simd, 1.0) / length;
        let cosine = clamp(simd, toward * inverse, 0.0, 1.0);
        let (mut occluded, mut all) = (splat(simd, 0.0), splat(simd, 0.0));
        for sign in [1.0, -1.0] {
            let sine = clamp(simd, aside * inverse, -1.0, 1.0) * sign;
            let side = Side { direction: [right * sign, up * sign], cosine, sine };
            let (part, whole) = self.of_side(simd, points, &side, steps);
            all += whole;
            occluded += part;
        }
        (occluded * length, all * length)
    }

    /// The same on one side of the points. Each point that is higher than those before it occludes the light between, in
    /// proportion to how near it is.
    #[inline(always)]
    fn of_side<S: Simd>(
        &self,
        simd: S,
        points: &Points<S>,
        side: &Side<S>,
        steps: &[[f32; LANES]; STEPS],
    ) -> (Lanes<S>, Lanes<S>) {
        let Points { x, y, position, normal, to_viewer, radius } = points;
        let &Side { direction: [right, up], cosine, sine } = side;
        let one = splat(simd, 1.0);
        // That of the tangent plane.
        let mut highest = -sine;
        let all = light_above(simd, highest, cosine, sine);
        let (mut open, mut occluded) = (all, splat(simd, 0.0));
        // The squared distance of the last point.
        let mut before = splat(simd, 0.0);
        for step in steps {
            let distance = load(simd, step) * *radius;
            let distance = clamp(simd, distance, MIN_DISTANCE, MAX_RADIUS);
            // The nearest coarse pixel, in the margin if it is outside.
            let at_x = (*x + right * distance) * 0.5 + 0.5;
            let at_y = (*y - up * distance) * 0.5 + 0.5;
            let at_x = clamp(simd, at_x, -1.0, self.size[0] as f32).floor();
            let at_y = clamp(simd, at_y, -1.0, self.size[1] as f32).floor();
            let column: i32x16<S> = at_x.to_int();
            let line: i32x16<S> = at_y.to_int();
            let index = (line + MARGIN as i32) * self.stride as i32 + (column + MARGIN as i32) * 2;
            let depth = gather(simd, &self.depth, index);
            let other = self.position(simd, at_x * 2.0, at_y * 2.0, depth);
            let apart = minus(other, *position);
            let square = dot(apart, apart);
            // Not where nothing is visible: infinite, or no number.
            let counts = square.simd_lt(one) & dot(apart, *normal).simd_gt(splat(simd, BIAS));
            let horizon = dot(apart, *to_viewer) / square.sqrt();
            let rises = counts & horizon.simd_gt(highest);
            if rises.any_true() {
                highest = rises.select(horizon, highest);
                let left = light_above(simd, highest, cosine, sine);
                // What is between two points is hit between them.
                let nearer = before.simd_lt(square).select(before, square);
                let more = (open - left) * (one - (nearer + square) * 0.5);
                occluded = rises.select(occluded + more, occluded);
                open = rises.select(left, open);
            }
            before = square;
        }
        (occluded, all)
    }
}

#[inline(always)]
fn gather<S: Simd>(simd: S, from: &[f32], index: i32x16<S>) -> Lanes<S> {
    let index = index.to_array();
    let mut found = [0.0; LANES];
    for lane in 0..LANES {
        found[lane] = from[index[lane] as usize];
    }
    f32x16::load_array(simd, found)
}

/// The light that enters between the line of sight and a horizon at an angle to it, both given as cosines, weighted by its
/// cosine with a normal in the plane: the integral of sin(t) cos(t - n) from 0 to the horizon, times 4. The normal is at
/// the angle n, towards the horizon if positive.
#[inline(always)]
fn light_above<S: Simd>(
    simd: S,
    horizon: Lanes<S>,
    normal_cosine: Lanes<S>,
    normal_sine: Lanes<S>,
) -> Lanes<S> {
    let horizon = clamp(simd, horizon, -1.0, 1.0);
    let one = splat(simd, 1.0);
    let sine = (one - horizon * horizon).sqrt();
    let (double_cosine, double_sine) = (horizon * horizon * 2.0 - 1.0, horizon * sine * 2.0);
    let angle = arc_cosine(simd, horizon);
    (normal_cosine - (double_cosine * normal_cosine + double_sine * normal_sine)) + angle * normal_sine * 2.0
}
