//! Vertex normals from the triangles round a vertex, weighted by angle.
//!
//! Source: Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets" (1998). Weighted by the
//! angle at the vertex, the normal does not depend on how a flat face happens to be cut into triangles.
//!
//! Each vertex sums up its own triangles in the order of their numbers, so the bits do not depend on the
//! number of threads. A triangle is looked at from each of its corners, which costs less than storing what
//! was seen.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::OctNormal;
use crate::adjacency::Adjacency;
use crate::trig::{acos_coarse, sin_cos};
use crate::weld::position_representatives;
use crate::{AttributeDomain, Mesh};

const CHUNK: usize = 1 << 14;

/// Gives the mesh new vertex normals, in place of those it has.
///
/// Vertices at the same position share their normal, even where texture coordinates or colours split them.
/// Vertices that no triangle with an area uses get +z.
///
/// With a `crease_angle` (radians, 0 to pi), the triangles at a vertex are one smooth surface only as far
/// as they are connected by edges at that vertex across which the face normals differ by at most the angle.
/// Each surface gets its own normal, and a vertex that several use is split: the first keeps the number,
/// the others' vertices are appended to [`Mesh::positions`] and every vertex array. If that were too many
/// to number, the vertex keeps the normal of its first surface.
///
/// # Panics
///
/// If a triangle's vertex does not exist, or a vertex array is too short.
pub fn make_normals(mesh: &mut Mesh, crease_angle: Option<f64>) {
    let same = position_representatives(mesh);
    let unique = same.par_iter().enumerate().all(|(i, &s)| s as usize == i);
    let around = if unique {
        Adjacency::new(&mesh.triangles, mesh.positions.len(), |v| v)
    } else {
        Adjacency::new(&mesh.triangles, mesh.positions.len(), |v| same[v as usize])
    };
    match crease_angle {
        None => {
            let faces = Faces { mesh, same: &same };
            let mut normals: Vec<OctNormal> = (0..mesh.positions.len())
                .into_par_iter()
                .with_min_len(CHUNK)
                .map(|v| encode(faces.sum(v as u32, around.at(v))))
                .collect();
            if !unique {
                normals = same.par_iter().map(|&s| normals[s as usize]).collect();
            }
            mesh.normals = Some(normals);
        }
        Some(angle) => creased(mesh, &same, &around, sin_cos(angle.clamp(0.0, std::f64::consts::PI)).1),
    }
}

fn encode(sum: DVec3) -> OctNormal {
    // Near one, where `f32` neither overflows nor underflows.
    let n = sum / sum.abs().max_element();
    OctNormal::encode([n.x as f32, n.y as f32, n.z as f32])
}

/// Triangles as they look from a position.
struct Faces<'a> {
    mesh: &'a Mesh,
    same: &'a [u32],
}

impl Faces<'_> {
    fn position(&self, v: u32) -> DVec3 {
        let p = self.mesh.positions[v as usize];
        DVec3::new(p[0].into(), p[1].into(), p[2].into())
    }

    /// The unit normal of the triangle with these corners, and the angle at the first; zero if it has no area.
    #[inline]
    fn corner(&self, [v, next, previous]: [u32; 3]) -> (DVec3, f64) {
        let p = self.position(v);
        let (e, f) = (self.position(next) - p, self.position(previous) - p);
        // `f32` squared fits an `f64`, and so does the square of the square (1e-45 to 1e38).
        let normal = e.cross(f);
        let (area2, edges2) = (normal.length_squared(), e.length_squared() * f.length_squared());
        if !(area2 > 0.0 && edges2 > 0.0) {
            return (DVec3::ZERO, 0.0);
        }
        let cosine = e.dot(f) / edges2.sqrt();
        (normal / area2.sqrt(), acos_coarse(cosine))
    }

    /// The triangle turned so that the corner that stands for `vertex` comes first.
    #[inline]
    fn turned(&self, triangle: u32, vertex: u32) -> [u32; 3] {
        let [a, b, c] = self.mesh.triangles[triangle as usize];
        if self.same[a as usize] == vertex {
            [a, b, c]
        } else if self.same[b as usize] == vertex {
            [b, c, a]
        } else {
            [c, a, b]
        }
    }

    fn sum(&self, vertex: u32, triangles: &[u32]) -> DVec3 {
        triangles.iter().fold(DVec3::ZERO, |sum, &t| {
            let (normal, angle) = self.corner(self.turned(t, vertex));
            sum + normal * angle
        })
    }
}

/// What a stretch of positions asks for: new vertices and who uses them.
#[derive(Default)]
struct Split {
    /// The vertex it is a copy of, and its normal.
    copies: Vec<(u32, OctNormal)>,
    /// Triangle, corner, and number in `copies`.
    moves: Vec<(u32, u8, u32)>,
}

fn creased(mesh: &mut Mesh, same: &[u32], around: &Adjacency, cos_crease: f64) {
    let vertices = mesh.positions.len();
    let faces = Faces { mesh, same };
    let normals: Vec<AtomicU32> =
        (0..vertices).into_par_iter().map(|_| AtomicU32::new(OctNormal::default().0)).collect();
    let splits: Vec<Split> = (0..vertices.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut split = Split::default();
            let mut fan = Fan::default();
            for r in chunk * CHUNK..vertices.min((chunk + 1) * CHUNK) {
                fan.split(&faces, r as u32, around.at(r), cos_crease, &normals, &mut split);
            }
            split
        })
        .collect();
    let mut normals: Vec<OctNormal> = normals.into_iter().map(|n| OctNormal(n.into_inner())).collect();

    let mut sources = Vec::new();
    for split in &splits {
        let first = normals.len() as u64;
        if first + split.copies.len() as u64 > crate::mesh::MAX_ELEMENTS {
            break;
        }
        for &(source, normal) in &split.copies {
            sources.push(source);
            normals.push(normal);
        }
        for &(t, k, copy) in &split.moves {
            mesh.triangles[t as usize][k as usize] = first as u32 + copy;
        }
    }
    fn append<T: Copy>(array: &mut Vec<T>, sources: &[u32]) {
        array.reserve_exact(sources.len());
        for &s in sources {
            array.push(array[s as usize]);
        }
    }
    append(&mut mesh.positions, &sources);
    mesh.vertex_colors.iter_mut().for_each(|a| append(a, &sources));
    mesh.texcoords.iter_mut().for_each(|a| append(a, &sources));
    for a in &mut mesh.attributes {
        if a.domain == AttributeDomain::Vertex {
            append(&mut a.values, &sources);
        }
    }
    mesh.normals = Some(normals);
}

/// The triangles at one position and the smooth surfaces they make.
#[derive(Default)]
struct Fan {
    triangles: Vec<(u32, DVec3, f64)>,
    /// The position at the other end of an edge, and the place in `triangles`.
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

    fn split(
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
            // A triangle without area has no direction that could differ. The margin keeps equal normals
            // together at a crease angle of zero.
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
            // A triangle with two corners at this position stands here twice.
            if i > 0 && self.triangles[i - 1].0 == t {
                continue;
            }
            let surface = self.find(i as u32);
            for (k, &v) in faces.mesh.triangles[t as usize].iter().enumerate() {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(quads_by_long_fans: bool) -> Mesh {
        let positions = (0..8).map(|i| [0, 1, 2].map(|k| (i >> k & 1) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads
            .iter()
            .enumerate()
            .flat_map(|(i, &[a, b, c, d])| {
                if quads_by_long_fans && i % 2 == 0 { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] }
            })
            .collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    fn direction(n: OctNormal) -> DVec3 {
        let [x, y, z] = n.decode();
        DVec3::new(x.into(), y.into(), z.into()).normalize()
    }

    #[test]
    fn a_cube_is_round_without_crease_and_sharp_with_one() {
        for cut in [false, true] {
            let mut m = cube(cut);
            make_normals(&mut m, None);
            assert_eq!(m.positions.len(), 8);
            for (p, &n) in m.positions.iter().zip(m.normals.as_ref().unwrap()) {
                let out = (DVec3::new(p[0].into(), p[1].into(), p[2].into()) - 0.5).normalize();
                assert!((direction(n) - out).length() < 1e-3, "{cut} {p:?}");
            }
            m.vertex_colors = Some((0..8).map(|i| [i; 4]).collect());
            let before = m.clone();
            make_normals(&mut m, Some(1.0));
            assert_eq!(m.positions.len(), 24);
            assert_eq!(m.normals.as_ref().unwrap().len(), 24);
            let (colors, old) = (m.vertex_colors.as_ref().unwrap(), before.vertex_colors.as_ref().unwrap());
            for (t, b) in m.triangles.iter().zip(&before.triangles) {
                let [p, q, r] = t.map(|v| DVec3::from(m.positions[v as usize].map(f64::from)));
                let face = (q - p).cross(r - p).normalize();
                for (&v, &w) in t.iter().zip(b) {
                    assert_eq!(m.positions[v as usize], before.positions[w as usize]);
                    assert_eq!(colors[v as usize], old[w as usize]);
                    assert!((direction(m.normals.as_ref().unwrap()[v as usize]) - face).length() < 1e-4);
                }
            }
            // Nothing is left to split, and the vertices that were split do not grow together.
            make_normals(&mut m, Some(1.0));
            assert_eq!(m.positions.len(), 24);
        }
    }

    #[test]
    fn a_right_angle_is_no_crease_at_a_larger_angle() {
        let mut m = cube(true);
        make_normals(&mut m, Some(1.6));
        assert_eq!(m.positions.len(), 8);
    }

    #[test]
    fn split_vertices_share_their_normal() {
        let whole = cube(false);
        let mut soup = Mesh {
            positions: whole.triangles.iter().flatten().map(|&v| whole.positions[v as usize]).collect(),
            triangles: (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        };
        let mut joined = whole.clone();
        make_normals(&mut joined, None);
        make_normals(&mut soup, None);
        let (a, b) = (soup.normals.unwrap(), joined.normals.unwrap());
        for (i, &v) in whole.triangles.as_flattened().iter().enumerate() {
            assert_eq!(a[i], b[v as usize]);
        }
    }

    #[test]
    fn spheres_point_outwards_for_any_number_of_threads() {
        let mesh = crate::builtin::make("builtin:sphere@200k").unwrap();
        let results: Vec<_> = [1, 2, 3, 7]
            .map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let (mut smooth, mut creased) = (mesh.clone(), mesh.clone());
                pool.install(|| {
                    make_normals(&mut smooth, None);
                    make_normals(&mut creased, Some(0.5));
                });
                assert_eq!(creased.positions.len(), mesh.positions.len());
                assert_eq!(creased.normals, smooth.normals);
                smooth.normals.unwrap()
            })
            .into();
        assert!(results.iter().all(|r| *r == results[0]));
        let error = |(p, &n): (&[f32; 3], &OctNormal)| {
            (direction(n) - DVec3::from(p.map(f64::from)).normalize()).length()
        };
        let mut fine = crate::builtin::make("builtin:sphere@1.5M").unwrap();
        make_normals(&mut fine, None);
        let normals = fine.normals.as_ref().unwrap();
        let worst = fine.positions.iter().zip(normals).map(error).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{worst}");
    }

    #[test]
    fn tiny_and_huge_models_have_normals() {
        for scale in [1e-30f32, 1e30] {
            let mut m = cube(false);
            m.positions.iter_mut().for_each(|p| *p = p.map(|x| x * scale));
            make_normals(&mut m, None);
            assert!((direction(m.normals.unwrap()[7]) - DVec3::ONE.normalize()).length() < 1e-3);
        }
    }
}
