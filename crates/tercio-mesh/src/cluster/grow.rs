//! Grows clusters over neighbouring triangles.
//!
//! A cluster begins with a seed triangle and takes one vertex at a time: the one of its rim that lies
//! nearest to its middle, those first that close a notch of the outline. Every triangle whose three corners
//! are inside is taken for nothing. The next seed is the most cornered triangle left at the outlines of the
//! last clusters, so that few islands stay behind.

use super::local::LocalMesh;
use super::partition::{Cut, Limits, Span};
use super::rim::Rim;

/// The working memory of one thread.
#[derive(Default)]
pub(super) struct Grower {
    pub mesh: LocalMesh,
    /// Of each triangle: number of the last cluster that touched it, times 4, plus its corners in there;
    /// [`DONE`] once a cluster has it.
    state: Vec<u32>,
    /// Of each vertex.
    vertices: Vec<Vertex>,
    rim: Rim,
    /// Vertices of the open cluster.
    inside: Vec<u16>,
    /// Vertices on the outlines of finished clusters: where seeds are looked for.
    frontier: Vec<u16>,
    /// All triangles, cluster after cluster.
    pub taken: Vec<u16>,
}

const DONE: u32 = u32::MAX;

/// Vertices of the frontier that a search looks at.
const RECENT: usize = 64;

/// A cluster with room leaps over a gap this many times its own radius, not further.
const FAR: f32 = 8.0;

#[derive(Clone, Copy, Default)]
struct Vertex {
    /// Number of the last cluster that has it, times 256, plus its number in there.
    member: u32,
    /// Number of the last cluster at whose rim it was, times 256, plus its place there.
    at_rim: u32,
    /// Triangles that no cluster has.
    live: u32,
    /// Triangles that it would complete for the cluster in `at_rim`.
    completes: u32,
}

/// The cluster that grows.
#[derive(Default)]
struct Open {
    /// Counts from 1.
    number: u32,
    triangles: u32,
    /// Sum of the vertices' positions.
    sum: [f32; 3],
    /// Sum of the triangles' unit normals.
    normal: [f32; 3],
}

impl Grower {
    /// Cuts the block that stands in `mesh`; `taken` and `corners` get its triangles in their new order.
    pub fn cut(&mut self, corners: &mut [&mut [u8]; 3], limits: Limits) -> Cut {
        let n = self.mesh.triangles.len();
        let mut cut = Cut::with_capacity(n);
        self.reset();
        let (mut number, mut untouched) = (0, 0);
        while self.taken.len() < n {
            let mut seed = Some(self.seed(&mut untouched));
            number += 1;
            let mut open = Open { number, ..Open::default() };
            self.rim.clear();
            self.inside.clear();
            while let Some(triangle) = seed {
                self.grow(triangle, &mut open, limits, corners);
                seed = self.seed_nearby(&open, limits);
            }
            cut.vertices.extend(self.inside.iter().map(|&v| self.mesh.vertices[usize::from(v)]));
            cut.clusters.push(Span { vertices: self.inside.len() as u8, triangles: open.triangles as u8 });
            let Self { frontier, inside, vertices, .. } = self;
            frontier.extend(inside.iter().filter(|&&v| vertices[usize::from(v)].live > 0));
        }
        cut
    }

    fn reset(&mut self) {
        self.state.clear();
        self.state.resize(self.mesh.triangles.len(), 0);
        self.vertices.clear();
        self.vertices.extend((0..self.mesh.vertices.len()).map(|v| {
            let live = self.mesh.around(v as u16).len() as u32;
            Vertex { live, ..Vertex::default() }
        }));
        self.frontier.clear();
        self.taken.clear();
    }

    /// Takes a triangle, which must find room, and all that comes after it until the cluster is full or its
    /// rim is empty.
    fn grow(&mut self, seed: u16, open: &mut Open, limits: Limits, corners: &mut [&mut [u8]; 3]) {
        for v in self.mesh.triangles[usize::from(seed)] {
            if self.vertices[usize::from(v)].member >> 8 != open.number {
                self.take(v, open, limits, corners);
            }
        }
        while self.inside.len() < limits.vertices as usize && open.triangles < limits.triangles {
            let scale = 1.0 / self.inside.len() as f32;
            // As much as the square of the radius that so many triangles fill.
            let square = self.mesh.area * open.triangles as f32;
            let center = open.sum.map(|s| s * scale);
            let Some(place) = self.rim.best(center, direction(open.normal), square) else { return };
            self.take(self.rim.vertex(place), open, limits, corners);
        }
    }

    /// Takes a vertex and every triangle that it completes.
    fn take(&mut self, vertex: u16, open: &mut Open, limits: Limits, corners: &mut [&mut [u8]; 3]) {
        let v = &mut self.vertices[usize::from(vertex)];
        v.member = open.number << 8 | self.inside.len() as u32;
        self.inside.push(vertex);
        let p = self.mesh.positions[usize::from(vertex)];
        open.sum.iter_mut().zip(p).for_each(|(s, p)| *s += p);
        if v.at_rim >> 8 == open.number {
            let place = v.at_rim & 0xff;
            if let Some(moved) = self.rim.remove(place as usize) {
                self.vertices[usize::from(moved)].at_rim = open.number << 8 | place;
            }
            self.vertices[usize::from(vertex)].at_rim = 0;
        }
        for &t in self.mesh.around(vertex) {
            // Arithmetic instead of branches that go either way: a done triangle stays [`DONE`], all ones,
            // and counts nothing.
            let state = &mut self.state[usize::from(t)];
            let done = u32::from(*state == DONE).wrapping_neg();
            let before = (*state & 3) * u32::from(*state >> 2 == open.number);
            *state = (open.number << 2 | (before + 1)) | done;
            let c = match (before + 1) & !done {
                2 | 3 => self.mesh.triangles[usize::from(t)],
                _ => continue,
            };
            match before + 1 {
                2 => reach(&mut self.rim, &mut self.vertices, &self.mesh, t, open.number),
                3 if open.triangles < limits.triangles => {
                    *state = DONE;
                    let place = self.taken.len();
                    self.taken.push(t);
                    open.triangles += 1;
                    let normal = self.mesh.normals[usize::from(t)];
                    for k in 0..3 {
                        open.normal[k] += normal[k];
                        let v = &mut self.vertices[usize::from(c[k])];
                        v.live -= 1;
                        corners[k][place] = v.member as u8;
                    }
                }
                _ => {}
            }
        }
    }

    /// A triangle to begin with.
    fn seed(&mut self, untouched: &mut usize) -> u16 {
        self.sweep();
        if let Some(v) = self.recent().min_by_key(|&v| self.vertices[usize::from(v)].live)
            && let Some(t) = self.seed_at(v)
        {
            return t;
        }
        while self.state[*untouched] == DONE {
            *untouched += 1;
        }
        *untouched as u16
    }

    /// A triangle to go on with, near a cluster that has room but nothing at its rim.
    fn seed_nearby(&mut self, open: &Open, limits: Limits) -> Option<u16> {
        if self.inside.len() + 3 > limits.vertices as usize || open.triangles >= limits.triangles {
            return None;
        }
        self.sweep();
        let center = open.sum.map(|s| s / self.inside.len() as f32);
        let distance = |v: u16| {
            let p = self.mesh.positions[usize::from(v)];
            (0..3).map(|k| (p[k] - center[k]) * (p[k] - center[k])).sum::<f32>()
        };
        let nearest = self.recent().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
        let reach = self.inside.iter().map(|&v| distance(v)).fold(0.0, f32::max);
        if distance(nearest) > FAR * FAR * reach {
            return None;
        }
        self.seed_at(nearest)
    }

    /// The triangle at a vertex whose corners have the fewest triangles left.
    fn seed_at(&self, vertex: u16) -> Option<u16> {
        let around = self.mesh.around(vertex).iter().copied();
        around.filter(|&t| self.state[usize::from(t)] != DONE).min_by_key(|&t| {
            let corners = self.mesh.triangles[usize::from(t)];
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
fn reach(rim: &mut Rim, vertices: &mut [Vertex], mesh: &LocalMesh, triangle: u16, number: u32) {
    let corners = mesh.triangles[usize::from(triangle)];
    let inside = |k: usize| usize::from(vertices[usize::from(corners[k])].member >> 8 == number);
    // Arithmetic, because the place of the missing corner cannot be predicted.
    let v = corners[inside(0) * (1 + inside(1))];
    let vertex = &mut vertices[usize::from(v)];
    if vertex.member >> 8 == number {
        // None is missing: the triangle has a corner twice.
        return;
    }
    if vertex.at_rim >> 8 != number {
        if rim.is_full() {
            return;
        }
        let place = rim.push(v, mesh.positions[usize::from(v)], mesh.normals[usize::from(triangle)]);
        vertex.at_rim = number << 8 | place as u32;
        vertex.completes = 0;
    }
    vertex.completes += 1;
    rim.weigh((vertex.at_rim & 0xff) as usize, vertex.completes, vertex.completes == vertex.live);
}

/// The vector at unit length; zero stays zero.
#[inline]
fn direction(v: [f32; 3]) -> [f32; 3] {
    let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let scale = 1.0 / square.sqrt().max(1e-30);
    v.map(|x| x * scale)
}
