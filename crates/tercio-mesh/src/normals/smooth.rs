//! The normals of vertices in the middle of a smooth surface, which is where nearly all vertices are.
//!
//! Looks at each triangle once and needs no list of the triangles at a vertex. A vertex is settled here if the
//! triangles round it close up to one ring and their normals differ by less than any crease; whether that is so
//! follows from a few sums ([`Ring`]). What is not settled goes to [`super::creased`].

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::OctNormal;
use super::encode;
use crate::Mesh;
use crate::blocks::{Block, Blocks, Pool};
use crate::trig::acos_coarse;
use glam::DVec3;

/// Not a normal.
pub(super) const UNSETTLED: u32 = OctNormal::NONE.0;

/// Triangles that are looked at side by side.
const LANES: usize = 16;

/// The normals that are settled, in the order of the vertices; [`UNSETTLED`] for the others that triangles use,
/// whose numbers come along in no order. Vertices that no triangle uses get +z.
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

/// Settles vertices at the borders of blocks, which have a part of their ring in each of several. Returns those
/// that are not settled.
fn settle_parts(left: &[Left], widest: f32, normals: &[AtomicU32]) -> Vec<u32> {
    // Vertex, block and place there: parts of one vertex are joined in the order of the blocks.
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
    order.par_chunk_by(|a, b| a.0 == b.0).filter_map(unsettled).collect()
}

/// Not a normal either: the vertex was not met yet.
const UNUSED: u32 = 0x8000_0000;

/// Vertices that several blocks took for settled: each of them has a closed ring there.
fn settled_twice(blocks: &Blocks, left: &[Left], normals: &[AtomicU32]) -> Vec<u32> {
    // Hardly any mesh has such vertices, and counting tells.
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
    /// Vertices that are not worth another look here.
    doubtful: Vec<u32>,
}

/// What the triangles round a vertex add up to.
#[derive(Clone, Copy)]
struct Ring {
    /// Unit normals, weighted by the angle at the vertex, and the angles.
    sum: [f64; 4],
    /// Hashes of the next corner of each triangle, less those of the previous one: zero if every edge at the
    /// vertex is the next of one triangle and the previous of another, which makes closed rings.
    ends: u64,
    /// Box of the unit normals; the fourth numbers say nothing.
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

    /// Adds a triangle with its unit normal (and one), the angle at the vertex, and the hashes of the corners
    /// behind and before the vertex.
    #[inline(always)]
    fn add(&mut self, normal: [f64; 4], angle: f64, next: u64, previous: u64) {
        self.ends = self.ends.wrapping_add(next).wrapping_sub(previous);
        for k in 0..4 {
            self.sum[k] += normal[k] * angle;
            let n = normal[k] as f32;
            self.low[k] = if n < self.low[k] { n } else { self.low[k] };
            self.high[k] = if n > self.high[k] { n } else { self.high[k] };
        }
    }

    /// Makes sure that the vertex is not settled: a triangle without area says nothing about it.
    #[cold]
    fn spoil(&mut self) {
        (self.low, self.high) = ([f32::NEG_INFINITY; 4], [f32::INFINITY; 4]);
    }

    /// The normal, if the triangles are one closed ring and no two normals are farther apart than `widest`.
    ///
    /// Seen along one of the normals, each closed ring goes round the vertex once or more, by 2 pi at least.
    /// At 40 degrees at most between normals no angle is seen more than 1 / cos 40 times as large as it is, so
    /// two rings have angles of 9.6 or more in all, while a ring on a smooth surface has about 6.3.
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

/// How far the ends of two unit normals may lie apart at a vertex that is settled: by no crease, and by not
/// more than 40 degrees ([`Ring::normal`]). Less than zero where no two normals are close enough.
fn widest_chord(crease_angle: f64) -> f32 {
    // A chord of an angle a is 2 sin(a / 2); the margin is for roundings to `f32`.
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
            [a, b, c].into_iter().for_each(|v| self.rings[v].spoil());
        }
    }

    /// Stores the normals of the vertices that are settled.
    fn settle(&self, block: &Block, widest: f32, normals: &[AtomicU32]) -> Left {
        let mut left = Left::default();
        for (&vertex, ring) in block.vertices.iter().zip(&self.rings) {
            match ring.normal(widest) {
                // Should another block settle it too, it will be settled anew (`settled_twice`).
                Some(normal) => {
                    normals[vertex as usize].store(normal.0, Relaxed);
                    left.settled += 1;
                }
                None => left.open.push((vertex, *ring)),
            }
        }
        // Where triangles share few vertices, hardly a ring would be closed by parts from other blocks.
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
    /// Finds normals and angles from the points. Written without closures, which would not be compiled at the
    /// SIMD level of the caller.
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
            // `f32` squared fits an `f64`, and so does the square of the square (1e-45 to 1e38).
            let (ee, ff, gg) = (dot(e, e), dot(f, f), dot(g, g));
            let area2 = dot(n, n);
            // Where one of them is zero, all is divided by one.
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

/// SplitMix64 of a vertex number: sums of hashes are equal only where the numbers are the same.
#[inline(always)]
fn hash(vertex: u32) -> u64 {
    let z = (u64::from(vertex) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
