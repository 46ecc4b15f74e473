//! What is drawn and from where: [`Scene`], [`Camera`], [`Light`], [`Surface`].
//!
//! World space is right-handed, any unit; colours are linear light unless a name says sRGB.

pub mod camera;
pub mod color;
pub mod framing;
pub mod light;
pub mod scene;

pub use camera::{Camera, Projection};
pub use color::srgb_to_linear;
pub use framing::{Framing, UpAxis, View};
pub use light::{Light, LightSpace};
pub use scene::{Background, Instance, Scene, Surface};
