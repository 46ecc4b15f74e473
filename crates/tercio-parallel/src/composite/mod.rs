//! Pixels on their way between ranks.
//!
//! [`packet`] is how they travel: only those that show something. [`direct_send`] composes the parts of all ranks at the
//! owners of regions; [`collect`] brings the owners' finished pixels to rank 0.

pub mod collect;
pub mod direct_send;
pub mod packet;
