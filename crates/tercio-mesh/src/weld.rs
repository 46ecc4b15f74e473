//! Joins vertices that stand at the same place.
