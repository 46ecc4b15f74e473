//! What files hold or request that is not drawn.

use std::collections::HashSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Mesh;

/// Counts of what is not drawn of a file: tercio draws opaque triangles without textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct NotDrawn {
    /// Points; in a model without faces and lines, all vertices.
    pub points: u64,
    /// Lines.
    pub lines: u64,
    /// Free-form curves.
    pub curves: u64,
    /// Free-form surfaces.
    pub surfaces: u64,
    /// Different texture files requested by materials that a face uses.
    pub textures: u64,
    /// Materials that a face uses and that are not opaque.
    pub translucent_materials: u64,
    /// Vertices with a colour that is not opaque, if faces have no colours of their own.
    pub translucent_vertices: u64,
    /// Faces with a colour that is not opaque.
    pub translucent_faces: u64,
}

impl NotDrawn {
    /// True if the whole file is drawn.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// Counts what the mesh itself shows: textures, opacity, and vertices that are nothing but points.
    pub(super) fn count_mesh(&mut self, mesh: &Mesh, faces: u64) {
        let used = &mesh.materials;
        self.translucent_materials = used.iter().filter(|m| m.opacity < 1.0).count() as u64;
        let textures = used.iter().flat_map(|m| m.diffuse_texture.iter().chain(&m.other_textures));
        self.textures = self.textures.max(textures.collect::<HashSet<_>>().len() as u64);
        match (&mesh.face_colors, &mesh.vertex_colors) {
            (Some(colors), _) => self.translucent_faces = faces_of(colors, mesh.face_of_triangle.as_deref()),
            (None, Some(colors)) => {
                let count = |part: &[[u8; 4]]| part.iter().filter(|c| is_translucent(c)).count() as u64;
                self.translucent_vertices = colors.par_chunks(1 << 16).map(count).sum();
            }
            (None, None) => {}
        }
        let is_cloud = faces == 0 && self.points + self.lines + self.curves + self.surfaces == 0;
        if is_cloud {
            self.points = mesh.positions.len() as u64;
        }
    }
}

fn is_translucent(color: &[u8; 4]) -> bool {
    color[3] < u8::MAX
}

/// Number of faces with a translucent triangle; the triangles of a face are consecutive.
fn faces_of(colors: &[[u8; 4]], face_of_triangle: Option<&[u32]>) -> u64 {
    let face =
        |triangle: usize| face_of_triangle.and_then(|f| f.get(triangle)).map_or(triangle, |&f| f as usize);
    let counts = |triangle: usize| {
        is_translucent(&colors[triangle]) && (triangle == 0 || face(triangle) != face(triangle - 1))
    };
    (0..colors.len()).into_par_iter().with_min_len(1 << 16).filter(|&t| counts(t)).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_of_several_triangles_is_one_translucent_face() {
        let colors = [[0, 0, 0, 9], [0, 0, 0, 9], [0; 4], [0, 0, 0, 255], [0; 4]];
        assert_eq!(faces_of(&colors, Some(&[0, 0, 1, 2, 5])), 3);
        assert_eq!(faces_of(&colors, None), 4);
    }

    #[test]
    fn vertices_are_points_only_where_nothing_else_is() {
        let mesh = Mesh { positions: vec![[0.0; 3]; 5], ..Mesh::default() };
        let points = |lines: u64, faces: u64| {
            let mut counts = NotDrawn { lines, ..NotDrawn::default() };
            counts.count_mesh(&mesh, faces);
            counts.points
        };
        assert_eq!([points(0, 0), points(2, 0), points(0, 1)], [5, 0, 0]);
    }
}
