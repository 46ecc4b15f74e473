//! Grows clusters over neighbouring triangles.
//!
//! A cluster begins with a seed triangle and takes one vertex at a time: the one that came to its rim first,
//! preferring those that close a notch of the outline. Every triangle whose three corners are inside is taken for
//! free. The next seed is the free triangle on the outlines of the last clusters whose corners have the fewest free
//! triangles, so that few islands are left over.

use glam::Vec3;

use super::gather;
use super::partition::{Cut, Limits};
use super::rim::Rim;
use crate::blocks::{Around, Corner};

/// The working memory of one thread.
pub(super) struct Grower {
    around: Around,
    /// For each triangle: 1 while it belongs to no cluster, then 0.
    free: Table<u8>,
    /// For each vertex: 1 if it is in the open cluster, else 0.
    inside: Table<u8>,
    /// Number of each vertex in the last cluster that took it.
    numbers: Table<u8>,
    /// Number of triangles at each vertex that belong to no cluster.
    live: Table<u16>,
    rim: Rim,
    /// Vertices of the open cluster.
    members: Vec<u16>,
    /// Vertices on the outlines of finished clusters: candidates for seeds.
    frontier: Vec<u16>,
    /// All triangles, cluster after cluster; only the first `taken_count` are valid.
    taken: Table<u16>,
    taken_count: usize,
}

/// Most triangles around a vertex that are scanned in one pass; few vertices have more.
const AT_ONCE: usize = 16;

/// One entry for every 16-bit number, so that indexing needs no bounds check.
type Table<T> = Box<[T; 1 << 16]>;

/// Vertices at the end of the frontier that a search for a seed considers.
const RECENT: usize = 64;

/// A cluster with room left may continue across a gap of at most this many times its own radius.
const FAR: f32 = 8.0;

impl Default for Grower {
    fn default() -> Self {
        fn table<T: Copy + Default>() -> Table<T> {
            let entries = vec![T::default(); 1 << 16].into_boxed_slice();
            entries.try_into().unwrap_or_else(|_| unreachable!("the table was made with this length"))
        }
        Self {
            around: Around::default(),
            free: table(),
            inside: table(),
            numbers: table(),
            live: table(),
            rim: Rim::default(),
            members: Vec::new(),
            frontier: Vec::new(),
            taken: table(),
            taken_count: 0,
        }
    }
}

/// A block of triangles, and the positions of its vertices.
pub(super) struct Ground<'a> {
    /// Corners of the triangles.
    pub triangles: &'a [[u16; 3]],
    /// Mesh vertex of each vertex.
    pub vertices: &'a [u32],
    /// Positions of the mesh's vertices.
    pub positions: &'a [[f32; 3]],
}

impl Ground<'_> {
    fn position(&self, vertex: u16) -> Vec3 {
        Vec3::from(self.positions[self.vertices[usize::from(vertex)] as usize])
    }
}

/// Triangles of the open cluster, and how many more it may take.
struct Open {
    triangles: u32,
    room: u32,
}

/// Result of scanning the triangles around a new vertex.
struct Found {
    /// The third vertices of triangles with two corners inside; only the first `lacking_count` are valid.
    lacking: [u16; AT_ONCE],
    lacking_count: usize,
    /// Number of triangles taken so far.
    taken: usize,
}

impl Found {
    /// Scans triangles around a vertex, and takes those with all corners inside; if `LIMITED`, until `most` are
    /// taken.
    ///
    /// Uses arithmetic instead of branches, because the number of corners inside cannot be predicted: a candidate is
    /// always written after the end of its list, and the length grows by 1 or 0.
    #[inline(always)]
    fn scan<const LIMITED: bool>(
        &mut self,
        corners: &[Corner],
        inside: &[u8; 1 << 16],
        free: &mut [u8; 1 << 16],
        taken: &mut [u16; 1 << 16],
        most: usize,
    ) {
        for &Corner { next, previous, triangle } in corners {
            let t = usize::from(triangle);
            let is_free = free[t];
            let (has_next, has_previous) = (inside[usize::from(next)], inside[usize::from(previous)]);
            let mut completes = has_next & has_previous & is_free;
            if LIMITED {
                completes &= u8::from(self.taken < most);
            }
            self.lacking[self.lacking_count % AT_ONCE] = if has_next == 1 { previous } else { next };
            self.lacking_count += usize::from((has_next ^ has_previous) & is_free);
            taken[self.taken % (1 << 16)] = triangle;
            self.taken += usize::from(completes);
            free[t] = is_free ^ completes;
        }
    }
}

impl Grower {
    /// Splits a block into clusters, and sorts the mesh numbers of its triangles by cluster.
    pub fn cut(&mut self, ground: &Ground, order: &mut [u32], limits: Limits) -> Cut {
        let n = ground.triangles.len();
        let mut cut = Cut::new(n);
        let old = order.to_vec();
        self.reset(ground);
        let mut untouched = 0;
        while self.taken_count < n {
            let mut seed = Some(self.seed(ground, &mut untouched));
            let mut open = Open { triangles: 0, room: limits.triangles };
            self.rim.clear();
            while let Some(triangle) = seed {
                let first = self.taken_count;
                self.grow(ground, triangle, &mut open, limits);
                self.finish(ground, first, &mut cut.corners);
                seed = self.seed_nearby(ground, &open, limits);
            }
            cut.vertices.extend_from_slice(&self.members);
            let own = self.taken_count - open.triangles as usize..self.taken_count;
            for (number, &taken) in order[own.clone()].iter_mut().zip(&self.taken[own.clone()]) {
                *number = old[usize::from(taken)];
            }
            cut.clusters.push(gather::head(self.members.len() as u8, order[own].iter().copied()));
            self.close();
        }
        cut
    }

    fn reset(&mut self, ground: &Ground) {
        self.around.fill(ground.triangles, ground.vertices.len());
        self.free[..ground.triangles.len()].fill(1);
        for v in 0..ground.vertices.len() {
            self.live[v] = self.around.at(v as u16).len() as u16;
        }
        self.frontier.clear();
        self.taken_count = 0;
    }

    /// Finishes the open cluster.
    fn close(&mut self) {
        for vertex in self.members.drain(..) {
            self.inside[usize::from(vertex)] = 0;
            if self.live[usize::from(vertex)] > 0 {
                self.frontier.push(vertex);
            }
        }
    }

    /// Takes a triangle, for which there must be room, and grows from it until the cluster is full or its rim is
    /// empty.
    fn grow(&mut self, ground: &Ground, seed: u16, open: &mut Open, limits: Limits) {
        for v in ground.triangles[usize::from(seed)] {
            if self.inside[usize::from(v)] == 0 {
                self.take(v, open);
            }
        }
        while self.members.len() < limits.vertices as usize && open.room > 0 {
            let Some(vertex) = self.rim.pop() else { return };
            if self.inside[usize::from(vertex)] == 0 {
                self.take(vertex, open);
            }
        }
    }

    /// Takes a vertex and every triangle that it completes.
    #[inline]
    fn take(&mut self, vertex: u16, open: &mut Open) {
        self.inside[usize::from(vertex)] = 1;
        self.numbers[usize::from(vertex)] = self.members.len() as u8;
        self.members.push(vertex);
        // The tables are borrowed once, so that their addresses stay in registers during the writes.
        let Self { around, rim, taken_count, .. } = self;
        let (inside, live) = (&*self.inside, &*self.live);
        let (free, taken) = (&mut *self.free, &mut *self.taken);
        for corners in around.at(vertex).chunks(AT_ONCE) {
            let place = *taken_count;
            let mut found = Found { lacking: [0; AT_ONCE], lacking_count: 0, taken: place };
            if open.room >= AT_ONCE as u32 {
                found.scan::<false>(corners, inside, free, taken, usize::MAX);
            } else {
                found.scan::<true>(corners, inside, free, taken, place + open.room as usize);
            }
            *taken_count = found.taken;
            open.triangles += (found.taken - place) as u32;
            open.room -= (found.taken - place) as u32;
            for &vertex in &found.lacking[..found.lacking_count] {
                rim.reach(vertex, live[usize::from(vertex)]);
            }
        }
    }

    /// Writes the corners of the open cluster's triangles, from number `first` on.
    fn finish(&mut self, ground: &Ground, first: usize, [a, b, c]: &mut [Vec<u8>; 3]) {
        let taken = &self.taken[first..self.taken_count];
        let corners = a[first..].iter_mut().zip(&mut b[first..]).zip(&mut c[first..]);
        let (numbers, live) = (&*self.numbers, &mut *self.live);
        for (&t, ((a, b), c)) in taken.iter().zip(corners) {
            let triangle = ground.triangles[usize::from(t)];
            for (v, corner) in triangle.into_iter().zip([a, b, c]) {
                live[usize::from(v)] -= 1;
                *corner = numbers[usize::from(v)];
            }
        }
    }

    /// A triangle to begin a cluster with.
    fn seed(&mut self, ground: &Ground, untouched: &mut usize) -> u16 {
        self.sweep();
        if let Some(v) = self.recent().min_by_key(|&v| self.live[usize::from(v)])
            && let Some(t) = self.seed_at(ground, v)
        {
            return t;
        }
        while self.free[*untouched] == 0 {
            *untouched += 1;
        }
        *untouched as u16
    }

    /// A triangle to continue with, near a cluster that has room but an empty rim.
    fn seed_nearby(&mut self, ground: &Ground, open: &Open, limits: Limits) -> Option<u16> {
        if self.members.len() + 3 > limits.vertices as usize || open.room == 0 {
            return None;
        }
        self.sweep();
        let sum: Vec3 = self.members.iter().map(|&v| ground.position(v)).sum();
        let center = sum / self.members.len() as f32;
        let distance2 = |v: u16| ground.position(v).distance_squared(center);
        let reach2 = self.members.iter().map(|&v| distance2(v)).fold(0.0, f32::max);
        let (nearest2, nearest) =
            self.recent().map(|v| (distance2(v), v)).min_by(|a, b| a.0.total_cmp(&b.0))?;
        if nearest2 > FAR * FAR * reach2 {
            return None;
        }
        self.seed_at(ground, nearest)
    }

    /// The triangle at a vertex whose corners have the fewest free triangles.
    fn seed_at(&self, ground: &Ground, vertex: u16) -> Option<u16> {
        let around = self.around.at(vertex).iter().map(|corner| corner.triangle);
        around.filter(|&t| self.free[usize::from(t)] == 1).min_by_key(|&t| {
            let corners = ground.triangles[usize::from(t)];
            corners.iter().map(|&v| u32::from(self.live[usize::from(v)])).sum::<u32>()
        })
    }

    /// Drops vertices without free triangles from the end of the frontier.
    fn sweep(&mut self) {
        loop {
            let begin = self.frontier.len().saturating_sub(RECENT);
            let mut kept = begin;
            for i in begin..self.frontier.len() {
                let v = self.frontier[i];
                self.frontier[kept] = v;
                kept += usize::from(self.live[usize::from(v)] > 0);
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
