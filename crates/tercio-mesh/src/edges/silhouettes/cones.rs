//! Cones of normals in blocks, so that a processor's registers hold those of several groups.

use glam::{DVec3, Vec3};

use super::{LEAST_ANGLE, ROUNDING, Viewer, normals};
use crate::OctNormal;
use crate::edges::Edges;

/// Edges in a group; the last one may be smaller.
pub const GROUP: usize = 8;
/// Groups in a block, and normals beside the edges of a group.
pub const LANES: usize = 16;
const _: () = assert!(LANES == 2 * GROUP);

/// The cone of a group.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// A sphere that holds the first ends of all edges.
    center: Vec3,
    radius: f32,
    /// The direction of the middle. The normals of both triangles at each edge, or the opposite ones of both, are in the cone.
    axis: Vec3,
    /// Sine and cosine of the angle between the axis and the surface of the cone, plus [`LEAST_ANGLE`].
    sin: f32,
    cos: f32,
}

impl Cone {
    /// `more` are sine and cosine of [`LEAST_ANGLE`].
    pub fn new(edges: &Edges, numbers: &[u32], least_height: f64, more: (f64, f64)) -> Self {
        let group = || numbers.iter().map(|&number| &edges.list[number as usize]);
        let first_ends = || group().map(|edge| edges.local(edge.ends[0]));
        let (min, max) = first_ends()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
        let center = ((min + max) * 0.5).as_vec3();
        let radius = first_ends().map(|p| p.distance(center.as_dvec3())).fold(0.0, f64::max);
        let anything = Self { center, radius: radius as f32, axis: Vec3::X, sin: 1.0, cos: 0.0 };

        let mut all = [[DVec3::ZERO; 2]; GROUP];
        let mut sum = DVec3::ZERO;
        for (pair, edge) in all.iter_mut().zip(group()) {
            let Some(both) = normals(edges, edge, least_height) else { return anything };
            // Triangles may be wound either way.
            let is_turned = sum.dot(both[0] + both[1]) < 0.0;
            *pair = if is_turned { both.map(|normal| -normal) } else { both };
            sum += pair[0] + pair[1];
        }
        let axis = sum.normalize_or_zero().as_vec3();
        let used = all[..numbers.len()].as_flattened();
        let cos = used.iter().map(|normal| normal.dot(axis.as_dvec3())).fold(1.0, f64::min);
        if cos <= 0.0 {
            return anything;
        }
        let ((sin_more, cos_more), sin) = (more, (1.0 - cos * cos).max(0.0).sqrt());
        let (sin, cos) = (sin * cos_more + cos * sin_more, cos * cos_more - sin * sin_more);
        Self { axis, sin: sin as f32, cos: cos as f32, ..anything }
    }
}

/// The cones of a block of groups; lanes without a group are of no meaning.
#[derive(Clone, Debug, Default)]
pub struct Block {
    center: [[f32; LANES]; 3],
    radius: [f32; LANES],
    axis: [[f32; LANES]; 3],
    sin: [f32; LANES],
    cos: [f32; LANES],
}

impl Block {
    pub fn new(cones: impl Iterator<Item = Cone>) -> Self {
        let mut block = Self::default();
        for (lane, cone) in cones.enumerate() {
            for k in 0..3 {
                block.center[k][lane] = cone.center[k];
                block.axis[k][lane] = cone.axis[k];
            }
            (block.radius[lane], block.sin[lane], block.cos[lane]) = (cone.radius, cone.sin, cone.cos);
        }
        block
    }

    /// The groups, one bit each, of which the viewer does not see the same side of all triangles, or one of them nearly edge-on.
    #[inline(always)]
    pub fn not_seen_from_one_side(&self, sight: &Sight) -> u32 {
        let mut is_open = [true; LANES];
        for lane in 0..LANES {
            let widened = |of: &[f32; LANES]| f64::from(of[lane]);
            let [x, y, z] = self.center.each_ref().map(widened);
            let [x, y, z] = [
                x * sight.scale + sight.offset[0],
                y * sight.scale + sight.offset[1],
                z * sight.scale + sight.offset[2],
            ];
            let radius = widened(&self.radius) * sight.scale;
            let [i, j, k] = self.axis.each_ref().map(widened);
            let (sin, cos) = (widened(&self.sin), widened(&self.cos));
            // With a half the opening of the cone, b half the angle at which the eye sees the sphere (sin b = radius / |towards|,
            // cos b = tangent / |towards|), and c the angle between `towards` and the axis: all normals are on one side of all lines
            // of sight if a + b is less than a right angle and |cos c| > sin(a + b). Both sides of both conditions are multiplied by
            // |towards|.
            let tangent2 = (x * x + y * y + z * z) - radius * radius;
            let tangent = if tangent2 > 0.0 { tangent2 } else { 0.0 }.sqrt();
            let is_acute = (tangent2 > 0.0) & (cos * tangent > sin * radius);
            let across = (i * x + j * y + k * z).abs();
            is_open[lane] = !(is_acute & (across > sin * tangent + cos * radius));
        }
        bits(&is_open)
    }

    /// From the viewer to the middle of a group, and the radius around it that matters.
    #[inline(always)]
    fn towards(&self, group: usize, sight: &Sight) -> (DVec3, f64) {
        let center = DVec3::from(self.center.map(|of| f64::from(of[group])));
        (center * sight.scale + sight.offset, f64::from(self.radius[group]) * sight.scale)
    }
}

/// A viewer as cones are seen from it: the way to a point is the point times `scale`, plus `offset`.
pub struct Sight {
    scale: f64,
    offset: DVec3,
}

impl Sight {
    pub fn new(viewer: Viewer) -> Self {
        match viewer {
            Viewer::At(eye) => Self { scale: 1.0, offset: -eye },
            Viewer::Along(direction) => Self { scale: 0.0, offset: direction },
        }
    }
}

/// What normals tell of edges: their numbers.
#[derive(Default)]
pub struct Candidates {
    /// On the silhouette.
    pub on: Vec<u32>,
    /// Possibly on it: one of its triangles is seen nearly edge-on, or there is no second one.
    pub unknown: Vec<u32>,
}

impl Candidates {
    /// Adds edges of several blocks, given in the order of their groups.
    #[inline(always)]
    pub fn look_through(
        &mut self,
        sight: &Sight,
        blocks: &[Block],
        numbers: &[u32],
        normals: &[[OctNormal; 2]],
    ) {
        let edges = numbers.chunks(GROUP * LANES).zip(normals.chunks(GROUP * LANES));
        for (block, (numbers, normals)) in blocks.iter().zip(edges) {
            let mut open = block.not_seen_from_one_side(sight);
            while open != 0 {
                let group = open.trailing_zeros() as usize;
                open &= open - 1;
                let first = group * GROUP;
                if first >= numbers.len() {
                    break;
                }
                let end = numbers.len().min(first + GROUP);
                let (towards, radius) = block.towards(group, sight);
                self.look_at(towards, radius, &numbers[first..end], &normals[first..end]);
            }
        }
    }

    /// Adds edges of a group.
    #[inline(always)]
    fn look_at(&mut self, towards: DVec3, radius: f64, numbers: &[u32], normals: &[[OctNormal; 2]]) {
        let mut all = [OctNormal::NONE; LANES];
        all[..2 * normals.len()].copy_from_slice(normals.as_flattened());
        let (certain, behind) = sides(towards, radius, &all);
        // Of two bits an edge, the first one tells.
        let edges = 0x5555_5555 & ((1 << (2 * numbers.len())) - 1);
        let known = certain & certain >> 1;
        push(&mut self.unknown, numbers, edges & !known);
        push(&mut self.on, numbers, edges & known & (behind ^ behind >> 1));
    }
}

/// Adds the edges of the group whose first bits are set.
#[inline(always)]
fn push(to: &mut Vec<u32>, numbers: &[u32], mut bits: u32) {
    while bits != 0 {
        to.push(numbers[bits.trailing_zeros() as usize / 2]);
        bits &= bits - 1;
    }
}

/// For the normals beside the edges of a group: of which the viewer is certainly not nearly in the plane, and for these, behind which it
/// is, one bit each.
#[inline(always)]
fn sides(towards: DVec3, radius: f64, normals: &[OctNormal; LANES]) -> (u32, u32) {
    let distance = towards.length();
    let towards = (towards / distance).as_vec3();
    // How far from a plane through the middle of the group the viewer is at least, if the angle between that through the first end of
    // each edge and its line of sight is more than what is demanded, and what rounding makes of it.
    let radius = radius / distance;
    let least = (radius + (LEAST_ANGLE + ROUNDING) * (1.0 + radius)) as f32;
    let (mut is_certain, mut is_behind) = ([false; LANES], [false; LANES]);
    for lane in 0..LANES {
        // Not longer than 1, but possibly shorter.
        let [x, y, z] = normals[lane].decode();
        let across = x * towards.x + y * towards.y + z * towards.z;
        is_certain[lane] = (across.abs() > least) & (normals[lane] != OctNormal::NONE);
        is_behind[lane] = across < 0.0;
    }
    (bits(&is_certain), bits(&is_behind))
}

/// One bit for each lane.
#[inline(always)]
fn bits(lanes: &[bool; LANES]) -> u32 {
    let mut bits = 0;
    for (lane, &is_set) in lanes.iter().enumerate() {
        bits |= u32::from(is_set) << lane;
    }
    bits
}
