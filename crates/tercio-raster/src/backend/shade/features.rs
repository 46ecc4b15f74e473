//! The features of the shading kernel: given at run time by a [`Look`], or at compile time by a [`Common`] or [`Explained`]
//! look, for which the same kernel is specialized, without branches on most features.

use tercio_scene::Instance;

use crate::backend::corners::ColorSource;
use crate::backend::material;
use crate::context::FrameContext;
use crate::frame::Outputs;
use crate::settings::Shading;
use crate::tone::Tone;

/// The shading features that a kernel is specialized for or branches on. Those that are not implemented are those of most
/// pictures: vertex normals, one colour for the surface, distant lights, and 8-bit colours as the only plane.
pub trait Features: Copy {
    /// Most features are known at compile time: the kernel is compiled for them, into the loop that calls it.
    const ARE_SPECIAL: bool;
    /// Where light is computed.
    #[inline(always)]
    fn shading(self) -> Shading {
        Shading::Phong
    }
    /// Where the colour comes from.
    #[inline(always)]
    fn colors(self) -> ColorSource {
        ColorSource::Base
    }
    /// Does the mesh have vertex normals?
    #[inline(always)]
    fn normals(self) -> bool {
        true
    }
    /// Are the triangles' planes needed?
    #[inline(always)]
    fn plane(self) -> bool {
        false
    }
    /// Do the colours of the mesh have an alpha?
    #[inline(always)]
    fn alpha(self) -> bool {
        false
    }
    /// Are there scene-wide materials, or is shading physically based?
    #[inline(always)]
    fn materials(self) -> bool {
        false
    }
    /// Are there point lights, so that light depends on position?
    #[inline(always)]
    fn near_lights(self) -> bool {
        false
    }
    /// Is the surface specular?
    #[inline(always)]
    fn highlights(self) -> bool {
        true
    }
    /// Are 8-bit colours requested?
    #[inline(always)]
    fn color(self) -> bool {
        true
    }
    /// Is any other plane of the frame requested?
    #[inline(always)]
    fn more(self) -> bool {
        false
    }
    /// Is light tone-mapped?
    #[inline(always)]
    fn tone(self) -> bool {
        false
    }
    /// Are there lines along the sides of triangles?
    #[inline(always)]
    fn edges(self) -> bool {
        false
    }

    /// Are positions of corners needed?
    #[inline(always)]
    fn position(self) -> bool {
        self.plane() || self.near_lights() || self.materials() || self.shading() == Shading::Gouraud
    }
}

/// Shading features at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    shading: Shading,
    colors: ColorSource,
    normals: bool,
    plane: bool,
    alpha: bool,
    materials: bool,
    near_lights: bool,
    highlights: bool,
    color: bool,
    more: bool,
    tone: bool,
    edges: bool,
}

impl Look {
    /// The features for pixels of an instance; `normals_agree` as in
    /// [`Cluster::NORMALS_AGREE`](tercio_mesh::cluster::Cluster::NORMALS_AGREE).
    #[inline(always)]
    pub fn new(context: &FrameContext, instance: usize, normals_agree: bool, outputs: &Outputs) -> Self {
        let own = &context.scene.instances[instance];
        let Instance { mesh, surface, materials, .. } = own;
        let shading = context.shading_of(instance);
        let normals = mesh.layout().normals;
        let may_shine_through =
            mesh.is_translucent() || materials.as_ref().is_some_and(|m| m.is_translucent());
        Self {
            shading,
            colors: ColorSource::of(own),
            normals,
            plane: needs_plane(context, instance, normals_agree),
            alpha: own.colors_are_translucent(may_shine_through),
            materials: material::is_used(context, instance),
            near_lights: !context.lights.near.is_empty(),
            highlights: surface.specular > 0.0,
            color: outputs.color,
            more: Outputs { color: false, ..*outputs } != Outputs::NONE,
            tone: context.settings.tone != Tone::NONE && shading != Shading::Unlit,
            edges: own.edges.is_some(),
        }
    }

    /// The look with the given features.
    pub fn describe(features: impl Features) -> Self {
        Self {
            shading: features.shading(),
            colors: features.colors(),
            normals: features.normals(),
            plane: features.plane(),
            alpha: features.alpha(),
            materials: features.materials(),
            near_lights: features.near_lights(),
            highlights: features.highlights(),
            color: features.color(),
            more: features.more(),
            tone: features.tone(),
            edges: features.edges(),
        }
    }

    /// Do all points of an instance with this look have the colour of its surface?
    #[inline(always)]
    pub fn is_uniform(self) -> bool {
        let has_one_color = self.colors == ColorSource::Base && !self.materials && !self.edges;
        has_one_color && self.shading == Shading::Unlit && !self.tone
    }

    /// Does the look have exactly the given features, so that their kernel can draw it?
    #[inline(always)]
    pub fn is(self, features: impl Features) -> bool {
        self == Self::describe(features)
    }
}

/// Are the planes of an instance's triangles needed? `normals_agree` as in [`Look::new`].
#[inline(always)]
pub fn needs_plane(context: &FrameContext, instance: usize, normals_agree: bool) -> bool {
    let normals = context.scene.instances[instance].mesh.layout().normals;
    // If the instance is not scaled alike in all directions, normals may change sides in the transform to world space.
    let agree = normals_agree && context.objects[instance].similarity.is_some();
    context.settings.shading == Shading::Flat || !normals || !agree
}

impl Features for Look {
    const ARE_SPECIAL: bool = false;
    #[inline(always)]
    fn shading(self) -> Shading {
        self.shading
    }
    #[inline(always)]
    fn colors(self) -> ColorSource {
        self.colors
    }
    #[inline(always)]
    fn normals(self) -> bool {
        self.normals
    }
    #[inline(always)]
    fn plane(self) -> bool {
        self.plane
    }
    #[inline(always)]
    fn alpha(self) -> bool {
        self.alpha
    }
    #[inline(always)]
    fn materials(self) -> bool {
        self.materials
    }
    #[inline(always)]
    fn near_lights(self) -> bool {
        self.near_lights
    }
    #[inline(always)]
    fn highlights(self) -> bool {
        self.highlights
    }
    #[inline(always)]
    fn color(self) -> bool {
        self.color
    }
    #[inline(always)]
    fn more(self) -> bool {
        self.more
    }
    #[inline(always)]
    fn tone(self) -> bool {
        self.tone
    }
    #[inline(always)]
    fn edges(self) -> bool {
        self.edges
    }
}

/// The look of most pictures, with or without highlights. Its kernel is small enough to keep all values in registers.
#[derive(Clone, Copy)]
pub struct Common<const HIGHLIGHTS: bool>;

impl<const HIGHLIGHTS: bool> Features for Common<HIGHLIGHTS> {
    const ARE_SPECIAL: bool = true;
    #[inline(always)]
    fn highlights(self) -> bool {
        HIGHLIGHTS
    }
}

/// The common look with colours of data, with lines along the sides of triangles, or with both. Which of them is known at run time:
/// one kernel serves all.
#[derive(Clone, Copy, Debug)]
pub struct Explained {
    /// Colours of values that are interpolated, or of categories, without lines of equal value.
    data: bool,
    edges: bool,
}

impl Explained {
    /// The features of a look for pixels of an instance, if they are of this kind.
    #[inline(always)]
    pub fn of(look: Look, context: &FrameContext, instance: usize) -> Option<Self> {
        let has_lines =
            || context.data[instance].as_ref().is_none_or(|data| !data.mapping.isolines.is_empty());
        let features = Self { data: look.colors == ColorSource::Data, edges: look.edges };
        (look.is(features) && !(features.data && has_lines())).then_some(features)
    }
}

impl Features for Explained {
    const ARE_SPECIAL: bool = true;
    #[inline(always)]
    fn colors(self) -> ColorSource {
        if self.data { ColorSource::Data } else { ColorSource::Base }
    }
    #[inline(always)]
    fn edges(self) -> bool {
        self.edges
    }
}

#[cfg(test)]
mod tests;
