//! Lines along the sides of triangles, drawn where these are shaded.
//!
//! Strips of triangles for all edges of a dense model are several times as many triangles as the model has, and each of them
//! costs what a triangle costs. But where a point of a triangle is shaded, its distances from the three sides are at hand: the
//! areas that interpolate (twice the area between the point and a side is the value of the side's edge function), divided by
//! the lengths of their gradients. They follow from the corners of the triangle alone, so the picture law holds, and nothing
//! is drawn that could be hidden or could flicker. Both triangles at a side draw half of its line; at a silhouette and at a
//! border, there is one half only, unless strips (`tercio::strokes`) complete it. The line of a polygon's side reaches over
//! the diagonals, where these are near: each triangle draws, besides its own, those that begin at its corners, whose edge functions
//! are combinations of its own.
//!
//! A line covers a point's footprint by the share of the footprint's extent across the line that it covers. The footprint is a
//! pixel, or the part of it that the triangle covers: if a side cuts the pixel, the middle of that part, where it is shaded, is
//! half of what is missing away from the middle of the pixel. See [`Footprint`].
//!
//! Beside this, a pass over finished tiles was considered: it would have to find the triangle of each sample, project its
//! corners again and keep colours of samples apart, all of which is known here.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u32x16};
use tercio_mesh::edges::{Beyond, FarEnds};
use tercio_scene::SurfaceEdges;

use super::corners::{Corners, Fragments};
use super::interpolate::Interpolation;
use super::light::Vec3x16;
use super::shade::displayable;
use crate::context::FrameContext;
use crate::projection::homogeneous;
use crate::simd::{LANES, each3, splat, splat_i};
use crate::surface_edges::{Footprint, PIXELS, SNAPPED, apex_of, nearest_of_clipped};
use crate::view::ObjectView;

/// Light with the lines of 16 triangles over it.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(always)]
pub fn over<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    fragments: &Fragments,
    (sample, from_middle): ([i32x16<S>; 2], [i32; 2]),
    at: &Interpolation<S>,
    corners: &Corners<S>,
    light: Vec3x16<S>,
) -> Vec3x16<S> {
    let slopes = at.slopes(simd, &context.objects[instance], sample, corners);
    // Copies, so that the others of the corners, of which no address is taken, stay in registers.
    let (area, numbers, depths) = (at.area, corners.numbers, (corners.d, corners.beyond));
    let edges = context.scene.instances[instance].edges.as_deref();
    let has_ends =
        edges.is_some_and(|edges| matches!(edges.beyond, Beyond::Quadrilaterals(_) | Beyond::Ends(_)));
    let screen = has_ends.then(
        #[inline(always)]
        || {
            let clipped = (corners.beyond != 0)
                .then(|| clipped_lines(context, instance, &fragments.from_middle, at, &slopes, corners));
            OnScreen { sample, x: corners.x, y: corners.y, from_middle, clipped }
        },
    );
    let all = (&area, &slopes, screen.as_ref());
    blend(simd, context, instance, &fragments.from_middle, all, &numbers, &depths, &light)
}

/// Points and the corners of their triangles on the screen, in the coordinate system of the corners.
struct OnScreen<S: Simd> {
    sample: [i32x16<S>; 2],
    x: [i32x16<S>; 3],
    y: [i32x16<S>; 3],
    /// The offset from these coordinates to coordinates relative to the middle of the picture.
    from_middle: [i32; 2],
    /// In lanes whose triangles are clipped, the distance of the nearest line to a far end, and how far the point is from the middle of the
    /// pixel across it.
    clipped: Option<[[f32; LANES]; 2]>,
}

/// [`OnScreen::clipped`].
#[cold]
#[inline(never)]
fn clipped_lines<S: Simd>(
    context: &FrameContext,
    instance: usize,
    from_middle: &[[i32; LANES]; 2],
    at: &Interpolation<S>,
    slopes: &[Vec3x16<S>; 2],
    corners: &Corners<S>,
) -> [[f32; LANES]; 2] {
    let mut nearest = [[f32::INFINITY; LANES], [0.0; LANES]];
    let Some(edges) = context.scene.instances[instance].edges.as_deref() else { return nearest };
    for lane in (0..LANES).filter(|lane| corners.beyond >> lane & 1 == 1) {
        let triangle = corners.numbers[lane];
        let positions = corners.position.map(|corner| corner.map(|axis: f32x16<S>| axis[lane]));
        let of = [at.area, slopes[0], slopes[1]].map(|v| v.map(|value: f32x16<S>| value[lane]));
        let from_middle = from_middle.map(|axis| axis[lane] as f32);
        let sides = edges.sides_of(triangle);
        let found = nearest_of_clipped(edges, (triangle as usize, sides), positions, of, from_middle);
        (nearest[0][lane], nearest[1][lane]) = (found.distance, found.across);
    }
    nearest
}

/// Lines from one end of a side of each of 16 triangles to points beyond it.
struct FarLines<S: Simd> {
    /// Their edge functions at the points, with their slopes.
    line: Vec3x16<S>,
    /// The points are beside the lines: behind the beginning they are as near to the sides of the triangles there, and behind the far end there
    /// is no line, unless it is behind the viewer.
    is_beside: mask32x16<S>,
    /// The far ends are on the other side of the sides.
    is_beyond: mask32x16<S>,
}

impl<S: Simd> OnScreen<S> {
    /// `to` are homogeneous coordinates of the far ends, `from` the coordinates of the beginnings, `slopes` those of the sides. Homogeneous
    /// coordinates hold wherever a far end is.
    #[inline(always)]
    fn lines(
        &self,
        to: &Vec3x16<S>,
        from: [i32x16<S>; 2],
        [right, down]: [f32x16<S>; 2],
        whole: f32x16<S>,
    ) -> FarLines<S> {
        let simd = whole.simd;
        let zero = splat(simd, 0.0);
        let from_x: f32x16<S> = (from[0] + self.from_middle[0]).to_float();
        let from_y: f32x16<S> = (from[1] + self.from_middle[1]).to_float();
        let (x, y) = (to[0] - from_x * to[2], to[1] - from_y * to[2]);
        let of_x: f32x16<S> = (self.sample[0] - from[0]).to_float();
        let of_y: f32x16<S> = (self.sample[1] - from[1]).to_float();
        let inwards = right * x + down * y;
        let inwards = whole.simd_lt(zero).select(-inwards, inwards);
        let snapped = (right.abs() + down.abs()) * (to[2].abs() * SNAPPED);
        let along = of_x * x + of_y * y;
        let is_ended = (along * to[2]).simd_gt(y * y + x * x) & to[2].simd_gt(zero);
        let is_beside = along.simd_ge(zero) & !is_ended;
        FarLines { line: [of_x * y - of_y * x, y, -x], is_beside, is_beyond: inwards.simd_lt(snapped) }
    }
}

/// Not inlined, so that it is compiled only once per SIMD level, and kernels of pictures without edges stay small.
#[expect(clippy::too_many_arguments, reason = "a struct would only rename them")]
#[inline(never)]
fn blend<S: Simd>(
    simd: S,
    context: &FrameContext,
    instance: usize,
    from_middle: &[[i32; LANES]; 2],
    (area, slopes, screen): (&Vec3x16<S>, &[Vec3x16<S>; 2], Option<&OnScreen<S>>),
    numbers: &[u32; LANES],
    depths: &([f32x16<S>; 3], u32),
    light: &Vec3x16<S>,
) -> Vec3x16<S> {
    simd.vectorize(
        #[inline(always)]
        || {
            let Some(edges) = context.scene.instances[instance].edges.as_deref() else { return *light };
            let zero = splat(simd, 0.0);
            let mut bits = [i32::from(SurfaceEdges::ALL); LANES];
            if let Some(sides) = &edges.sides {
                (0..LANES).for_each(|lane| bits[lane] = sides[numbers[lane] as usize].into());
            }
            let sides = i32x16::load_array_ref(simd, &bits);
            let [x, y] = from_middle;
            let x: f32x16<S> = i32x16::load_array_ref(simd, x).to_float();
            let y: f32x16<S> = i32x16::load_array_ref(simd, y).to_float();
            let mut nearest = Nearest { distance: splat(simd, f32::INFINITY), across: zero };
            for k in 0..3 {
                let is_side = !(sides & (1 << k)).simd_eq(splat_i(simd, 0));
                nearest.add([area[k], slopes[0][k], slopes[1][k]], [x, y], is_side);
            }
            let functions = [area, &slopes[0], &slopes[1]];
            let object = &context.objects[instance];
            let whole = (area[0] + area[1]) + area[2];
            let inside = mask32x16::from_bitmask(simd, u64::from(!depths.1));
            match &edges.beyond {
                Beyond::Nothing => {}
                Beyond::Quadrilaterals(fourth) => {
                    let Some(screen) = screen else { return *light };
                    let (mut positions, mut sides) = ([[0.0; LANES]; 3], [-1; LANES]);
                    for lane in 0..LANES {
                        if let Some(position) = fourth.of(numbers[lane] as usize) {
                            (0..3).for_each(|k| positions[k][lane] = position[k]);
                            sides[lane] = apex_of(bits[lane] as u8) as i32;
                        }
                    }
                    let positions = each3!(K => f32x16::load_array_ref(simd, &positions[K]));
                    let side = i32x16::load_array_ref(simd, &sides);
                    let is_side = each3!(K => side.simd_eq(splat_i(simd, K as i32)));
                    let to = homogeneous(simd, object, positions);
                    let slope = [after(&is_side, &slopes[0], 0), after(&is_side, &slopes[1], 0)];
                    let is_there = inside & side.simd_ge(splat_i(simd, 0));
                    for end in [1, 2] {
                        let from = [after_i(&is_side, &screen.x, end), after_i(&is_side, &screen.y, end)];
                        let far = screen.lines(&to, from, slope, whole);
                        nearest.add(far.line, [x, y], is_there & far.is_beyond & far.is_beside);
                    }
                }
                Beyond::Ends(ends) => {
                    let Some(screen) = screen else { return *light };
                    let ends = Ends::fetch(simd, ends, numbers);
                    for (places, position) in ends.places.iter().zip(&ends.positions).take(ends.count) {
                        let place = i32x16::load_array_ref(simd, places);
                        let is_side = each3!(K => (place >> 1).simd_eq(splat_i(simd, K as i32)));
                        let is_second = (place & 1).simd_eq(splat_i(simd, 1));
                        let to = homogeneous(simd, object, *position);
                        let from_x = is_second
                            .select(after_i(&is_side, &screen.x, 2), after_i(&is_side, &screen.x, 1));
                        let from_y = is_second
                            .select(after_i(&is_side, &screen.y, 2), after_i(&is_side, &screen.y, 1));
                        let slope = [after(&is_side, &slopes[0], 0), after(&is_side, &slopes[1], 0)];
                        let far = screen.lines(&to, [from_x, from_y], slope, whole);
                        let is_there = inside & place.simd_ge(splat_i(simd, 0));
                        nearest.add(far.line, [x, y], is_there & far.is_beyond & far.is_beside);
                    }
                }
                Beyond::Polygons(all) => {
                    let mut places = [[[0.0; LANES]; 2]; 3];
                    for lane in 0..LANES {
                        let of_lane = &all[numbers[lane] as usize];
                        for k in 0..3 {
                            (0..2).for_each(|n| places[k][n][lane] = of_lane[k][n]);
                        }
                    }
                    let scale = scales(simd, object, depths);
                    for k in 0..3 {
                        for n in 0..2 {
                            let place = f32x16::load_array_ref(simd, &places[k][n]);
                            let beside = (k + 1 + n) % 3;
                            let (by_apex, by_beside) = (place * scale[k], scale[beside]);
                            let line =
                                each3!(K => functions[K][k] * by_apex + functions[K][beside] * by_beside);
                            nearest.add(line, [x, y], place.simd_gt(zero));
                        }
                    }
                }
            }
            if let Some(clipped) = screen.and_then(|screen| screen.clipped.as_ref()) {
                let [distance, across] =
                    [f32x16::load_array_ref(simd, &clipped[0]), f32x16::load_array_ref(simd, &clipped[1])];
                nearest.take(distance, across, distance.simd_lt(nearest.distance));
            }
            let Nearest { distance: nearest, across } = nearest;
            let Footprint { size, shrinking, least } = context.footprint;
            let extent = splat(simd, size) - across * shrinking;
            let least = splat(simd, least);
            let extent = extent.simd_gt(least).select(extent, least);
            let width = splat(simd, edges.width);
            let covered = (width * 0.5 - nearest * PIXELS) + extent * 0.5;
            let covered = covered.simd_gt(zero).select(covered, zero);
            let most = width.simd_lt(extent).select(width, extent);
            let cover = covered.simd_lt(most).select(covered, most) / extent * edges.opacity;
            let shown = displayable(simd, *light);
            each3!(C => shown[C] + (splat(simd, edges.color[C]) - shown[C]) * cover)
        },
    )
}

/// The other ends of the edges that begin at corners of 16 triangles.
struct Ends<S: Simd> {
    /// The most that one of the triangles has.
    count: usize,
    positions: [Vec3x16<S>; FarEnds::MOST],
    /// Where they begin: twice the number of a side, plus its end; -1 in lanes without so many.
    places: [[i32; LANES]; FarEnds::MOST],
}

impl<S: Simd> Ends<S> {
    /// Those of the triangles with these numbers in the mesh.
    #[inline(always)]
    fn fetch(simd: S, ends: &FarEnds, numbers: &[u32; LANES]) -> Self {
        let positions = [[splat(simd, 0.0); 3]; FarEnds::MOST];
        let mut all = Self { count: 0, positions, places: [[-1; LANES]; FarEnds::MOST] };
        let mut left = 0xffff_u32;
        while left != 0 {
            // Neighbouring points usually are of the same triangle.
            let number = numbers[left.trailing_zeros() as usize % LANES];
            let same = u32x16::load_array_ref(simd, numbers).simd_eq(u32x16::splat(simd, number));
            left &= !(same.to_bitmask() as u32);
            for (n, end) in ends.of(number as usize).take(FarEnds::MOST).enumerate() {
                all.count = all.count.max(n + 1);
                let place = splat_i(simd, i32::from(2 * end.side + end.end));
                same.select(place, i32x16::load_array_ref(simd, &all.places[n]))
                    .store_slice(&mut all.places[n]);
                all.positions[n] =
                    each3!(K => same.select(splat(simd, end.position[K]), all.positions[n][K]));
            }
        }
        all
    }
}

/// The line that is nearest to 16 points: its distance in sub-pixels, and how far the point is from the middle of the pixel across
/// it.
struct Nearest<S: Simd> {
    distance: f32x16<S>,
    across: f32x16<S>,
}

impl<S: Simd> Nearest<S> {
    /// Adds the lines of some lanes, given by the values of their edge functions and the changes of these to the right and downwards.
    #[inline(always)]
    fn add(&mut self, line: Vec3x16<S>, [x, y]: [f32x16<S>; 2], is_line: mask32x16<S>) {
        let ([value, right, down], simd) = (line, x.simd);
        let inverse = splat(simd, 1.0) / (right * right + down * down).sqrt();
        let distance = value.abs() * inverse;
        let across = (x * right + y * down).abs() * inverse;
        self.take(distance, across, is_line & distance.simd_lt(self.distance));
    }

    /// Takes other lines in some lanes.
    #[inline(always)]
    fn take(&mut self, distance: f32x16<S>, across: f32x16<S>, is_nearer: mask32x16<S>) {
        self.distance = is_nearer.select(distance, self.distance);
        self.across = is_nearer.select(across, self.across);
    }
}

/// What makes areas barycentric coordinates in perspective; those of clipped triangles are already.
#[inline(always)]
fn scales<S: Simd>(simd: S, object: &ObjectView, (d, beyond): &([f32x16<S>; 3], u32)) -> Vec3x16<S> {
    let one = splat(simd, 1.0);
    if !object.perspective {
        return [one; 3];
    }
    let beyond = mask32x16::from_bitmask(simd, u64::from(*beyond));
    each3!(K => beyond.select(one, d[K] * object.weight))
}

/// Of the values at corners, those of the corner that comes so many places after the apex.
#[inline(always)]
fn after<S: Simd>(is_apex: &[mask32x16<S>; 3], v: &Vec3x16<S>, places: usize) -> f32x16<S> {
    let beyond_first = is_apex[1].select(v[(1 + places) % 3], v[(2 + places) % 3]);
    is_apex[0].select(v[places % 3], beyond_first)
}

/// [`after`], of coordinates.
#[inline(always)]
fn after_i<S: Simd>(is_apex: &[mask32x16<S>; 3], v: &[i32x16<S>; 3], places: usize) -> i32x16<S> {
    let beyond_first = is_apex[1].select(v[(1 + places) % 3], v[(2 + places) % 3]);
    is_apex[0].select(v[places % 3], beyond_first)
}
