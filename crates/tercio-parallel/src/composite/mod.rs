//! Transfer of pixels between ranks.
//!
//! [`packet`] is the format: it holds only drawn pixels. [`direct_send`] composites the parts of all ranks at the
//! owners of regions; [`layers`] does so with what is not opaque; [`collect`] brings the owners' finished pixels to rank 0.

pub mod collect;
pub mod direct_send;
pub mod layers;
pub mod packet;
