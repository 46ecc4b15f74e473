//! What explains a picture: text, scalar bars, axes and scales, drawn onto the finished picture.
//!
//! An [`Overlay`] is a list of shapes for a whole picture, which it draws in linear light with exact coverage, onto the picture or
//! a band of it ([`Overlay::draw`]) or behind what is opaque ([`Overlay::draw_behind`]). The bytes do not depend on threads or
//! machine: no mathematical function of the system is used.
#![forbid(unsafe_code)]

pub mod annotation;
pub mod axes_box;
pub mod bar;
pub mod caption;
pub mod floor;
pub mod font;
pub mod layout;
pub mod number;
pub mod outline;
pub mod overlay;
pub mod project;
pub mod scale_bar;
pub mod ticks;
pub mod triad;

pub use annotation::{Annotation, LaidOut};
pub use bar::ScalarBar;
pub use caption::Caption;
pub use font::{Direction, Line};
pub use layout::{Layout, Place, Placed};
pub use number::NumberFormat;
pub use outline::Outline;
pub use project::Projector;
pub use overlay::{ColorAt, Overlay, Paint};
