//! Polygon meshes: from a model file to a mesh that is ready to be drawn.
//!
//! The data passes through the modules in this order: [`io`] reads a file into a [`Mesh`] (polygons become triangles
//! in [`polygon`]), [`clean`] drops what cannot be drawn, [`weld`] joins the corners of triangle soups, [`normals`]
//! makes missing normals, [`blocks`] bring neighbouring triangles together, and [`cluster`] splits the mesh into the
//! small pieces that the renderer culls and transforms. [`topology`] analyses a mesh, [`builtin`] makes models
//! without a file, and [`arrays`] are those of a program.
//!
//! Positions are in object space: `world = origin + position`, with the origin in `f64`, so that a model far from
//! zero keeps its detail in `f32`.
//!
//! # Example
//!
//! ```
//! use tercio_mesh::cluster::{PartitionOptions, partition};
//! use tercio_mesh::io::{self, ReadOptions, input::Input};
//! use tercio_mesh::{normals, topology};
//!
//! let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
//! let options = ReadOptions::default();
//! let input = Input::from_bytes("pyramid.obj", obj.into(), &options)?;
//! let mut mesh = io::read_input(&input, &options)?.mesh;
//!
//! let topology = topology::analyze(&mesh);
//! assert!(topology.closed && topology.consistently_wound);
//! assert_eq!((topology.edges, topology.euler_characteristic()), (6, 2));
//!
//! normals::make_normals(&mut mesh, None);
//! let clustered = partition(mesh, &PartitionOptions::default());
//! assert_eq!(clustered.triangle_count(), 4);
//! # Ok::<(), tercio_mesh::ReadError>(())
//! ```

mod adjacency;
pub mod arrays;
pub mod blocks;
pub mod bounds;
pub mod builtin;
pub mod checksum;
pub mod clean;
pub mod clip;
pub mod cluster;
pub mod color;
mod doubles;
pub mod edges;
pub mod error;
pub mod guard;
mod hash;
pub mod io;
pub mod loops;
pub mod material;
pub mod mesh;
pub mod normals;
pub mod polygon;
pub mod progress;
pub mod radix;
pub mod strokes;
pub mod subdivide;
pub mod topology;
pub mod trig;
pub mod weld;

pub use blocks::BlockedMesh;
pub use bounds::Aabb;
pub use cluster::ClusteredMesh;
pub use error::{Place, ReadError};
pub use material::{FileMaterial, FileTexture, FileTextures, TextureChannel, TextureRole};
pub use mesh::{Attribute, AttributeDomain, Mesh};
pub use normals::OctNormal;
pub use progress::Progress;
