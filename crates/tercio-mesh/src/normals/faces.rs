//! Triangles as seen from their corners.

use glam::DVec3;

use crate::trig::acos_coarse;

/// Triangles as seen from a position.
pub(super) struct Faces<'a> {
    pub positions: &'a [[f32; 3]],
    pub triangles: &'a [[u32; 3]],
    /// For each vertex the representative of its position.
    pub same: &'a [u32],
}

impl Faces<'_> {
    fn position(&self, v: u32) -> DVec3 {
        let p = self.positions[v as usize];
        DVec3::new(p[0].into(), p[1].into(), p[2].into())
    }

    /// The unit normal of the triangle with these corners, and the angle at the first; zero if it has no area.
    #[inline]
    pub fn corner(&self, [v, next, previous]: [u32; 3]) -> (DVec3, f64) {
        let p = self.position(v);
        let (e, f) = (self.position(next) - p, self.position(previous) - p);
        // The square of an `f32` fits an `f64`, and so does the square of that (1e-45 to 1e38).
        let normal = e.cross(f);
        let (area2, edges2) = (normal.length_squared(), e.length_squared() * f.length_squared());
        if !(area2 > 0.0 && edges2 > 0.0) {
            return (DVec3::ZERO, 0.0);
        }
        let cosine = e.dot(f) / edges2.sqrt();
        (normal / area2.sqrt(), acos_coarse(cosine))
    }

    /// The triangle rotated so that the corner whose representative is `vertex` comes first.
    #[inline]
    pub fn turned(&self, triangle: u32, vertex: u32) -> [u32; 3] {
        let [a, b, c] = self.triangles[triangle as usize];
        if self.same[a as usize] == vertex {
            [a, b, c]
        } else if self.same[b as usize] == vertex {
            [b, c, a]
        } else {
            [c, a, b]
        }
    }

    /// Sum of the normals of the triangles at a vertex, weighted by angle.
    pub fn sum(&self, vertex: u32, triangles: &[u32]) -> DVec3 {
        triangles.iter().fold(DVec3::ZERO, |sum, &t| {
            let (normal, angle) = self.corner(self.turned(t, vertex));
            sum + normal * angle
        })
    }
}
