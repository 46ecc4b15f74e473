//! The mesh cut into clusters: small, compact pieces that are culled and transformed as one.
//!
//! All that belongs to a cluster lies in one stretch of memory, which names no address outside of itself: in a
//! [`ClusteredMesh`], in a file and in a message it is the same bytes. [`ClusterView`] reads it; nothing else
//! knows where in it something lies. Vertices that several clusters share stand in each of them.
//!
//! The work goes through the modules in this order: [`partition`] is the entrance, [`crate::blocks`] bring
//! neighbouring triangles together, `runs` or `grow` (with the `rim` of the open cluster) cuts a block into
//! clusters, `gather` writes their stretches (`layout` says how), `bounds` finds each cluster's box and cone.
//! [`cone`] holds the tests that a renderer makes with them.

mod bounds;
mod buffer;
mod clustered;
mod cone;
mod gather;
mod grow;
mod head;
mod layout;
mod partition;
mod rim;
mod runs;
mod shuffle;
mod view;

pub use crate::blocks::Order;
pub use buffer::{Buffer, Line};
pub use clustered::ClusteredMesh;
pub use head::Cluster;
pub use layout::Layout;
pub use partition::{PartitionOptions, partition, partition_blocks};
pub use view::ClusterView;

/// The most vertices a cluster holds: what a renderer keeps transformed in vector registers.
pub const MAX_VERTICES: usize = 64;
/// The most triangles a cluster holds; a triangle's slot is `cluster * MAX_TRIANGLES + local number`.
pub const MAX_TRIANGLES: usize = 128;
/// Vertices and triangles are stored in multiples of this number, so that kernels load whole vectors.
pub const LANES: usize = 16;
