//! What of a model is not opaque.

use crate::loops::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Mesh;

/// Counts of what is not opaque, of what colours the mesh: faces, else vertices, else materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Translucent {
    /// Materials that a face uses.
    pub materials: u64,
    /// Vertices.
    pub vertices: u64,
    /// Faces.
    pub faces: u64,
}

impl Translucent {
    /// Counts. An alpha that is 0 everywhere cannot be meant, as nothing would be visible: it becomes 1, and a warning
    /// is returned.
    pub(super) fn count(mesh: &mut Mesh) -> (Self, Option<String>) {
        match Self::look(mesh) {
            (_, true) => (Self::default(), Some(Self::make_opaque(mesh))),
            (counts, false) => (counts, None),
        }
    }

    /// Counts, and whether there are colours, and all of them have an alpha of 0.
    pub(super) fn look(mesh: &Mesh) -> (Self, bool) {
        let mut counts = Self::default();
        let all;
        match (&mesh.face_colors, &mesh.vertex_colors) {
            (Some(colors), _) => {
                counts.faces = faces_of(colors, mesh.face_of_triangle.as_deref());
                all = all_invisible(colors);
            }
            (None, Some(colors)) => {
                let count = |part: &[[u8; 4]]| part.iter().filter(|c| is_translucent(c)).count() as u64;
                counts.vertices = colors.par_chunks(1 << 16).map(count).sum();
                all = counts.vertices > 0 && all_invisible(colors);
            }
            (None, None) => {
                let of_faces = mesh.triangle_materials.as_deref().unwrap_or_default();
                counts.materials = mesh.materials.iter().filter(|m| m.opacity < 1.0).count() as u64;
                let opacity = |&number: &u32| mesh.materials.get(number as usize).map_or(1.0, |m| m.opacity);
                all = counts.materials > 0 && of_faces.iter().all(|number| opacity(number) == 0.0);
            }
        }
        (counts, all)
    }

    /// Makes everything opaque; returns the warning.
    pub(super) fn make_opaque(mesh: &mut Mesh) -> String {
        let colors = mesh.face_colors.as_mut().or(mesh.vertex_colors.as_mut());
        match colors {
            Some(colors) => colors.iter_mut().for_each(|color| color[3] = u8::MAX),
            None => mesh.materials.iter_mut().for_each(|material| material.opacity = 1.0),
        }
        "everything is fully transparent (alpha or opacity 0 everywhere); drawn opaque".into()
    }
}

fn is_translucent(color: &[u8; 4]) -> bool {
    color[3] < u8::MAX
}

fn all_invisible(colors: &[[u8; 4]]) -> bool {
    !colors.is_empty() && colors.par_iter().all(|color| color[3] == 0)
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
    use crate::FileMaterial;

    #[test]
    fn a_face_of_several_triangles_is_one_translucent_face() {
        let colors = [[0, 0, 0, 9], [0, 0, 0, 9], [0; 4], [0, 0, 0, 255], [0; 4]];
        assert_eq!(faces_of(&colors, Some(&[0, 0, 1, 2, 5])), 3);
        assert_eq!(faces_of(&colors, None), 4);
    }

    fn counted(alphas: &[u8]) -> (Mesh, Translucent, Option<String>) {
        let vertex_colors = Some(alphas.iter().map(|&alpha| [1, 2, 3, alpha]).collect());
        let mut mesh = Mesh { vertex_colors, ..Mesh::default() };
        let (counts, warning) = Translucent::count(&mut mesh);
        (mesh, counts, warning)
    }

    #[test]
    fn an_alpha_of_0_everywhere_is_not_meant() {
        let (mesh, counts, warning) = counted(&[0, 0]);
        assert_eq!((counts, mesh.vertex_colors), (Translucent::default(), Some(vec![[1, 2, 3, 255]; 2])));
        assert!(warning.is_some());
        let (mesh, counts, warning) = counted(&[0, 7, 255]);
        assert_eq!((counts.vertices, warning), (2, None));
        assert_eq!(mesh.vertex_colors.expect("colours")[0][3], 0);
    }

    #[test]
    fn materials_count_if_nothing_else_has_colours() {
        let material = |opacity| FileMaterial { opacity, ..FileMaterial::default() };
        let mut mesh = Mesh {
            materials: vec![material(0.0), material(1.0)],
            triangle_materials: Some(vec![0, Mesh::NO_MATERIAL]),
            ..Mesh::default()
        };
        assert_eq!(Translucent::count(&mut mesh).0.materials, 1);
        assert_eq!(mesh.materials[0].opacity, 0.0);
        mesh.triangle_materials = Some(vec![0, 0]);
        assert!(Translucent::count(&mut mesh).1.is_some());
        assert_eq!(mesh.materials[0].opacity, 1.0);
        mesh.vertex_colors = Some(vec![[0, 0, 0, 255]]);
        mesh.materials[0].opacity = 0.5;
        assert_eq!(Translucent::count(&mut mesh).0, Translucent::default());
    }
}
