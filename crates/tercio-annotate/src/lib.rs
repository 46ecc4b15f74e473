//! What explains a picture: text, scalar bars, axes and scales, drawn onto the finished picture.
//!
//! An [`Overlay`] is a list of shapes for a whole picture, which it draws in linear light with exact coverage, onto the picture or
//! a band of it ([`Overlay::draw`]) or behind what is opaque ([`Overlay::draw_behind`]). The bytes do not depend on threads or
//! machine: no mathematical function of the system is used.
//!
//! ```
//! use tercio_annotate::{Annotation, Caption};
//! use tercio_raster::frame::Planes;
//! use tercio_scene::{Camera, Projection};
//!
//! let camera = Camera {
//!     eye: [3.0, 2.0, 9.0].into(),
//!     target: [0.0; 3].into(),
//!     up: [0.0, 1.0, 0.0].into(),
//!     projection: Projection::Orthographic { height: 4.0 },
//!     near: None,
//!     shift: [0.0; 2],
//! };
//! let annotation = Annotation { captions: vec![Caption::title("Step 12")], ..Annotation::default() };
//! let laid_out = annotation.lay_out(&camera, (320, 240), [[-1.0; 3].into(), [1.0; 3].into()], [0.0, 1.0, 0.0].into())?;
//! let mut planes = Planes { color: vec![[255; 4]; 320 * 240], ..Planes::default() };
//! laid_out.onto.draw(&mut planes, 320, 0..240);
//! assert!(planes.color.iter().any(|pixel| pixel[0] < 60));
//! # Ok::<(), tercio_scene::camera::CameraError>(())
//! ```

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
pub use bar::{Marks, ScalarBar};
pub use caption::Caption;
pub use font::{Direction, Line};
pub use layout::{Layout, Place, Placed};
pub use number::NumberFormat;
pub use outline::Outline;
pub use overlay::{ColorAt, Overlay, Paint};
pub use project::Projector;
