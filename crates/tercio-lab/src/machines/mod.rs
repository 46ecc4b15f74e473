//! Descriptions of machines, each number with its source.
