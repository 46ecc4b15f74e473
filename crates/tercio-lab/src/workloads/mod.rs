//! What a machine is given to draw.
