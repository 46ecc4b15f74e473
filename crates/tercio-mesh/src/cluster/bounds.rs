//! Box, sphere, normal cone and smallest height of a cluster.

use glam::DVec3;

use super::{Cluster, MAX_TRIANGLES, MAX_VERTICES, cone::middle};
use crate::OctNormal;

/// Below this sine of the angle between two edges a normal is not reliable, even in `f64`.
const SINE_LIMIT: f64 = 1e-10;

/// Least angle, as a sine, between a vertex normal and the planes of its triangles, so that rounding anywhere between
/// here and a pixel does not change which side of a plane it points to.
const MARGIN: f64 = 0.02;

/// Where two edges of a triangle meet at a smaller angle, as a sine, rounding could turn the plane that they span by
/// that much.
const LEAST_SINE: f64 = 1e-3;

/// Vertices or triangles that are processed side by side.
const LANES: usize = 16;

/// Fills in all bounds of a cluster. `axes` and `normals` hold its vertices, `corners` its triangles.
#[inline(always)]
pub(super) fn bound(
    cluster: &mut Cluster,
    axes: [&[f32]; 3],
    normals_of_vertices: Option<&[OctNormal]>,
    corners: [&[u8]; 3],
) {
    for k in 0..3 {
        (cluster.min[k], cluster.max[k]) = range(axes[k]);
    }
    cluster.radius = round_up(farthest2(cluster, axes).sqrt());

    let mut normals = [DVec3::ZERO; MAX_TRIANGLES];
    let (mut count, mut sum, mut height2, mut reliable) = (0, DVec3::ZERO, f64::INFINITY, true);
    let mut faces = Faces::default();
    let directions = Directions::new(normals_of_vertices.unwrap_or_default());
    let mut agree = normals_of_vertices.is_some();
    // With as many entries as a corner can name, so that indexing needs no bounds check.
    let mut points = [[0.0; MAX_VERTICES]; 3];
    for axis in 0..3 {
        points[axis][..axes[axis].len()].copy_from_slice(axes[axis]);
    }
    let n = corners[0].len();
    for first in (0..n).step_by(LANES) {
        let here = LANES.min(n - first);
        for lane in 0..here {
            for k in 0..3 {
                let v = usize::from(corners[k][first + lane]) % MAX_VERTICES;
                for axis in 0..3 {
                    faces.points[k][axis][lane] = points[axis][v];
                }
            }
        }
        faces.compute();
        for lane in 0..here {
            let corners = [corners[0][first + lane], corners[1][first + lane], corners[2][first + lane]];
            agree &= faces.spans_plane[lane] & directions.point_outwards(&faces.normal, lane, corners);
            if faces.has_area[lane] {
                let normal = DVec3::new(faces.normal[0][lane], faces.normal[1][lane], faces.normal[2][lane]);
                normals[count] = normal;
                sum += normal;
                count += 1;
                height2 = height2.min(faces.height2[lane]);
                reliable &= faces.reliable[lane];
            } else {
                height2 = 0.0;
            }
        }
    }
    cluster.flags = if agree { Cluster::NORMALS_AGREE } else { 0 };
    cluster.min_height = round_down(height2.sqrt());
    (cluster.cone_axis, cluster.cone_cutoff) =
        if reliable { cone(&normals[..count], sum) } else { ([0; 3], Cluster::NO_CONE) };
}

/// Vertex normals of a cluster, of length 1: axis, vertex.
struct Directions([[f64; MAX_VERTICES]; 3]);

impl Directions {
    #[inline(always)]
    fn new(normals: &[OctNormal]) -> Self {
        let mut unit = [[0.0; MAX_VERTICES]; 3];
        for (i, normal) in normals.iter().enumerate() {
            let [x, y, z] = normal.decode();
            let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
            let scale = 1.0 / (x * x + y * y + z * z).sqrt();
            unit[0][i] = x * scale;
            unit[1][i] = y * scale;
            unit[2][i] = z * scale;
        }
        Self(unit)
    }

    /// Do the normals of a triangle's corners certainly point to the side of its own normal?
    #[inline(always)]
    fn point_outwards(&self, normals: &[[f64; LANES]; 3], lane: usize, corners: [u8; 3]) -> bool {
        let [x, y, z] = &self.0;
        let mut all = true;
        for corner in corners {
            let v = usize::from(corner) % MAX_VERTICES;
            let sine = x[v] * normals[0][lane] + y[v] * normals[1][lane] + z[v] * normals[2][lane];
            all &= sine > MARGIN;
        }
        all
    }
}

/// The least and the largest of some numbers.
#[inline(always)]
fn range(values: &[f32]) -> (f32, f32) {
    let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    let (whole, rest) = values.as_chunks::<LANES>();
    for values in whole {
        for i in 0..LANES {
            low[i] = if values[i] < low[i] { values[i] } else { low[i] };
            high[i] = if values[i] > high[i] { values[i] } else { high[i] };
        }
    }
    let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
    for &v in low.iter().chain(rest) {
        least = least.min(v);
    }
    for &v in high.iter().chain(rest) {
        most = most.max(v);
    }
    (least, most)
}

/// Square of the largest distance of a vertex from the centre of the cluster's box.
#[inline(always)]
fn farthest2(cluster: &Cluster, [x, y, z]: [&[f32]; 3]) -> f64 {
    let center = [0, 1, 2].map(|k| f64::from(middle(cluster.min[k], cluster.max[k])));
    let mut squares = [0.0; MAX_VERTICES];
    for i in 0..x.len() {
        let (dx, dy, dz) =
            (f64::from(x[i]) - center[0], f64::from(y[i]) - center[1], f64::from(z[i]) - center[2]);
        squares[i] = dx * dx + dy * dy + dz * dz;
    }
    squares.into_iter().fold(0.0, f64::max)
}

/// Normals and heights of some triangles side by side.
#[derive(Default)]
struct Faces {
    /// Coordinates: corner, axis, triangle.
    points: [[[f32; LANES]; 3]; 3],
    /// Unit normals.
    normal: [[f64; LANES]; 3],
    /// Squares of the least heights.
    height2: [f64; LANES],
    has_area: [bool; LANES],
    /// Is the normal reliable?
    reliable: [bool; LANES],
    /// Is the normal reliable even in `f32`?
    spans_plane: [bool; LANES],
}

impl Faces {
    /// Computes the other fields from the points. Without closures, which would not be compiled at the SIMD level of
    /// the caller.
    #[inline(always)]
    fn compute(&mut self) {
        let [a, b, c] = &self.points;
        for i in 0..LANES {
            let a = [f64::from(a[0][i]), f64::from(a[1][i]), f64::from(a[2][i])];
            let b = [f64::from(b[0][i]), f64::from(b[1][i]), f64::from(b[2][i])];
            let c = [f64::from(c[0][i]), f64::from(c[1][i]), f64::from(c[2][i])];
            let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
            let w = [v[0] - u[0], v[1] - u[1], v[2] - u[2]];
            let n = [u[1] * v[2] - v[1] * u[2], u[2] * v[0] - v[2] * u[0], u[0] * v[1] - v[0] * u[1]];
            let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            let uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
            let vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            let ww = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            let longest = if uu > vv { uu } else { vv };
            let longest = if ww > longest { ww } else { longest };
            self.height2[i] = square / longest;
            self.reliable[i] = square > SINE_LIMIT * SINE_LIMIT * (uu * vv);
            self.spans_plane[i] = square > LEAST_SINE * LEAST_SINE * (uu * vv);
            self.has_area[i] = square > 0.0;
            let scale = 1.0 / square.sqrt();
            for k in 0..3 {
                self.normal[k][i] = n[k] * scale;
            }
        }
    }
}

/// Axis and cut-off, in 1/127, of a cone about `direction` that holds all unit normals.
fn cone(normals: &[DVec3], direction: DVec3) -> ([i8; 3], i8) {
    const NONE: ([i8; 3], i8) = ([0; 3], Cluster::NO_CONE);
    // Scaled by 126, so that rounding never makes the axis longer than 127.
    let scaled = direction.normalize_or_zero() * 126.0;
    let axis = scaled.to_array().map(|v| v.round() as i8);
    let quantised = DVec3::from_array(axis.map(f64::from));
    let length = quantised.length();
    let cosine = normals.iter().map(|n| n.dot(quantised)).fold(f64::INFINITY, f64::min) / length;
    // A cone of a right angle or more contains, for every eye, a normal that faces it.
    if !(cosine > 1e-3 && cosine.is_finite()) {
        return NONE;
    }
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let cutoff = (length * sine + 1e-4).ceil();
    if cutoff >= f64::from(Cluster::NO_CONE) { NONE } else { (axis, cutoff as i8) }
}

/// An `f32` close to `v` that is certainly not smaller than the exact value, which differs from `v` by a few
/// roundings.
fn round_up(v: f64) -> f32 {
    (v as f32 * (1.0 + 2.0 * f32::EPSILON)).max(f32::MIN_POSITIVE)
}

fn round_down(v: f64) -> f32 {
    v.min(f32::MAX.into()) as f32 * (1.0 - 2.0 * f32::EPSILON)
}
