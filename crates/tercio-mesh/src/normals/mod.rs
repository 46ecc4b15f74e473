//! Vertex normals: how they are stored and how missing ones are made.

mod oct;

pub use oct::OctNormal;
