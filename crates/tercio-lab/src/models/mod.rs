//! The closed formulas of the documents.
