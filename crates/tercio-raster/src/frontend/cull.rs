//! Culling of whole clusters: outside the view volume, between the samples of the picture, or facing the culled side.
//!
//! [`ClusterTests`] tests 16 clusters at a time in `f32`; [`place`] decides in `f64` for the few that cross a plane.
//! All tests are conservative: they have a margin for the effects of rounding and snapping, and drop only clusters that
//! cannot cover a sample.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use tercio_mesh::cluster::Cluster;

use crate::conventions::{GUARD, SMALL_CLUSTER, SUBPIXEL_BITS, SUBPIXELS};
use crate::projection::relative;
use crate::simd::{LANES, dot, each3, load, part, row, splat, splat_i};
use crate::view::{ObjectView, View};

/// Position of a cluster relative to the view volume and the guard band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// It is outside the view volume.
    Outside,
    /// All of it is inside the near plane and the guard band: no triangle needs clipping.
    Inside,
    /// Some triangles may need clipping.
    Crossing,
}

/// The range of a matrix row over a box, given as middle and half edges: the value in the middle, the largest deviation
/// from it, and a bound of the rounding error.
fn extremes(row: &[f64; 4], middle: [f64; 3], half: [f64; 3]) -> (f64, f64, f64) {
    let center = ((row[0] * middle[0] + row[1] * middle[1]) + row[2] * middle[2]) + row[3];
    let reach = (row[0].abs() * half[0] + row[1].abs() * half[1]) + row[2].abs() * half[2];
    // A bound of what `f32` may have rounded off in the coordinates.
    let magnitude = (0..3).map(|k| row[k].abs() * (middle[k].abs() + half[k])).sum::<f64>() + row[3].abs();
    (center, reach, magnitude * 1e-6)
}

/// Classifies a cluster by its bounding box.
pub fn place(view: &View, object: &ObjectView, cluster: &Cluster) -> Placement {
    let middle = std::array::from_fn(|k| (f64::from(cluster.min[k]) + f64::from(cluster.max[k])) * 0.5);
    let half = std::array::from_fn(|k| (f64::from(cluster.max[k]) - f64::from(cluster.min[k])) * 0.5);
    let rows = &object.exact;
    // The picture's borders with a margin of one pixel, in clip space: -before * w <= x <= behind * w.
    let borders = |size: u32, middle: i32| {
        let (whole, before) = (f64::from(size) * f64::from(SUBPIXELS), f64::from(middle));
        [before, whole - before].map(|to_border| to_border + f64::from(SUBPIXELS))
    };
    let mut inside = true;
    let mut check = |row: [f64; 4]| {
        let (center, reach, slack) = extremes(&row, middle, half);
        inside &= center - reach > slack;
        center + reach < -slack
    };
    let near = if view.perspective {
        [rows.w[0], rows.w[1], rows.w[2], rows.w[3] - f64::from(object.near)]
    } else {
        [-rows.d[0], -rows.d[1], -rows.d[2], 1.0 - rows.d[3]]
    };
    if check(near) {
        return Placement::Outside;
    }
    let combine =
        |factor: f64, row: &[f64; 4], sign: f64| std::array::from_fn(|k| factor * rows.w[k] + sign * row[k]);
    let mut outside = false;
    for (row, [before, behind]) in
        [(&rows.x, borders(view.width, view.middle[0])), (&rows.y, borders(view.height, view.middle[1]))]
    {
        for (sign, border) in [(1.0, before), (-1.0, behind)] {
            let (center, reach, slack) = extremes(&combine(border, row, sign), middle, half);
            outside |= center + reach < -slack;
            check(combine(f64::from(GUARD) * 0.999, row, sign));
        }
    }
    match (outside, inside) {
        (true, _) => Placement::Outside,
        (_, true) => Placement::Inside,
        _ => Placement::Crossing,
    }
}

/// Minimum height of a triangle, in sub-pixels, such that snapping cannot flip its winding. Each corner moves by up to
/// half a sub-pixel, which can flip triangles lower than 5; the rest is a margin for the rounding of `f32` in
/// projection.
const SAFE_HEIGHT: f32 = 16.0;
/// Bound of the rounding error of a sum of products in `f32`, relative to the sum of their magnitudes. Twenty roundings
/// would be 1.2e-6.
const SLACK: f32 = 3e-6;

/// The bounds of 16 clusters, lane by lane.
#[derive(Debug, Default)]
pub struct ClusterLanes {
    min: [[f32; LANES]; 3],
    max: [[f32; LANES]; 3],
    axis: [[f32; LANES]; 3],
    cutoff: [f32; LANES],
    radius: [f32; LANES],
    min_height: [f32; LANES],
}

impl ClusterLanes {
    /// Loads the bounds of at most 16 clusters; the lanes after the last are not valid.
    #[inline(always)]
    pub fn load(&mut self, clusters: &[Cluster]) {
        for (lane, cluster) in clusters.iter().enumerate().take(LANES) {
            for k in 0..3 {
                self.min[k][lane] = cluster.min[k];
                self.max[k][lane] = cluster.max[k];
                self.axis[k][lane] = f32::from(cluster.cone_axis[k]);
            }
            self.cutoff[lane] = f32::from(cluster.cone_cutoff);
            self.radius[lane] = cluster.radius;
            self.min_height[lane] = cluster.min_height;
        }
    }
}

/// The results of the tests of 16 clusters; bit i of a mask is cluster i. All but `outside` are valid only for clusters
/// that are `inside`.
#[derive(Debug, Default)]
pub struct ClusterTests {
    /// Wholly before the near plane or beside the picture.
    pub outside: u32,
    /// Inside the near plane and the guard band: no triangle needs clipping.
    pub inside: u32,
    /// Between the samples of the picture: not visible.
    pub no_sample: u32,
    /// All triangles show the culled side, and still do after snapping.
    pub one_side: u32,
    /// Less than [`SMALL_CLUSTER`] across and down on the screen.
    pub small: u32,
    /// First and last column, first and last row of pixels that a cluster may reach.
    pub rect: [[i32; LANES]; 4],
    /// Upper bound of the depth.
    pub nearest: [f32; LANES],
}

impl ClusterTests {
    /// Tests 16 clusters. `back` is the culled side: backs (`true`), fronts (`false`), or neither. The samples of a pixel
    /// are at least `origin` sub-pixels from its borders.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        view: &View,
        object: &ObjectView,
        lanes: &ClusterLanes,
        back: Option<bool>,
        origin: i32,
    ) -> Self {
        {
            {
                let min = relative(simd, object, each3!(K => load(simd, &lanes.min[K])));
                let max = relative(simd, object, each3!(K => load(simd, &lanes.max[K])));
                let middle = each3!(K => (min[K] + max[K]) * 0.5);
                let half = each3!(K => (max[K] - min[K]) * 0.5);
                let depth = DepthRange::new(simd, object, middle, half);
                let x = screen_range(simd, &object.x, object, &depth, middle, half);
                let y = screen_range(simd, &object.y, object, &depth, middle, half);

                let limit = splat(simd, GUARD * 0.99);
                let inside = depth.in_front
                    & x[0].simd_gt(-limit)
                    & x[1].simd_lt(limit)
                    & y[0].simd_gt(-limit)
                    & y[1].simd_lt(limit);
                let (columns, beside) = pixels(simd, x, object.offset[0], origin, view.width);
                let (rows, above) = pixels(simd, y, object.offset[1], origin, view.height);
                let between = columns[0].simd_gt(columns[1]) | rows[0].simd_gt(rows[1]);
                let extent = splat(simd, SMALL_CLUSTER as f32);
                let small = (x[1] - x[0]).simd_lt(extent) & (y[1] - y[0]).simd_lt(extent);
                let outside = depth.behind | (inside & (beside | above));
                let inside = inside & !outside;
                Self {
                    outside: bits(outside),
                    inside: bits(inside),
                    no_sample: bits(between & inside),
                    one_side: match back {
                        Some(back) => {
                            bits(one_side(simd, view, object, lanes, middle, &depth, back) & inside)
                        }
                        None => 0,
                    },
                    small: bits(small & inside),
                    rect: [
                        columns[0].to_array(),
                        columns[1].to_array(),
                        rows[0].to_array(),
                        rows[1].to_array(),
                    ],
                    nearest: depth.nearest.to_array(),
                }
            }
        }
    }
}

/// One bit a lane.
#[inline(always)]
fn bits<S: Simd>(mask: mask32x16<S>) -> u32 {
    mask.to_bitmask() as u32 & 0xffff
}

/// The extents of boxes along the line of sight.
struct DepthRange<S: Simd> {
    /// Smallest and largest w.
    w: [f32x16<S>; 2],
    /// 1 / w of the middle.
    inverse: f32x16<S>,
    /// Bound of the rounding error of w.
    slack: f32x16<S>,
    /// Upper bound of the depth.
    nearest: f32x16<S>,
    /// Wholly inside the near plane.
    in_front: mask32x16<S>,
    /// Wholly outside it.
    behind: mask32x16<S>,
}

impl<S: Simd> DepthRange<S> {
    #[inline(always)]
    fn new(simd: S, object: &ObjectView, middle: [f32x16<S>; 3], half: [f32x16<S>; 3]) -> Self {
        part(
            simd,
            #[inline(always)]
            || {
                let one = splat(simd, 1.0);
                if object.perspective {
                    let w = row(simd, &object.w, middle);
                    let slack = magnitude(simd, &object.w, middle, half);
                    let reach = reach(simd, &object.w, half) + slack;
                    let (least, most) = (w - reach, w + reach);
                    let near = splat(simd, object.near);
                    Self {
                        w: [least, most],
                        inverse: one / w,
                        slack,
                        nearest: near / least * (1.0 + SLACK),
                        in_front: least.simd_gt(near),
                        behind: most.simd_lt(near),
                    }
                } else {
                    let d = row(simd, &object.d, middle);
                    let reach = reach(simd, &object.d, half) + magnitude(simd, &object.d, middle, half);
                    Self {
                        w: [one; 2],
                        inverse: one,
                        slack: splat(simd, 0.0),
                        nearest: d + reach,
                        in_front: (d + reach).simd_lt(one),
                        behind: (d - reach).simd_gt(one),
                    }
                }
            },
        )
    }
}

/// The largest deviation of a matrix row, over a box, from its value in the middle of the box.
#[inline(always)]
fn reach<S: Simd>(simd: S, r: &[f32; 4], half: [f32x16<S>; 3]) -> f32x16<S> {
    dot(each3!(K => splat(simd, r[K].abs())), half)
}

/// Bound of the rounding error of a matrix row anywhere in a box.
#[inline(always)]
fn magnitude<S: Simd>(simd: S, r: &[f32; 4], middle: [f32x16<S>; 3], half: [f32x16<S>; 3]) -> f32x16<S> {
    (reach(simd, r, each3!(K => middle[K].abs() + half[K])) + splat(simd, r[3].abs())) * SLACK
}

/// Smallest and largest screen coordinate of boxes, in sub-pixels from the middle of the picture; valid only if all of
/// the box is in front of the near plane.
///
/// With s the coordinate of the middle, x - s * w is zero there, and |x / w - s| is at most the [`reach`] of that row,
/// divided by the smallest w.
#[inline(always)]
fn screen_range<S: Simd>(
    simd: S,
    r: &[f32; 4],
    object: &ObjectView,
    depth: &DepthRange<S>,
    middle: [f32x16<S>; 3],
    half: [f32x16<S>; 3],
) -> [f32x16<S>; 2] {
    part(
        simd,
        #[inline(always)]
        || {
            let s = row(simd, r, middle) * depth.inverse;
            let away = if object.perspective {
                dot(each3!(K => (splat(simd, r[K]) - s * object.w[K]).abs()), half)
            } else {
                reach(simd, r, half)
            };
            let slack = magnitude(simd, r, middle, half) + s.abs() * depth.slack;
            // Two sub-pixels of margin for snapping and for truncating the fraction.
            let away = (away + slack) / depth.w[0] + (s.abs() * SLACK + 2.0);
            [s - away, s + away]
        },
    )
}

/// First and last pixel of the picture with samples in a range, and the lanes whose range is not empty but wholly
/// outside the picture.
#[inline(always)]
fn pixels<S: Simd>(
    simd: S,
    range: [f32x16<S>; 2],
    offset: i32,
    origin: i32,
    size: u32,
) -> ([i32x16<S>; 2], mask32x16<S>) {
    part(
        simd,
        #[inline(always)]
        || {
            let first = (range[0].to_int::<i32x16<S>>() + (offset + origin - 1)) >> SUBPIXEL_BITS;
            let last = (range[1].to_int::<i32x16<S>>() + (offset - origin)) >> SUBPIXEL_BITS;
            let border = size as i32 - 1;
            let beside =
                first.simd_le(last) & (first.simd_gt(splat_i(simd, border)) | last.simd_lt(splat_i(simd, 0)));
            ([first.max(splat_i(simd, 0)), last.min(splat_i(simd, border))], beside)
        },
    )
}

/// Which clusters are certain to show only their back (`back`) or their front, also after their corners are snapped.
/// Precondition: the clusters are inside the near plane and the guard band.
///
/// The normal cone gives the facing in exact geometry, with a margin m: the sine of the angle between the line
/// of sight and each triangle's plane is at least 2/pi * m. On the screen the smallest height of a triangle is then
/// at least `scale * height * sine * w_min^2 / w_max^3` for a perspective camera (the projected area divided by the
/// longest projected edge), `scale * height * sine` for an orthographic one.
#[inline(always)]
fn one_side<S: Simd>(
    simd: S,
    view: &View,
    object: &ObjectView,
    lanes: &ClusterLanes,
    middle: [f32x16<S>; 3],
    depth: &DepthRange<S>,
    back: bool,
) -> mask32x16<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let zero = splat(simd, 0.0);
            let Some(similarity) = object.similarity else { return zero.simd_gt(zero) };
            // Distances along the line of sight are in that unit.
            let per_unit = if object.perspective { 1.0 / view.unit } else { 1.0 };
            let axis = each3!(K => load(simd, &lanes.axis[K]) * (1.0 / 127.0));
            let cutoff = load(simd, &lanes.cutoff) * (1.0 / 127.0);
            let radius = load(simd, &lanes.radius) * 1.0001;
            let viewer = each3!(K => splat(simd, object.viewer[K]));
            // The viewing direction: from the eye to the middle of the cluster, or along the parallel rays.
            let d =
                if object.perspective { each3!(K => middle[K] - viewer[K]) } else { each3!(K => -viewer[K]) };
            let length = dot(d, d).sqrt();
            let along = dot(d, axis);
            let along = if back { along } else { -along };
            let reach = if object.perspective { radius } else { zero };
            let margin = (along - reach) / (length + reach) - cutoff - 1e-4;
            let height = load(simd, &lanes.min_height)
                * ((similarity * view.scale * std::f64::consts::FRAC_2_PI * per_unit) as f32);
            let height = height * margin;
            let on_screen = if object.perspective {
                let [least, most] = depth.w;
                height * least * least / (most * most * most)
            } else {
                height
            };
            margin.simd_gt(zero) & on_screen.simd_gt(splat(simd, SAFE_HEIGHT))
        },
    )
}
