//! What files hold or request that is not drawn.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use crate::{FileMaterial, Mesh};

/// Counts of what is not drawn of a file: tercio draws triangles and some of their textures.
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
    /// Different texture files that materials of faces name only for what is not drawn, such as displacements and
    /// reflections; in a model without texture coordinates, all of them.
    pub textures: u64,
}

impl NotDrawn {
    /// True if the whole file is drawn.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// Counts what the mesh itself shows: textures, and vertices that are nothing but points. Returns whether they are.
    pub(super) fn count_mesh(&mut self, mesh: &Mesh, faces: u64) -> bool {
        let drawn: HashSet<&String> = match mesh.texcoords {
            Some(_) => mesh
                .materials
                .iter()
                .flat_map(|m| m.textures.iter())
                .map(|(_, texture)| &texture.file)
                .collect(),
            None => HashSet::new(),
        };
        let all: HashSet<&String> = mesh.materials.iter().flat_map(FileMaterial::texture_files).collect();
        self.textures = self.textures.max(all.difference(&drawn).count() as u64);
        let is_cloud = faces == 0 && [self.points, self.lines, self.curves, self.surfaces] == [0; 4];
        if is_cloud {
            self.points = mesh.positions.len() as u64;
        }
        is_cloud
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FileTexture, FileTextures};

    #[test]
    fn textures_are_drawn_by_their_roles_and_with_texture_coordinates() {
        let textures = FileTextures { diffuse: Some(FileTexture::new("a.png")), ..FileTextures::default() };
        let other_textures = ["a.png", "b.png", "b.png"].map(String::from).into();
        let material = FileMaterial { textures, other_textures, ..FileMaterial::default() };
        let mut mesh = Mesh { materials: vec![material; 2], ..Mesh::default() };
        let textures = |mesh: &Mesh| {
            let mut counts = NotDrawn::default();
            counts.count_mesh(mesh, 1);
            counts.textures
        };
        assert_eq!(textures(&mesh), 2);
        mesh.texcoords = Some(Vec::new());
        assert_eq!(textures(&mesh), 1);
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
