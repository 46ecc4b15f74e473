//! What depends on the whole of a model.

use crate::loops::prelude::*;

use crate::OctNormal;
use crate::io::translucent::Unseen;
use crate::io::{ReadModel, Translucent, count_all, warn_of_normals};

/// What the parts of a model have to know of all of them together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// A part has a valid normal in the file.
    pub has_normals: bool,
    /// A part has colours of its own that are not invisible, or has none at all.
    pub has_visible_colors: bool,
    /// The same of materials.
    pub has_visible_materials: bool,
}

impl Facts {
    /// Those of a part that was read with [`ReadOptions::is_part`](crate::io::ReadOptions::is_part).
    pub fn of(model: &ReadModel) -> Self {
        let normals = model.mesh.normals.as_deref().unwrap_or_default();
        let has_normals = normals.par_iter().any(|n| *n != OctNormal::NONE);
        // A part without triangles does not decide.
        let decides = !model.mesh.triangles.is_empty();
        let unseen = Translucent::look(&model.mesh).1;
        Self {
            has_normals,
            has_visible_colors: decides && !unseen.colors,
            has_visible_materials: decides && !unseen.materials,
        }
    }

    /// As a number; those of several parts are combined with *or*.
    pub fn bits(self) -> u64 {
        let all = [self.has_normals, self.has_visible_colors, self.has_visible_materials];
        all.iter().rev().fold(0, |bits, &bit| bits << 1 | u64::from(bit))
    }

    /// From [`Facts::bits`].
    pub fn from_bits(bits: u64) -> Self {
        let bit = |number: u32| bits >> number & 1 == 1;
        Self { has_normals: bit(0), has_visible_colors: bit(1), has_visible_materials: bit(2) }
    }

    /// Does with a part what the reader does with a whole model: normals of which none is valid are dropped, an alpha of 0
    /// everywhere becomes 1, and what is not drawn and not opaque is counted. These are the facts of all parts together.
    pub fn settle(self, model: &mut ReadModel) {
        warn_of_normals(model);
        let count = model.mesh.positions.len();
        let normals = model.mesh.normals.take();
        // A part may have no valid normal, although others have.
        model.mesh.normals =
            self.has_normals.then(|| normals.unwrap_or_else(|| vec![OctNormal::NONE; count]));
        if !self.has_visible_colors && !self.has_visible_materials {
            return count_all(model);
        }
        model.report.not_drawn.count_mesh(&model.mesh, model.report.faces);
        let unseen = Unseen { colors: !self.has_visible_colors, materials: !self.has_visible_materials };
        model.report.warnings.extend(unseen.make_opaque(&mut model.mesh));
        model.report.translucent = Translucent::look(&model.mesh).0;
    }
}
