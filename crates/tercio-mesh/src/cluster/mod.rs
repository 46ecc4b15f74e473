//! The mesh split into clusters: small, compact pieces that are culled and transformed as one.
//!
//! All data of a cluster are in one contiguous piece of memory, its *stretch*, which contains no addresses: it is the
//! same bytes in a [`ClusteredMesh`], in a file and in a message. [`ClusterView`] reads it; no other code knows its
//! layout. A vertex that several clusters share is stored in each of them.
//!
//! The modules in the order of the work: [`partition`] is the entry point ([`partition_pieces`] for small
//! pieces that share no vertices), [`crate::blocks`] bring neighbouring triangles together, `runs` or `grow` (with
//! the `rim` of the open cluster) splits a block into clusters, `gather` writes their memory (`layout` defines it),
//! `bounds` computes each cluster's box and cone, with which `farthest` measures the mesh. [`cone`] holds the culling
//! tests that a renderer makes with them. A mesh may be a `part` of a model that several processes hold; `transfer` writes
//! clusters of a part as bytes and makes a mesh of those from several parts, after `check` has verified what a renderer
//! relies on.

mod bounds;
mod buffer;
pub(crate) mod check;
mod clustered;
mod cone;
mod farthest;
mod gather;
mod grow;
mod head;
mod layout;
mod part;
mod partition;
mod pieces;
mod rim;
mod runs;
mod shuffle;
mod transfer;
mod view;

pub use crate::blocks::Order;
pub use buffer::{Buffer, Line};
pub use clustered::ClusteredMesh;
pub use head::Cluster;
pub use layout::Layout;
pub use part::Whole;
pub use partition::{PartitionOptions, partition, partition_blocks};
pub use pieces::{Piece, partition_pieces};
pub use transfer::{Assembly, TransferError, write_clusters};
pub use view::ClusterView;

/// The most vertices in a cluster: what a renderer keeps transformed in vector registers.
pub const MAX_VERTICES: usize = 64;
/// The most triangles in a cluster; a triangle's slot is `cluster * MAX_TRIANGLES + local number`.
pub const MAX_TRIANGLES: usize = 128;
/// Vertices and triangles are stored in multiples of this number, so that kernels load whole vectors.
pub const LANES: usize = 16;
