//! The layout of a file.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use crate::FileMaterial;
use crate::cluster::{ClusteredMesh, Layout, Line};

/// The first bytes. As in PNG, they reveal transfers that changed bytes above 127 or line ends.
pub const MAGIC: [u8; 12] = *b"\x89TERCIO\r\n\x1a\n\0";

/// Version of the layout of the file and of the clusters in it. A reader accepts only its own version: making a file
/// again takes about as long as converting it.
pub const VERSION: u32 = 6;

/// Parts begin at multiples of this: as a mapping begins at a page boundary, lines are aligned in it.
pub const ALIGNMENT: u64 = Line::BYTES as u64;

/// The kinds of parts, in the order of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Kind {
    /// [`Description`] as JSON.
    Description,
    /// Arbitrary information from the program that made the file.
    About,
    /// A [`Cluster`](crate::cluster::Cluster) for each cluster.
    Heads,
    /// The first line of each cluster, and the end of the last cluster: 32 bits each.
    Starts,
    /// The input face of each primitive, 32 bits each; empty where face i is primitive i.
    Faces,
    /// The memory of the clusters.
    Lines,
}

impl Kind {
    /// All, in order.
    pub const ALL: [Self; 6] =
        [Self::Description, Self::About, Self::Heads, Self::Starts, Self::Faces, Self::Lines];

    /// The name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Description => "description",
            Self::About => "origin",
            Self::Heads => "cluster heads",
            Self::Starts => "cluster starts",
            Self::Faces => "face numbers",
            Self::Lines => "clusters",
        }
    }
}

/// Where a part is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Part {
    /// Its first byte.
    pub offset: u64,
    /// Its length in bytes.
    pub bytes: u64,
    /// [`crate::checksum::of`] of its bytes.
    pub checksum: u64,
}

/// The first bytes of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 12],
    /// [`VERSION`].
    pub version: u32,
    /// Bytes of the whole file.
    pub file_bytes: u64,
    /// The parts, in the order of [`Kind::ALL`].
    pub parts: [Part; Kind::ALL.len()],
    /// [`crate::checksum::of`] of all bytes of the header before this.
    pub checksum: u64,
}

impl Header {
    /// Number of bytes of the header that its checksum covers.
    pub const CHECKED: usize = size_of::<Self>() - size_of::<u64>();
}

/// Description of the mesh, apart from its arrays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// [`ClusteredMesh::origin`].
    pub origin: [f64; 3],
    /// [`ClusteredMesh::exponent`].
    pub exponent: i32,
    /// What the clusters store.
    pub layout: Layout,
    /// [`ClusteredMesh::materials`].
    pub materials: Vec<FileMaterial>,
}

impl Description {
    /// The description of a mesh.
    pub fn of(mesh: &ClusteredMesh) -> Self {
        Self {
            origin: mesh.origin.to_array(),
            exponent: mesh.exponent,
            layout: mesh.layout().clone(),
            materials: mesh.materials.clone(),
        }
    }
}
