//! What the renderer and its ranks count, against the documents' formulas.

mod overlap;
mod ring;
