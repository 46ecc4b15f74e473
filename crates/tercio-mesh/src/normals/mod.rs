//! Vertex normals: how they are stored and how missing ones are made.

mod make;
mod oct;

pub use make::make_normals;
pub use oct::OctNormal;
