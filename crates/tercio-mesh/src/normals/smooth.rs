//! The normals of vertices in the interior of a smooth surface, which are nearly all vertices.
//!
//! Reads each triangle once and needs no list of the triangles at a vertex. A vertex is settled here if the triangles
//! around it form one closed ring and their normals differ by less than the crease angle, which a few sums can prove
//! ([`Ring`]). The other vertices are passed to [`super::creased`].

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::loops::prelude::*;
use fearless_simd::{Level, dispatch};

use super::OctNormal;
use super::encode;
use crate::Mesh;
use crate::blocks::{Block, Blocks, Pool};
use crate::trig::acos_coarse;
use glam::DVec3;

/// Marks a vertex whose normal is still to be computed.
pub(super) const UNSETTLED: u32 = OctNormal::NONE.0;

/// Triangles that are processed side by side.
const LANES: usize = 16;

/// The normals that are settled, in the order of the vertices; [`UNSETTLED`] for the others that triangles use, whose
/// numbers are returned, too, in no particular order. Vertices that no triangle uses get +z.
pub(super) fn settle(mesh: &Mesh, blocks: &Blocks, crease_angle: f64) -> (Vec<OctNormal>, Vec<u32>) {
    let normals: Vec<AtomicU32> =
        (0..mesh.positions.len()).into_par_iter().map(|_| AtomicU32::new(UNUSED)).collect();
    let widest = widest_chord(crease_angle);
    let level = Level::new();
    let pool = Pool::default();
    let left: Vec<Left> = blocks
        .list
        .par_iter()
        .with_max_len(1)
        .map(|block| {
            let mut rings: Rings = pool.take();
            dispatch!(level, _ => rings.fill(mesh, block, &blocks.corners[block.range()]));
            let left = rings.settle(block, widest, &normals);
            pool.give(rings);
            left
        })
        .collect();

    let mut doubtful = settled_twice(blocks, &left, &normals);
    left.iter().for_each(|left| doubtful.extend(&left.doubtful));
    doubtful.extend(settle_parts(&left, widest, &normals));
    for &vertex in &doubtful {
        normals[vertex as usize].store(UNSETTLED, Relaxed);
    }
    let settled = |n: AtomicU32| match n.into_inner() {
        UNUSED => OctNormal::default(),
        n => OctNormal(n),
    };
    (normals.into_par_iter().map(settled).collect(), doubtful)
}

/// Settles vertices at the borders of blocks, whose ring is divided between several blocks. Returns those that are
/// not settled.
fn settle_parts(left: &[Left], widest: f32, normals: &[AtomicU32]) -> Vec<u32> {
    // Vertex, block and index there: parts of one vertex are joined in the order of the blocks.
    let parts = left.par_iter().zip(0u32..left.len() as u32);
    let parts =
        parts.flat_map_iter(|(left, block)| (0u32..).zip(&left.open).map(move |(i, p)| (p.0, block, i)));
    let mut order: Vec<(u32, u32, u32)> = parts.collect();
    order.par_sort_unstable();
    let unsettled = |group: &[(u32, u32, u32)]| {
        let part = |&(_, block, i): &(u32, u32, u32)| &left[block as usize].open[i as usize].1;
        let ring = group.iter().fold(Ring::EMPTY, |ring, at| ring.joined(part(at)));
        let vertex = group[0].0;
        let normal = &normals[vertex as usize];
        match ring.normal(widest) {
            Some(n) if normal.load(Relaxed) == UNUSED => {
                normal.store(n.0, Relaxed);
                None
            }
            _ => Some(vertex),
        }
    };
    let groups: Vec<_> = order.chunk_by(|a, b| a.0 == b.0).collect();
    groups.into_par_iter().filter_map(unsettled).collect()
}

/// Also not a normal: the vertex has not occurred yet.
const UNUSED: u32 = 0x8000_0000;

/// Vertices that several blocks settled: each of them has a closed ring there.
fn settled_twice(blocks: &Blocks, left: &[Left], normals: &[AtomicU32]) -> Vec<u32> {
    // Such vertices are rare, and comparing counts shows whether there are any.
    let settled: usize = left.iter().map(|l| l.settled).sum();
    if settled == normals.par_iter().filter(|n| n.load(Relaxed) != UNUSED).count() {
        return Vec::new();
    }
    let mut times = vec![0u8; normals.len()];
    for (block, left) in blocks.list.iter().zip(left) {
        let mut others: Vec<u32> =
            left.open.iter().map(|part| part.0).chain(left.doubtful.iter().copied()).collect();
        others.sort_unstable();
        for &v in block.vertices.iter().filter(|v| others.binary_search(v).is_err()) {
            times[v as usize] = times[v as usize].saturating_add(1);
        }
    }
    (0..).zip(times).filter(|(_, times)| *times > 1).map(|(v, _)| v).collect()
}

/// What a block leaves unsettled.
#[derive(Default)]
struct Left {
    /// Number of vertices that it settled.
    settled: usize,
    /// Vertices whose triangles in the block make no smooth closed ring.
    open: Vec<(u32, Ring)>,
    /// Vertices that are not worth a second attempt here.
    doubtful: Vec<u32>,
}

/// Adding this to an angle and subtracting it rounds the angle to a multiple of 2^-48, the distance of the numbers from 16 to
/// 32. Sums of such numbers below 32 are exact.
const ROUNDING: f64 = 24.0;

/// Sums over the triangles around a vertex.
#[derive(Clone, Copy)]
struct Ring {
    /// Unit normals, weighted by the angle at the vertex, and the angles. All terms are multiples of 2^-48, so sums up to 9,
    /// the largest that a normal is made from, are exact: they do not depend on how the triangles are divided into blocks, or
    /// among ranks.
    sum: [f64; 4],
    /// Sum of the hashes of the next corner of each triangle minus those of the previous one: zero if every edge at
    /// the vertex is the next of one triangle and the previous of another, as in closed rings.
    ends: u64,
    /// Box of the unit normals; the fourth components are meaningless.
    low: [f32; 4],
    /// Upper corner of the box.
    high: [f32; 4],
}

impl Ring {
    const EMPTY: Self =
        Self { sum: [0.0; 4], ends: 0, low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    fn joined(mut self, other: &Self) -> Self {
        self.ends = self.ends.wrapping_add(other.ends);
        for k in 0..4 {
            self.sum[k] += other.sum[k];
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
        self
    }

    /// Adds a triangle with its unit normal (and a fourth component 1), the angle at the vertex, and the hashes of
    /// the corners after and before the vertex.
    #[inline(always)]
    fn add(&mut self, normal: [f64; 4], angle: f64, next: u64, previous: u64) {
        self.ends = self.ends.wrapping_add(next).wrapping_sub(previous);
        for k in 0..4 {
            self.sum[k] += (normal[k] * angle + ROUNDING) - ROUNDING;
            let n = normal[k] as f32;
            self.low[k] = if n < self.low[k] { n } else { self.low[k] };
            self.high[k] = if n > self.high[k] { n } else { self.high[k] };
        }
    }

    /// Prevents the vertex from being settled: for a triangle without area.
    #[cold]
    fn invalidate(&mut self) {
        (self.low, self.high) = ([f32::NEG_INFINITY; 4], [f32::INFINITY; 4]);
    }

    /// The normal, if the triangles are one closed ring and no two normals are farther apart than `widest`.
    ///
    /// Seen along one of the normals, each closed ring goes around the vertex once or more, by at least 2 pi. If the
    /// normals differ by at most 40 degrees, no angle appears more than 1 / cos 40 times as large as it is, so the
    /// angles of two rings add up to at least 9.6, while those of one ring on a smooth surface add up to about 6.3.
    #[inline]
    fn normal(&self, widest: f32) -> Option<OctNormal> {
        let [x, y, z, angle] = self.sum;
        let mut chord2 = 0.0;
        for k in 0..3 {
            let edge = self.high[k] - self.low[k];
            chord2 += edge * edge;
        }
        let one_ring = self.ends == 0 && angle > 0.0 && angle < 9.0;
        (one_ring && chord2 <= widest * widest).then(|| encode(DVec3::new(x, y, z)))
    }
}

/// How far the ends of two unit normals may be apart at a vertex that is settled: by no crease, and by at most 40
/// degrees ([`Ring::normal`]). Negative if no two normals are close enough.
fn widest_chord(crease_angle: f64) -> f32 {
    // A chord of an angle a is 2 sin(a / 2); the margin is for rounding to `f32`.
    let chord = |angle: f64| 2.0 * crate::trig::sin_cos(angle / 2.0).0;
    (chord(crease_angle.min(40f64.to_radians())) - 1e-6) as f32
}

/// The rings of a block's vertices; the working memory of one thread.
#[derive(Default)]
struct Rings {
    positions: Vec<[f32; 3]>,
    /// Hashes of the vertices' numbers.
    hashes: Vec<u64>,
    rings: Vec<Ring>,
}

impl Rings {
    #[inline(always)]
    fn fill(&mut self, mesh: &Mesh, block: &Block, corners: &[[u16; 3]]) {
        self.positions.clear();
        self.positions.extend(block.vertices.iter().map(|&v| mesh.positions[v as usize]));
        self.hashes.clear();
        self.hashes.extend(block.vertices.iter().map(|&v| hash(v)));
        self.rings.clear();
        self.rings.resize(block.vertices.len(), Ring::EMPTY);
        let mut terms = Terms::default();
        for corners in corners.chunks(LANES) {
            for (lane, corners) in corners.iter().enumerate() {
                for k in 0..3 {
                    let p = self.positions[usize::from(corners[k])];
                    for axis in 0..3 {
                        terms.points[k][axis][lane] = p[axis];
                    }
                }
            }
            terms.find();
            for (lane, corners) in corners.iter().enumerate() {
                self.add(*corners, &terms, lane);
            }
        }
    }

    #[inline(always)]
    fn add(&mut self, corners: [u16; 3], terms: &Terms, lane: usize) {
        let [a, b, c] = [usize::from(corners[0]), usize::from(corners[1]), usize::from(corners[2])];
        let [x, y, z] = [self.hashes[a], self.hashes[b], self.hashes[c]];
        let normal = [terms.normal[0][lane], terms.normal[1][lane], terms.normal[2][lane], 1.0];
        self.rings[a].add(normal, terms.angles[0][lane], y, z);
        self.rings[b].add(normal, terms.angles[1][lane], z, x);
        self.rings[c].add(normal, terms.angles[2][lane], x, y);
        if !terms.has_area[lane] {
            [a, b, c].into_iter().for_each(|v| self.rings[v].invalidate());
        }
    }

    /// Stores the normals of the vertices that are settled.
    fn settle(&self, block: &Block, widest: f32, normals: &[AtomicU32]) -> Left {
        let mut left = Left::default();
        for (&vertex, ring) in block.vertices.iter().zip(&self.rings) {
            match ring.normal(widest) {
                // If another block settles it too, it is computed again (`settled_twice`).
                Some(normal) => {
                    normals[vertex as usize].store(normal.0, Relaxed);
                    left.settled += 1;
                }
                None => left.open.push((vertex, *ring)),
            }
        }
        // Where triangles share few vertices, parts from other blocks would close hardly any ring.
        if left.open.len() > block.vertices.len() / 2 {
            left.doubtful.extend(left.open.iter().map(|part| part.0));
            left.open = Vec::new();
        }
        left
    }
}

/// Unit normals and angles of some triangles side by side.
#[derive(Default)]
struct Terms {
    /// Coordinates: corner, axis, triangle.
    points: [[[f32; LANES]; 3]; 3],
    /// Unit normals; zero without area.
    normal: [[f64; LANES]; 3],
    /// Angles at the three corners; zero without area.
    angles: [[f64; LANES]; 3],
    has_area: [bool; LANES],
}

impl Terms {
    /// Computes normals and angles from the points. Written without closures, which would not be compiled at the SIMD
    /// level of the caller.
    #[inline(always)]
    fn find(&mut self) {
        let [a, b, c] = &self.points;
        for i in 0..LANES {
            let a = [f64::from(a[0][i]), f64::from(a[1][i]), f64::from(a[2][i])];
            let b = [f64::from(b[0][i]), f64::from(b[1][i]), f64::from(b[2][i])];
            let c = [f64::from(c[0][i]), f64::from(c[1][i]), f64::from(c[2][i])];
            let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
            let g = [c[0] - b[0], c[1] - b[1], c[2] - b[2]];
            let n = [e[1] * f[2] - f[1] * e[2], e[2] * f[0] - f[2] * e[0], e[0] * f[1] - f[0] * e[1]];
            // The square of an `f32` fits an `f64`, and so does the square of that (1e-45 to 1e38).
            let (ee, ff, gg) = (dot(e, e), dot(f, f), dot(g, g));
            let area2 = dot(n, n);
            // Where one of them is zero, all are divided by one.
            let has_area = area2 > 0.0 && ee * ff > 0.0 && ee * gg > 0.0 && ff * gg > 0.0;
            let divisor = |d: f64| if has_area { d.sqrt() } else { 1.0 };
            let length = divisor(area2);
            let cosines =
                [dot(e, f) / divisor(ee * ff), -dot(e, g) / divisor(ee * gg), dot(f, g) / divisor(ff * gg)];
            for k in 0..3 {
                self.normal[k][i] = if has_area { n[k] / length } else { 0.0 };
                self.angles[k][i] = if has_area { acos_coarse(cosines[k]) } else { 0.0 };
            }
            self.has_area[i] = has_area;
        }
    }
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// SplitMix64 of a vertex number: sums of hashes are equal only if the numbers are the same.
#[inline(always)]
fn hash(vertex: u32) -> u64 {
    let z = (u64::from(vertex) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
