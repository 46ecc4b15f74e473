//! Figures and tables of document 003.

pub mod overlap;
pub mod sizing;

use super::ExperimentError;
use super::facts::Facts;
use crate::units::{Cycles, Length};

/// Sides of the arrays: 1 to 512.
pub(super) const SIDES: [u32; 10] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512];
/// Polygons of the image of table 1.
pub(super) const POLYGONS: f64 = 50_041.0;
/// Mean area of their bounding boxes, pixels (table 3).
pub(super) const BOX_AREA: f64 = 23.91;

/// The label of rates that we compute from the raster cycles of table 1; table 2 prints them.
pub(super) const FROM_CYCLES: &str = "from the cycles of table 1";

/// Measured raster cycles of table 1, by the side of the array.
pub(super) fn raster_cycles(facts: &Facts) -> Result<Vec<(Length, Cycles)>, ExperimentError> {
    let cycles = |side: u32| facts.given(&format!("M-T1-{side}"), "R_A");
    SIDES.iter().map(|&side| Ok((Length::new(side.into()), Cycles::new(cycles(side)?)))).collect()
}
