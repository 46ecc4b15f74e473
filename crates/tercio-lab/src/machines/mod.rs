//! Descriptions of machines, each number with its unit and its source.
//!
//! A description is a TOML file. Every number in it is a table `{ value = "14 MHz", source = "000, 2.3" }`: a number
//! without a source is an error, as is one with a unit that does not match its key. Sources are `000` to `004`, the
//! five documents, with chapter, equation, table or figure; a data sheet; or `fitted:` and to what.
//!
//! [`NAMES`] lists the built-in machines, [`load`] takes one of their names or a file.

mod builtin;
mod check;
mod description;
mod error;
#[cfg(test)]
mod handbook;
mod kinds;
mod operations;
mod sections;
mod sourced;
mod stages;
#[cfg(test)]
mod tests;

pub use builtin::{NAMES, builtin};
pub use description::{DataKind, Machine, Network, Processors, Screen, Sorting, load, parse};
pub use error::MachineError;
pub use kinds::{Arrangement, Control, Delivery, Packing, ScreenDivision, SortingClass, Topology};
pub use operations::Operation;
pub use sections::{Assumptions, Calibration, Heap, Sdram, TileEngine, Transfer};
pub use sourced::{Cost, Sourced};
pub use stages::Stage;
