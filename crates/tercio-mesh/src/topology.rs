//! Is the mesh closed, is it consistently wound?

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::loops::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Mesh;
use crate::adjacency::Adjacency;
use crate::weld::position_representatives;

/// The connectivity of a mesh. Vertices are identified by position, so that a seam in the texture coordinates is not
/// a boundary. Triangles with two corners at one position are ignored.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Topology {
    /// An even number of triangles meets at every edge, and there are triangles.
    pub closed: bool,
    /// At every edge as many triangles run one way as the other; if their number is odd, all but one. A mesh that is
    /// closed and consistently wound separates an inside from an outside.
    pub consistently_wound: bool,
    /// Edges of one triangle only.
    pub boundary_edges: u64,
    /// Edges of more than two triangles.
    pub non_manifold_edges: u64,
    /// Edges of two triangles that run along it in the same direction.
    pub flipped_edges: u64,
    /// All edges.
    pub edges: u64,
    /// Positions that triangles use.
    pub vertices: u64,
    /// Triangles with three different corner positions.
    pub triangles: u64,
    /// Parts of the mesh that have no vertex in common.
    pub components: u64,
}

impl Topology {
    /// Vertices - edges + triangles: 2 for each part that is like a sphere, 0 for each that is like a torus.
    pub fn euler_characteristic(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.triangles as i64
    }
}

/// Analyses all edges of the mesh.
///
/// # Panics
///
/// If a triangle's vertex does not exist.
pub fn analyze(mesh: &Mesh) -> Topology {
    let same = position_representatives(mesh);
    let around = Adjacency::new(&mesh.triangles, mesh.positions.len(), |v| same[v as usize]);
    let corners = |t: u32| {
        let c = mesh.triangles[t as usize].map(|v| same[v as usize]);
        (c[0] != c[1] && c[1] != c[2] && c[2] != c[0]).then_some(c)
    };

    let mut found = (0..mesh.positions.len() as u32)
        .into_par_iter()
        .with_min_len(1 << 12)
        .fold(Tally::default, |mut tally, v| {
            tally.vertex(v, around.at(v as usize).iter().filter_map(|&t| corners(t)));
            tally
        })
        .map(|tally| tally.found)
        .reduce(Found::default, Found::plus);

    let parts = Parts::new(mesh.positions.len());
    found.topology.triangles = (0..mesh.triangles.len() as u32)
        .into_par_iter()
        .filter_map(corners)
        .map(|[a, b, c]| {
            parts.join(a, b);
            parts.join(b, c);
        })
        .count() as u64;
    // A component's root is one of its positions; positions without triangles are roots too, but not components.
    let roots = (0..mesh.positions.len() as u32)
        .into_par_iter()
        .filter(|&v| same[v as usize] == v && parts.find(v) == v);
    let all_roots = roots.count() as u64;
    let all_positions = same.par_iter().enumerate().filter(|&(v, &s)| v as u32 == s).count() as u64;
    found.topology.components = all_roots - (all_positions - found.topology.vertices);

    Topology {
        closed: found.odd_edges == 0 && found.topology.triangles > 0,
        consistently_wound: found.unbalanced_edges == 0,
        ..found.topology
    }
}

#[derive(Default)]
struct Found {
    topology: Topology,
    odd_edges: u64,
    unbalanced_edges: u64,
}

impl Found {
    fn plus(mut self, other: Self) -> Self {
        self.topology.boundary_edges += other.topology.boundary_edges;
        self.topology.non_manifold_edges += other.topology.non_manifold_edges;
        self.topology.flipped_edges += other.topology.flipped_edges;
        self.topology.edges += other.topology.edges;
        self.topology.vertices += other.topology.vertices;
        self.odd_edges += other.odd_edges;
        self.unbalanced_edges += other.unbalanced_edges;
        self
    }
}

#[derive(Default)]
struct Tally {
    found: Found,
    /// The other end of an edge, and whether a triangle runs towards it.
    edges: Vec<(u32, bool)>,
}

impl Tally {
    /// Counts the edges from a vertex to those with higher numbers.
    fn vertex(&mut self, v: u32, triangles: impl Iterator<Item = [u32; 3]>) {
        self.edges.clear();
        let mut used = false;
        for [a, b, c] in triangles {
            used = true;
            let (next, previous) = if a == v {
                (b, c)
            } else if b == v {
                (c, a)
            } else {
                (a, b)
            };
            if next > v {
                self.edges.push((next, true));
            }
            if previous > v {
                self.edges.push((previous, false));
            }
        }
        self.found.topology.vertices += u64::from(used);
        self.edges.sort_unstable();
        for edge in self.edges.chunk_by(|a, b| a.0 == b.0) {
            let away = edge.iter().filter(|e| e.1).count();
            let back = edge.len() - away;
            let t = &mut self.found.topology;
            t.edges += 1;
            t.boundary_edges += u64::from(edge.len() == 1);
            t.non_manifold_edges += u64::from(edge.len() > 2);
            t.flipped_edges += u64::from(edge.len() == 2 && away != 1);
            self.found.odd_edges += edge.len() as u64 % 2;
            self.found.unbalanced_edges += u64::from(away.abs_diff(back) > edge.len() % 2);
        }
    }
}

/// Union-find that several threads may use at once: links only ever point to lower numbers, so the resulting roots do
/// not depend on the order of the joins.
pub(crate) struct Parts(Vec<AtomicU32>);

impl Parts {
    /// Of so many vertices, each alone.
    pub(crate) fn new(n: usize) -> Self {
        Self((0..n as u32).into_par_iter().map(AtomicU32::new).collect())
    }

    /// The vertex with the lowest number in the part of this one.
    pub(crate) fn find(&self, mut v: u32) -> u32 {
        loop {
            let up = self.0[v as usize].load(Relaxed);
            if up == v {
                return v;
            }
            let top = self.0[up as usize].load(Relaxed);
            // Path halving; if another thread was faster, its link is as good.
            let _ = self.0[v as usize].compare_exchange_weak(up, top, Relaxed, Relaxed);
            v = top;
        }
    }

    /// Joins the parts of two vertices.
    pub(crate) fn join(&self, a: u32, b: u32) {
        loop {
            let (a, b) = (self.find(a), self.find(b));
            if a == b {
                return;
            }
            let (low, high) = (a.min(b), a.max(b));
            if self.0[high as usize].compare_exchange(high, low, Relaxed, Relaxed).is_ok() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Mesh::default() }
    }

    const TETRAHEDRON: ([[f32; 3]; 4], [[u32; 3]; 4]) = (
        [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    );

    #[test]
    fn a_tetrahedron_is_closed() {
        let (p, t) = TETRAHEDRON;
        let found = analyze(&mesh(&p, &t));
        assert!(found.closed && found.consistently_wound);
        assert_eq!((found.edges, found.vertices, found.components), (6, 4, 1));
        assert_eq!(found.euler_characteristic(), 2);
        // The same as a soup, with an unused vertex and a degenerate triangle.
        let mut soup: Vec<_> = t.iter().flatten().map(|&v| p[v as usize]).collect();
        soup.push([7.0; 3]);
        assert_eq!(analyze(&mesh(&soup, &[[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11], [0, 3, 1]])), found);
    }

    #[test]
    fn borders_flips_and_crowded_edges_are_counted() {
        let (p, t) = TETRAHEDRON;
        let open = analyze(&mesh(&p, &t[..3]));
        assert!(!open.closed && open.consistently_wound);
        assert_eq!(open.boundary_edges, 3);
        let mut flipped = t;
        flipped[0].swap(0, 1);
        let found = analyze(&mesh(&p, &flipped));
        assert!(found.closed && !found.consistently_wound);
        assert_eq!(found.flipped_edges, 3);
        let found = analyze(&mesh(&p, &[&t[..], &[[0, 1, 2]]].concat()));
        assert!(!found.closed && found.consistently_wound);
        assert_eq!(found.non_manifold_edges, 3);
        assert_eq!(analyze(&Mesh::default()), Topology { consistently_wound: true, ..Topology::default() });
    }

    #[test]
    fn parts_are_counted_for_any_number_of_threads() {
        // Strips of triangles, a thousand of them.
        let positions: Vec<_> =
            (0..102_000u32).map(|i| [(i / 102) as f32, (i % 102) as f32, (i % 2) as f32]).collect();
        let triangles: Vec<_> =
            (0..102_000u32).filter(|i| i % 102 < 100).map(|i| [i, i + 1 + i % 2, i + 2 - i % 2]).collect();
        let m = mesh(&positions, &triangles);
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| analyze(&m));
            assert_eq!((found.components, found.triangles), (1000, 100_000));
            assert!(found.consistently_wound && found.flipped_edges == 0);
        }
    }
}
