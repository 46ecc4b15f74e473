//! What a shading kernel is asked for: answered at run time by a [`Look`], or at compile time by a [`Common`] look, for
//! which the same kernel is compiled again without the questions.

use tercio_scene::Instance;

use crate::backend::corners::ColorSource;
use crate::context::FrameContext;
use crate::frame::Outputs;
use crate::settings::Shading;

/// Questions of the kernel.
pub trait Features: Copy {
    /// All answers are known at compile time.
    const ARE_CONSTANT: bool;
    /// Where light is computed.
    fn shading(self) -> Shading;
    /// Where the colour comes from.
    fn colors(self) -> ColorSource;
    /// Do the vertices have normals?
    fn normals(self) -> bool;
    /// Are the triangles' planes needed?
    fn plane(self) -> bool;
    /// Does light depend on where a point is?
    fn near_lights(self) -> bool;
    /// Do lights leave highlights?
    fn highlights(self) -> bool;
    /// Are 8-bit colours asked for?
    fn color(self) -> bool;
    /// Is another plane of the frame asked for?
    fn more(self) -> bool;

    /// Are positions of corners needed?
    #[inline(always)]
    fn position(self) -> bool {
        self.plane() || self.near_lights() || self.shading() == Shading::Gouraud
    }
}

/// Answers at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    shading: Shading,
    colors: ColorSource,
    normals: bool,
    plane: bool,
    near_lights: bool,
    highlights: bool,
    color: bool,
    more: bool,
}

impl Look {
    /// Of pixels of an instance; `normals_agree` as in [`Cluster::NORMALS_AGREE`](tercio_mesh::cluster::Cluster::NORMALS_AGREE).
    #[inline(always)]
    pub fn new(context: &FrameContext, instance: usize, normals_agree: bool, outputs: &Outputs) -> Self {
        let Instance { mesh, surface, .. } = &context.scene.instances[instance];
        let shading = context.settings.shading;
        let normals = mesh.layout().normals;
        Self {
            shading,
            colors: ColorSource::of(mesh, surface),
            normals,
            plane: needs_plane(context, instance, normals_agree),
            near_lights: !context.lights.near.is_empty(),
            highlights: surface.specular > 0.0,
            color: outputs.color,
            more: Outputs { color: false, ..*outputs } != Outputs::NONE,
        }
    }

    /// The look that some features describe.
    pub fn describe(features: impl Features) -> Self {
        Self {
            shading: features.shading(),
            colors: features.colors(),
            normals: features.normals(),
            plane: features.plane(),
            near_lights: features.near_lights(),
            highlights: features.highlights(),
            color: features.color(),
            more: features.more(),
        }
    }

    /// Is this the look that a kernel was compiled for?
    #[inline(always)]
    pub fn is(self, features: impl Features) -> bool {
        self == Self::describe(features)
    }
}

/// Are the planes of an instance's triangles needed? `normals_agree` as in [`Look::new`].
#[inline(always)]
pub fn needs_plane(context: &FrameContext, instance: usize, normals_agree: bool) -> bool {
    let normals = context.scene.instances[instance].mesh.layout().normals;
    // Where not all directions are scaled alike, normals may change sides on the way to world space.
    let agree = normals_agree && context.objects[instance].similarity.is_some();
    context.settings.shading == Shading::Flat || !normals || !agree
}

impl Features for Look {
    const ARE_CONSTANT: bool = false;
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
}

/// The look of most pictures: normals at the vertices, one colour for the surface, distant lights, 8-bit colours and
/// nothing else. It asks for so little that all of it stays in registers.
#[derive(Clone, Copy)]
pub struct Common<const HIGHLIGHTS: bool>;

impl<const HIGHLIGHTS: bool> Features for Common<HIGHLIGHTS> {
    const ARE_CONSTANT: bool = true;
    #[inline(always)]
    fn shading(self) -> Shading {
        Shading::Phong
    }
    #[inline(always)]
    fn colors(self) -> ColorSource {
        ColorSource::Base
    }
    #[inline(always)]
    fn normals(self) -> bool {
        true
    }
    #[inline(always)]
    fn plane(self) -> bool {
        false
    }
    #[inline(always)]
    fn near_lights(self) -> bool {
        false
    }
    #[inline(always)]
    fn highlights(self) -> bool {
        HIGHLIGHTS
    }
    #[inline(always)]
    fn color(self) -> bool {
        true
    }
    #[inline(always)]
    fn more(self) -> bool {
        false
    }
}
