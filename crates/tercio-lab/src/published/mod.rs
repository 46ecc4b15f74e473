//! The published numbers, recomputed.
