//! The published numbers, recomputed.
//!
//! The table (`data/published/*.toml`, one file per document) has the facts: what is expected, what the document
//! prints, where, and which entry of the [registry](crate::models::registry) computes it from which arguments. The code
//! that computes is in [`mod@crate::models`] and [`crate::simulators`] and has no access to the table, so it cannot
//! return a printed number: [`check`] evaluates the entry and compares. How ours relates to the print is an
//! [`Agreement`], found from the numbers; why it differs, and where a tolerance comes from, are in the row.
//!
//! To have a number computed by a simulator, declare the simulator with [`models!`](crate::models!) in its own module,
//! add that module to `models::MODULES`, and name it in the table's row.

mod agreement;
mod check;
mod table;
mod tolerance;

pub use agreement::{Agreement, summary};
pub use check::{Check, check, check_all};
pub use table::{Basis, Number, Side, Standing, TableError, numbers};
pub use tolerance::ToleranceSource;
