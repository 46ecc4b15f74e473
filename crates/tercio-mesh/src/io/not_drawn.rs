//! What files hold or request that is not drawn.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use crate::Mesh;

/// Counts of what is not drawn of a file: tercio draws triangles without textures.
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
}

impl NotDrawn {
    /// True if the whole file is drawn.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// Counts what the mesh itself shows: textures, and vertices that are nothing but points.
    pub(super) fn count_mesh(&mut self, mesh: &Mesh, faces: u64) {
        let used = &mesh.materials;
        let textures = used.iter().flat_map(|m| m.diffuse_texture.iter().chain(&m.other_textures));
        self.textures = self.textures.max(textures.collect::<HashSet<_>>().len() as u64);
        let is_cloud = faces == 0 && self.points + self.lines + self.curves + self.surfaces == 0;
        if is_cloud {
            self.points = mesh.positions.len() as u64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
