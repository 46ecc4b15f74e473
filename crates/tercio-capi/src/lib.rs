//! The in-situ interface of tercio for C, C++ and Fortran: a [`tercio::Session`] behind plain functions. `include/tercio.h` is
//! made from this crate by cbindgen (`cargo xtask header`), and the documentation of its functions is here.
//!
//! Functions return 0, or another number if they failed; [`tercio_last_error`] has the reason then. Those that are called
//! *collective* have to be called by all processes of a session, in the same order and with the same values, except for arrays.
//! A panic of the library is an error like any other. `unsafe` is what reads and writes through the pointers of the program.
//!
//! ```
//! use std::ptr;
//!
//! use tercio_capi::*;
//!
//! let positions = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
//! let corners = [0u32, 1, 2];
//! let arrays = tercio_arrays {
//!     vertices: 3,
//!     positions_f32: positions.as_ptr(),
//!     positions_f64: ptr::null(),
//!     triangles: 1,
//!     corners: corners.as_ptr(),
//!     normals: ptr::null(),
//!     colors: ptr::null(),
//! };
//! let session = tercio_open();
//! let (mut pixels, mut width, mut height, mut part) = (ptr::null(), 0, 0, 0);
//! // SAFETY: the session is open, the arrays live as long as the calls, and all results have a place.
//! unsafe {
//!     assert_eq!(tercio_set_picture(session, 160, 120, 4), 0);
//!     assert_eq!(tercio_add(session, &arrays, &mut part), 0);
//!     assert_eq!(tercio_render(session), 0);
//!     assert_eq!(tercio_pixels(session, &mut pixels, &mut width, &mut height), 0);
//!     let rgba = std::slice::from_raw_parts(pixels, (width * height * 4) as usize);
//!     assert!(rgba.chunks(4).any(|pixel| *pixel != rgba[..4]));
//!     tercio_close(session);
//! }
//! ```

// The names are those of C.
#![allow(non_camel_case_types, reason = "the names are those of C")]

mod arrays;
mod camera;
mod error;
mod parts;
mod picture;
mod session;
mod threads;
mod values;

pub use arrays::tercio_arrays;
pub use camera::{tercio_fit_camera, tercio_set_camera, tercio_set_up_axis};
pub use error::{tercio_last_error, tercio_version};
pub use parts::{
    tercio_add, tercio_remove, tercio_set_surface, tercio_set_transform, tercio_show, tercio_update,
};
pub use picture::{tercio_pixels, tercio_render, tercio_save, tercio_set_background, tercio_set_picture};
pub use session::{
    tercio_close, tercio_open, tercio_open_mpi, tercio_seconds_spent, tercio_session,
    tercio_set_organisation, tercio_set_timeout,
};
pub use threads::tercio_set_threads;
