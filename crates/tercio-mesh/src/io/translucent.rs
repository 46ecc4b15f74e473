//! What of a model is not opaque.

use crate::loops::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Mesh;
use crate::strokes::Strokes;

/// Counts of what is not opaque. The alpha of the mesh's own colours (of faces, else of vertices) is multiplied by that of
/// materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Translucent {
    /// Materials that a face uses.
    pub materials: u64,
    /// Vertices.
    pub vertices: u64,
    /// Faces.
    pub faces: u64,
    /// Line segments.
    #[serde(default)]
    pub lines: u64,
    /// Points.
    #[serde(default)]
    pub points: u64,
}

/// What has an alpha of 0 everywhere. That cannot be meant, as nothing would be visible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Unseen {
    /// The mesh's own colours.
    pub colors: bool,
    /// The materials of all faces.
    pub materials: bool,
}

impl Translucent {
    /// Counts, after what is invisible everywhere became opaque: then, a warning is returned.
    pub(super) fn count(mesh: &mut Mesh) -> (Self, Option<String>) {
        let (counts, unseen) = Self::look(mesh);
        match unseen.make_opaque(mesh) {
            None => (counts, None),
            warning => (Self::look(mesh).0, warning),
        }
    }

    /// Counts lines and points of the file, after those that are invisible everywhere became opaque.
    pub(super) fn count_strokes(&mut self, strokes: &Strokes) {
        let is_translucent = |&vertex: &u32| strokes.color(vertex).is_some_and(|c| is_translucent(&c));
        if strokes.colors.is_some() {
            let lines =
                |part: &[[u32; 2]]| part.iter().filter(|ends| ends.iter().any(is_translucent)).count() as u64;
            let points = |part: &[u32]| part.iter().filter(|point| is_translucent(point)).count() as u64;
            self.lines = strokes.segments.par_chunks(1 << 16).map(lines).sum();
            self.points = strokes.points.par_chunks(1 << 16).map(points).sum();
        }
    }

    /// Counts, and what is invisible everywhere.
    pub(super) fn look(mesh: &Mesh) -> (Self, Unseen) {
        let (mut counts, mut unseen) = (Self::default(), Unseen::default());
        if let Some(colors) = &mesh.face_colors {
            counts.faces = faces_of(colors, mesh.face_of_triangle.as_deref());
            unseen.colors = all_invisible(colors);
        } else if let Some(colors) = &mesh.vertex_colors {
            let count = |part: &[[u8; 4]]| part.iter().filter(|c| is_translucent(c)).count() as u64;
            counts.vertices = colors.par_chunks(1 << 16).map(count).sum();
            unseen.colors = counts.vertices > 0 && all_invisible(colors);
        }
        let of_faces = mesh.triangle_materials.as_deref().unwrap_or_default();
        counts.materials = mesh.materials.iter().filter(|m| m.opacity < 1.0).count() as u64;
        let opacity = |&number: &u32| mesh.materials.get(number as usize).map_or(1.0, |m| m.opacity);
        unseen.materials = counts.materials > 0 && of_faces.iter().all(|number| opacity(number) == 0.0);
        (counts, unseen)
    }
}

impl Unseen {
    /// Makes it opaque; returns the warning if there is anything.
    pub fn make_opaque(self, mesh: &mut Mesh) -> Option<String> {
        if self.colors
            && let Some(colors) = mesh.face_colors.as_mut().or(mesh.vertex_colors.as_mut())
        {
            colors.iter_mut().for_each(|color| color[3] = u8::MAX);
        }
        if self.materials {
            mesh.materials.iter_mut().for_each(|material| material.opacity = 1.0);
        }
        (self != Self::default())
            .then(|| "everything is fully transparent (alpha or opacity 0 everywhere); drawn opaque".into())
    }
}

/// Lines and points that are all invisible become opaque; returns the warning then.
pub(super) fn make_strokes_opaque(strokes: &mut Strokes) -> Option<String> {
    let colors = strokes.colors.as_mut().filter(|colors| !colors.is_empty())?;
    // One without a colour has the colour of the user's choice.
    if !colors.par_iter().all(|color| color.is_some_and(|[.., alpha]| alpha == 0)) {
        return None;
    }
    colors.iter_mut().flatten().for_each(|color| color[3] = u8::MAX);
    Some("all lines and points are fully transparent (alpha or opacity 0 everywhere); drawn opaque".into())
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

    #[test]
    fn invisible_lines_and_points_are_not_meant() {
        let strokes = |colors: &[Option<[u8; 4]>]| Strokes {
            positions: vec![[0.0; 3]; colors.len()],
            colors: Some(colors.to_vec()),
            ..Strokes::default()
        };
        let mut all = strokes(&[Some([1, 2, 3, 0]), Some([4, 5, 6, 0])]);
        assert!(make_strokes_opaque(&mut all).is_some());
        assert_eq!(all.colors, Some(vec![Some([1, 2, 3, 255]), Some([4, 5, 6, 255])]));
        let mut some = strokes(&[Some([1, 2, 3, 0]), Some([4, 5, 6, 7])]);
        assert_eq!(make_strokes_opaque(&mut some), None);
        // One of them has the colour of the user's choice.
        let mut uncolored = strokes(&[None, Some([1, 2, 3, 0])]);
        assert_eq!(make_strokes_opaque(&mut uncolored), None);
        assert_eq!(uncolored.color(1), Some([1, 2, 3, 0]));
        assert_eq!(make_strokes_opaque(&mut strokes(&[])), None);
    }

    #[test]
    fn translucent_lines_and_points_are_counted() {
        let mut strokes = Strokes {
            positions: vec![[0.0; 3]; 4],
            colors: Some(vec![Some([1, 2, 3, 255]), Some([1, 2, 3, 9]), None, Some([1, 2, 3, 255])]),
            segments: vec![[0, 1], [1, 0], [0, 2], [3, 0]],
            points: vec![1, 2, 3],
            ..Strokes::default()
        };
        let mut counts = Translucent::default();
        counts.count_strokes(&strokes);
        assert_eq!(counts, Translucent { lines: 2, points: 1, ..Translucent::default() });
        strokes.colors = None;
        counts = Translucent::default();
        counts.count_strokes(&strokes);
        assert_eq!(counts, Translucent::default());
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
    fn materials_count_beside_colours() {
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
        assert_eq!(Translucent::count(&mut mesh).0, Translucent { materials: 1, ..Translucent::default() });
        // Either of both makes all invisible.
        mesh.materials[0].opacity = 0.0;
        assert!(Translucent::count(&mut mesh).1.is_some());
        assert_eq!(
            (mesh.materials[0].opacity, mesh.vertex_colors.as_deref()),
            (1.0, Some(&[[0, 0, 0, 255]][..]))
        );
    }
}
