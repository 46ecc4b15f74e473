//! Transfer of pixels between ranks.
//!
//! [`packet`] is the format: it holds only drawn pixels. [`direct_send`] composites the parts of all ranks at the
//! owners of regions; [`fragments`] does so if pixels have several samples or layers; [`collect`] brings the owners' finished pixels to rank 0.

pub mod collect;
pub mod direct_send;
pub mod fragments;
pub mod packet;
