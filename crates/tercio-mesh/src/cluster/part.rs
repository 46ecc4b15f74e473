//! Meshes that are parts of a model that several processes hold.

use std::sync::OnceLock;

use super::ClusteredMesh;
use crate::Aabb;

/// What all parts of a model have in common, besides origin, unit, layout and materials: it describes the whole model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    /// World-space bounds of the vertices that triangles use.
    pub bounds: Aabb,
    /// Is any triangle not opaque by the colours of the mesh?
    pub translucent: bool,
    /// Equal for equal models, almost certainly different for others.
    pub checksum: u64,
}

impl ClusteredMesh {
    /// The mesh as a part of a model: bounds, translucency and checksum are those of the whole model then, so that views,
    /// tiles and kernels of a frame are the same for each of its parts.
    ///
    /// In the parts of a model vertices have the same order as in the whole: a triangle begins with the corner that comes
    /// first there ([`crate::Mesh::canonical`]).
    pub fn as_part_of(self, whole: &Whole) -> Self {
        let Whole { bounds, translucent, checksum } = *whole;
        Self { bounds, translucent, checksum: OnceLock::from(checksum), ..self }
    }
}
