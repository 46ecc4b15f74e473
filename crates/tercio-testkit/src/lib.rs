//! Shared by the tests; never part of a release.
//!
//! [`data`] finds the models beside the checkout, [`picture`] reads, writes and compares pictures, and [`golden`]
//! compares a test's picture with the accepted one, and [`gallery`] those of the documentation. [`ray_caster`] computes what a picture should show, without any
//! code of the renderer. Pictures are plain RGBA8 slices, so that every crate, including the renderer, can use this one
//! in its tests.
//!
//! # Example
//!
//! ```
//! use tercio_testkit::Picture;
//!
//! let expected = Picture::new(2, 1, vec![10, 20, 30, 255, 40, 50, 60, 255]);
//! let actual = Picture::new(2, 1, vec![10, 20, 30, 255, 40, 53, 60, 255]);
//! let difference = expected.compare(&actual);
//! assert_eq!((difference.differing, difference.largest), (1, 3));
//! assert_eq!(difference.to_string(), "1 of 2 pixels differ, by at most 3, by 0.3750 in the mean");
//! ```

#![forbid(unsafe_code)]

pub mod data;
pub mod gallery;
pub mod golden;
pub mod picture;
pub mod ray_caster;

pub use data::{require_shared, shared_data, workspace_root};
pub use picture::{Difference, Picture, compare};
