//! Effects that are computed from a finished picture's planes: they darken what is visible.
//!
//! [`AmbientOcclusion`] darkens gaps and pockets, [`EyeDome`] outlines steps of depth. Each pixel is computed from the
//! finished depths and normals by operations that are the same at every SIMD level, so that the result does not depend on
//! tiles, threads, ranks or SIMD levels, and there are no seams. The whole picture must be there: a band is not enough.
//!
//! They take light from all of a pixel's colour. Pixels at the edge of a model show some background, too: it keeps its light
//! if the picture is drawn on a transparent background, and [`add_background`] puts the real one behind it afterwards.
//!
//! [`surface`] says where the visible points are, in the camera's axes; [`darken`] takes light away from rows of colours.

#![forbid(unsafe_code)]

pub mod background;
pub mod darken;
pub mod eye_dome;
mod lanes;
pub mod occlusion;
pub mod surface;

pub use background::add_background;
pub use eye_dome::EyeDome;
pub use occlusion::AmbientOcclusion;
