//! Sizes: vertex buffers, triangle nodes, tiles, buckets (sections 1, 3.3, 3.5, 4.3 to 4.5).

use super::{NODE, TILE};
use crate::models;
use crate::models::registry::Model;
use crate::units::{Bits, Bytes, Count, Length, Polygons, Ratio, Vertices};

/// Vertices of a model whose triangles share none (1).
pub fn unshared_vertices(triangles: Polygons) -> Vertices {
    Vertices::new(3.0 * triangles.get())
}

/// Unshared over shared vertices (1).
pub fn sharing_gain(triangles: Polygons, vertices: Vertices) -> Ratio {
    Ratio::new(unshared_vertices(triangles) / vertices)
}

/// Equation 3.13: vertices per triangle of a strip of `triangles`.
pub fn strip_vertices(triangles: Count) -> Ratio {
    Ratio::new((3.0 + (triangles.get() - 1.0)) / triangles.get())
}

/// Vertex buffer of a partition: a closed mesh has half as many vertices as triangles (3.3.3).
pub fn partition_vertices(triangles: Polygons, vertex: Bytes) -> Bytes {
    vertex * (triangles.get() / 2.0)
}

/// Bytes of a buffer of `nodes` triangle nodes with its header (3.5).
pub fn node_buffer(nodes: Count, node: Bytes, header: Bytes) -> Bytes {
    node * nodes.get() + header
}

/// Bytes of a heap of triangle nodes (4.5).
pub fn heap(nodes: Polygons, node: Bytes) -> Bytes {
    node * nodes.get()
}

/// Bits left over in a word (3.5).
///
/// # Errors
/// A record wider than the word.
pub fn spare_bits(word: Bits, used: Bits) -> Result<Bits, String> {
    if used.get() > word.get() {
        return Err(format!("used: expected at most {word}, found {used}"));
    }
    Ok(word - used)
}

/// Bytes of a field of `bits`.
pub fn bytes_of_bits(bits: Bits) -> Bytes {
    bits.into()
}

/// Bytes of a tile of side `tile` with colour and depth (4.3.1).
pub fn tile_buffer(tile: Length, color: Bytes, depth: Bytes) -> Bytes {
    (color + depth) * (tile.get() * tile.get())
}

/// Tiles of a screen, each with its bucket (4.4, figure 2.14).
pub fn buckets(width: Length, height: Length, tile: Length) -> Count {
    Count::new((width / tile).ceil() * (height / tile).ceil())
}

pub(crate) const MODELS: &[Model] = models! {
    "hybris.unshared-vertices", "1", "vertices if triangles share none":
        unshared_vertices["triangles": Polygons] -> Vertices;
    "hybris.sharing-gain", "1", "unshared over shared vertices":
        sharing_gain["triangles": Polygons, "vertices": Vertices] -> Ratio;
    "hybris.3.13", "eq 3.13", "vertices per triangle of a strip of n":
        strip_vertices["n": Count where 1.0] -> Ratio;
    "hybris.partition-vertices", "3.3.3", "vertex buffer of a partition":
        partition_vertices["triangles": Polygons = 500.0, "vertex": Bytes = 32.0] -> Bytes;
    "hybris.node-buffer", "3.5", "bytes of a buffer of nodes with header":
        node_buffer["nodes": Count = 63.0, "node": Bytes = NODE, "header": Bytes = 64.0] -> Bytes;
    "hybris.heap", "4.5", "bytes of a heap of nodes":
        heap["nodes": Polygons, "node": Bytes = NODE] -> Bytes;
    "hybris.spare-bits", "3.5", "bits left over in a word":
        spare_bits["word": Bits, "used": Bits] -> Result<Bits, String>;
    "hybris.bytes-of-bits", "3.5", "bytes of a field":
        bytes_of_bits["bits": Bits] -> Bytes;
    "hybris.tile-buffer", "4.3.1", "bytes of a tile":
        tile_buffer["S": Length = TILE, "color": Bytes = 1.0, "depth": Bytes = 4.0] -> Bytes;
    "hybris.buckets", "4.4", "tiles of a screen":
        buckets["width": Length, "height": Length, "S": Length = TILE] -> Count;
};
