//! The smooth surfaces that meet at a position.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::DVec3;

use super::faces::Faces;
use super::{OctNormal, encode};

/// The new vertices that a chunk of positions needs, and the corners that use them.
#[derive(Default)]
pub(super) struct Split {
    /// The vertex that is copied, and the copy's normal.
    pub copies: Vec<(u32, OctNormal)>,
    /// Triangle, corner, and index in `copies`.
    pub moves: Vec<(u32, u8, u32)>,
}

/// The triangles at one position and the smooth surfaces that they form.
#[derive(Default)]
pub(super) struct Fan {
    triangles: Vec<(u32, DVec3, f64)>,
    /// The position at the other end of an edge, and the index in `triangles`.
    edges: Vec<(u32, u32)>,
    /// Union-find over `triangles`; a surface's root is its first triangle.
    root: Vec<u32>,
    sums: Vec<DVec3>,
    /// Vertex, surface, triangle, corner.
    users: Vec<(u32, u32, u32, u8)>,
}

impl Fan {
    fn find(&mut self, mut i: u32) -> u32 {
        while self.root[i as usize] != i {
            let up = self.root[self.root[i as usize] as usize];
            self.root[i as usize] = up;
            i = up;
        }
        i
    }

    /// Finds the surfaces at a position; the normal of a vertex's first surface is stored in `normals`, the others in
    /// `out`.
    pub fn split(
        &mut self,
        faces: &Faces<'_>,
        position: u32,
        triangles: &[u32],
        cos_crease: f64,
        normals: &[AtomicU32],
        out: &mut Split,
    ) {
        self.triangles.clear();
        self.edges.clear();
        for &t in triangles {
            let corners = faces.turned(t, position);
            let (normal, angle) = faces.corner(corners);
            let place = self.triangles.len() as u32;
            self.triangles.push((t, normal, angle));
            for end in &corners[1..] {
                self.edges.push((faces.same[*end as usize], place));
            }
        }
        self.root.clear();
        self.root.extend(0..self.triangles.len() as u32);
        self.edges.sort_unstable();
        for e in 1..self.edges.len() {
            let ((end, i), (end_before, j)) = (self.edges[e], self.edges[e - 1]);
            if end != end_before {
                continue;
            }
            let (n, m) = (self.triangles[i as usize].1, self.triangles[j as usize].1);
            // A triangle without area has no direction that could differ. The margin keeps equal normals together for
            // a crease angle of zero.
            if n == DVec3::ZERO || m == DVec3::ZERO || n.dot(m) >= cos_crease - 1e-12 {
                let (a, b) = (self.find(i), self.find(j));
                self.root[a.max(b) as usize] = a.min(b);
            }
        }

        self.sums.clear();
        self.sums.resize(self.triangles.len(), DVec3::ZERO);
        for i in 0..self.triangles.len() {
            let (_, normal, angle) = self.triangles[i];
            let root = self.find(i as u32);
            self.sums[root as usize] += normal * angle;
        }

        // The first surface that uses a vertex keeps it.
        self.users.clear();
        for i in 0..self.triangles.len() {
            let t = self.triangles[i].0;
            // A triangle with two corners at this position is listed twice.
            if i > 0 && self.triangles[i - 1].0 == t {
                continue;
            }
            let surface = self.find(i as u32);
            for (k, &v) in faces.triangles[t as usize].iter().enumerate() {
                if faces.same[v as usize] == position {
                    self.users.push((v, surface, t, k as u8));
                }
            }
        }
        self.users.sort_unstable();
        for of_vertex in self.users.chunk_by(|a, b| a.0 == b.0) {
            for (nth, group) in of_vertex.chunk_by(|a, b| a.1 == b.1).enumerate() {
                let (v, surface, ..) = group[0];
                let normal = encode(self.sums[surface as usize]);
                if nth == 0 {
                    normals[v as usize].store(normal.0, Relaxed);
                } else {
                    let copy = out.copies.len() as u32;
                    out.copies.push((v, normal));
                    out.moves.extend(group.iter().map(|&(_, _, t, k)| (t, k, copy)));
                }
            }
        }
    }
}
