//! Exact simulators of the published machines.
