//! Grows clusters over neighbouring triangles.
//!
//! A cluster begins with a seed triangle and takes one vertex at a time: the one that waits longest at its
//! rim, those first that close a notch of the outline. Every triangle whose three corners are inside is
//! taken for nothing. The next seed is the most cornered triangle left at the outlines of the last clusters,
//! so that few islands stay behind.

use glam::Vec3;

use super::partition::{Cut, Limits, Span};
use super::rim::Rim;
use crate::blocks::Around;

/// The working memory of one thread.
pub(super) struct Grower {
    around: Around,
    triangles: Table<Triangle>,
    vertices: Table<Vertex>,
    rim: Rim,
    /// Vertices of the open cluster.
    inside: Vec<u16>,
    /// Vertices on the outlines of finished clusters: where seeds are looked for.
    frontier: Vec<u16>,
    /// All triangles, cluster after cluster, and room for one more; only the first count.
    taken: Vec<u16>,
    taken_count: usize,
}

/// Triangles round a vertex that are looked at together; few vertices have more.
const AT_ONCE: usize = 16;

/// One entry for each number of 16 bits, so that looking one up needs no check.
type Table<T> = Box<[T; 1 << 16]>;

/// Vertices of the frontier that a search looks at.
const RECENT: usize = 64;

/// A cluster with room leaps over a gap this many times its own radius, not further.
const FAR: f32 = 8.0;

#[derive(Clone, Copy, Default)]
struct Triangle {
    /// Number of the last cluster that touched it, times 4, plus its corners in there; [`DONE`] once a cluster
    /// has it.
    state: u32,
    /// These corners, combined by exclusive or.
    inside: u16,
    /// All three corners, combined so: with two of them, that gives the third.
    all: u16,
}

const DONE: u32 = u32::MAX;

#[derive(Clone, Copy, Default)]
struct Vertex {
    /// Number of the last cluster that has it, times 256, plus its number in there.
    member: u32,
    /// Number of the last cluster at whose rim it was, times 256, plus the triangles that it completes there.
    at_rim: u32,
    /// Triangles that no cluster has.
    live: u32,
}

impl Default for Grower {
    fn default() -> Self {
        fn table<T: Copy + Default>() -> Table<T> {
            let entries = vec![T::default(); 1 << 16].into_boxed_slice();
            entries.try_into().unwrap_or_else(|_| unreachable!("the table was made with this length"))
        }
        Self {
            around: Around::default(),
            triangles: table(),
            vertices: table(),
            rim: Rim::default(),
            inside: Vec::new(),
            frontier: Vec::new(),
            taken: Vec::new(),
            taken_count: 0,
        }
    }
}

/// A block of triangles, and where its vertices stand.
pub(super) struct Ground<'a> {
    /// Corners of the triangles.
    pub triangles: &'a [[u16; 3]],
    /// Mesh vertex of each vertex.
    pub vertices: &'a [u32],
    /// Positions of the vertices of the mesh.
    pub positions: &'a [[f32; 3]],
}

impl Ground<'_> {
    fn position(&self, vertex: u16) -> Vec3 {
        Vec3::from(self.positions[self.vertices[usize::from(vertex)] as usize])
    }
}

/// The cluster that grows.
struct Open {
    /// Counts from 1.
    number: u32,
    triangles: u32,
}

impl Grower {
    /// All triangles of the block that was cut last, cluster after cluster.
    pub fn taken(&self) -> &[u16] {
        &self.taken[..self.taken_count]
    }

    /// Cuts a block; [`Grower::taken`] and `corners` get its triangles in their new order.
    pub fn cut(&mut self, ground: &Ground, corners: &mut [&mut [u8]; 3], limits: Limits) -> Cut {
        let n = ground.triangles.len();
        let mut cut = Cut::with_capacity(n);
        self.reset(ground);
        let (mut number, mut untouched) = (0, 0);
        while self.taken_count < n {
            let mut seed = Some(self.seed(ground, &mut untouched));
            number += 1;
            let mut open = Open { number, triangles: 0 };
            self.rim.clear();
            self.inside.clear();
            while let Some(triangle) = seed {
                let first = self.taken_count;
                self.grow(ground, triangle, &mut open, limits);
                self.finish(ground, first, corners);
                seed = self.seed_nearby(ground, &open, limits);
            }
            cut.vertices.extend_from_slice(&self.inside);
            cut.clusters.push(Span { vertices: self.inside.len() as u8, triangles: open.triangles as u8 });
            let Self { frontier, inside, vertices, .. } = self;
            frontier.extend(inside.iter().filter(|&&v| vertices[usize::from(v)].live > 0));
        }
        cut
    }

    fn reset(&mut self, ground: &Ground) {
        self.around.fill(ground.triangles, ground.vertices.len());
        for (triangle, &[a, b, c]) in self.triangles.iter_mut().zip(ground.triangles) {
            *triangle = Triangle { all: a ^ b ^ c, ..Triangle::default() };
        }
        for v in 0..ground.vertices.len() {
            let live = self.around.at(v as u16).len() as u32;
            self.vertices[v] = Vertex { live, ..Vertex::default() };
        }
        self.frontier.clear();
        self.taken.clear();
        self.taken.resize(ground.triangles.len() + 1, 0);
        self.taken_count = 0;
    }

    /// Takes a triangle, which must find room, and all that comes after it until the cluster is full or its
    /// rim is empty.
    fn grow(&mut self, ground: &Ground, seed: u16, open: &mut Open, limits: Limits) {
        for v in ground.triangles[usize::from(seed)] {
            if self.vertices[usize::from(v)].member >> 8 != open.number {
                self.take(v, open, limits);
            }
        }
        while self.inside.len() < limits.vertices as usize && open.triangles < limits.triangles {
            let Some(vertex) = self.rim.pop() else { return };
            if self.vertices[usize::from(vertex)].member >> 8 != open.number {
                self.take(vertex, open, limits);
            }
        }
    }

    /// Takes a vertex and every triangle that it completes.
    #[inline]
    fn take(&mut self, vertex: u16, open: &mut Open, limits: Limits) {
        let Self { around, triangles, vertices, rim, inside, taken, taken_count, .. } = self;
        vertices[usize::from(vertex)].member = open.number << 8 | inside.len() as u32;
        inside.push(vertex);
        for around in around.at(vertex).chunks(AT_ONCE) {
            // Arithmetic instead of branches, because how many corners are inside cannot be predicted: what comes
            // to a list is written behind it, and the list grows by it or by nothing.
            let (mut lacking, mut lacking_count) = ([0; AT_ONCE], 0);
            for &t in around {
                let triangle = &mut triangles[usize::from(t)];
                // A done triangle stays [`DONE`], all ones, and counts nothing.
                let is_done = triangle.state == DONE;
                let known = u32::from(triangle.state >> 2 == open.number);
                let count = (triangle.state & 3) * known + 1;
                let corners = (triangle.inside * known as u16) ^ vertex;
                let is_taken = (count == 3) & !is_done & (open.triangles < limits.triangles);
                triangle.state = (open.number << 2 | count) | u32::from(is_done | is_taken).wrapping_neg();
                triangle.inside = corners;
                lacking[lacking_count % AT_ONCE] = corners ^ triangle.all;
                lacking_count += usize::from((count == 2) & !is_done);
                taken[*taken_count] = t;
                *taken_count += usize::from(is_taken);
                open.triangles += u32::from(is_taken);
            }
            for &lacks in &lacking[..lacking_count] {
                reach(rim, vertices, lacks, open.number);
            }
        }
    }

    /// Writes the corners of the open cluster's triangles from the `first` on.
    fn finish(&mut self, ground: &Ground, first: usize, [a, b, c]: &mut [&mut [u8]; 3]) {
        let taken = &self.taken[first..self.taken_count];
        let corners = a[first..].iter_mut().zip(&mut b[first..]).zip(&mut c[first..]);
        for (&t, ((a, b), c)) in taken.iter().zip(corners) {
            let triangle = ground.triangles[usize::from(t)];
            for (v, corner) in triangle.into_iter().zip([a, b, c]) {
                let v = &mut self.vertices[usize::from(v)];
                v.live -= 1;
                *corner = v.member as u8;
            }
        }
    }

    /// A triangle to begin with.
    fn seed(&mut self, ground: &Ground, untouched: &mut usize) -> u16 {
        self.sweep();
        if let Some(v) = self.recent().min_by_key(|&v| self.vertices[usize::from(v)].live)
            && let Some(t) = self.seed_at(ground, v)
        {
            return t;
        }
        while self.triangles[*untouched].state == DONE {
            *untouched += 1;
        }
        *untouched as u16
    }

    /// A triangle to go on with, near a cluster that has room but nothing at its rim.
    fn seed_nearby(&mut self, ground: &Ground, open: &Open, limits: Limits) -> Option<u16> {
        if self.inside.len() + 3 > limits.vertices as usize || open.triangles >= limits.triangles {
            return None;
        }
        self.sweep();
        let sum: Vec3 = self.inside.iter().map(|&v| ground.position(v)).sum();
        let center = sum / self.inside.len() as f32;
        let distance2 = |v: u16| ground.position(v).distance_squared(center);
        let reach2 = self.inside.iter().map(|&v| distance2(v)).fold(0.0, f32::max);
        let (nearest2, nearest) =
            self.recent().map(|v| (distance2(v), v)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if nearest2 > FAR * FAR * reach2 {
            return None;
        }
        self.seed_at(ground, nearest)
    }

    /// The triangle at a vertex whose corners have the fewest triangles left.
    fn seed_at(&self, ground: &Ground, vertex: u16) -> Option<u16> {
        let around = self.around.at(vertex).iter().copied();
        around.filter(|&t| self.triangles[usize::from(t)].state != DONE).min_by_key(|&t| {
            let corners = ground.triangles[usize::from(t)];
            corners.iter().map(|&v| self.vertices[usize::from(v)].live).sum::<u32>()
        })
    }

    /// Drops vertices without triangles from the end of the frontier.
    fn sweep(&mut self) {
        loop {
            let begin = self.frontier.len().saturating_sub(RECENT);
            let mut kept = begin;
            for i in begin..self.frontier.len() {
                let v = self.frontier[i];
                if self.vertices[usize::from(v)].live > 0 {
                    self.frontier[kept] = v;
                    kept += 1;
                }
            }
            self.frontier.truncate(kept);
            if kept > begin || begin == 0 {
                return;
            }
        }
    }

    fn recent(&self) -> impl Iterator<Item = u16> {
        let begin = self.frontier.len().saturating_sub(RECENT);
        self.frontier[begin..].iter().copied()
    }
}

/// Notes at the rim the vertex that a triangle with two corners inside still lacks.
#[inline]
fn reach(rim: &mut Rim, vertices: &mut Table<Vertex>, lacks: u16, number: u32) {
    let vertex = &mut vertices[usize::from(lacks)];
    if vertex.member >> 8 == number {
        // None is missing: the triangle has a corner twice.
        return;
    }
    let before = (vertex.at_rim & 0xff) * u32::from(vertex.at_rim >> 8 == number);
    // More than a cluster has triangles are never completed at once.
    let completes = (before + 1).min(0xff);
    vertex.at_rim = number << 8 | completes;
    rim.push(lacks, completes, completes == vertex.live);
}
