//! Polygon meshes: what stands in the file, made ready to be drawn.
//!
//! The data walks through the modules in this order:
//! [`io`] reads a file into a [`Mesh`] (polygons become triangles in [`polygon`]), [`clean`] drops what
//! cannot be drawn, [`weld`] joins the corners of triangle soups, [`normals`] makes the normals that the
//! file does not hold, [`blocks`] bring neighbouring triangles together, and [`cluster`] cuts the mesh into the small pieces that the renderer culls and
//! transforms. [`topology`] answers questions about a mesh, [`builtin`] makes models without a file.
//!
//! Positions are in object space: `world = origin + position`, with the origin in `f64`, so that a model
//! far from zero keeps its detail in `f32`.

mod adjacency;
pub mod blocks;
pub mod bounds;
pub mod builtin;
pub mod clean;
pub mod cluster;
pub mod error;
mod hash;
pub mod io;
pub mod mesh;
pub mod normals;
pub mod polygon;
pub mod progress;
pub mod subdivide;
pub mod topology;
pub mod trig;
pub mod weld;

pub use blocks::BlockedMesh;
pub use bounds::Aabb;
pub use cluster::ClusteredMesh;
pub use error::{Place, ReadError};
pub use mesh::{Attribute, AttributeDomain, FileMaterial, Mesh};
pub use normals::OctNormal;
pub use progress::Progress;
