//! Drops what cannot be drawn.
