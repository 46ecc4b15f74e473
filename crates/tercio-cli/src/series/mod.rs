//! Series: many pictures of one model, or of many, in files of their own or in a film.

pub mod film;
mod form;
pub mod pattern;
pub mod pipeline;
pub mod sheet;
pub mod whole;
