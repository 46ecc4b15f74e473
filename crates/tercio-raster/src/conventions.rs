//! Every convention of the picture, written once.
//!
//! * **World and object space**: right-handed. A triangle's front is the side from which its corners run
//!   counter-clockwise.
//! * **Clip space**: `x`, `y` in sub-pixels times `w`, origin in the middle of the picture, y downwards; `w` is
//!   the distance along the line of sight in [`View::unit`](crate::view::View::unit) (1 for an orthographic camera).
//! * **Screen space**: whole sub-pixels, origin at the upper left corner of the picture, y downwards. One pixel
//!   is [`SUBPIXELS`] sub-pixels; the sample of pixel (i, j) is its centre, at (i, j) * 256 + 128.
//! * **Depth**: `near / w` for a perspective camera, `(far - z) / (far - near)` for an orthographic one: above 0,
//!   at most 1, larger is nearer, 0 where nothing was drawn. It is linear in screen space. As a floating-point number
//!   that of a perspective camera is as exact at any distance from the near plane, which may therefore stand as near as
//!   it likes; that of an orthographic camera is exact to 2^-24 of the distance from near to far plane, which for a
//!   camera outside of the scene is about the scene's size. Between corners its error is no larger than what snapping
//!   does to it, because a triangle reaches over at most 2^24 sub-pixels, as many as `f32` tells apart.
//! * **Coverage**: exact integer edge functions; a sample on an edge belongs to the triangle whose top or left
//!   edge it is.
//! * **Visibility**: the larger depth; among equals the lower primitive number.
//! * **Interpolation**: from the farthest corner (the first among equals) for depth, from all three corners for
//!   attributes; never from where a tile or a block happens to begin. Normals of corners have length 1 in world space
//!   before they are interpolated.
//! * **Shading normal** of a pixel, in the picture as in the normals of a frame: the interpolated normal of length 1
//!   (the triangle's own in flat shading and without vertex normals), negated where it stands on the other side of its
//!   triangle than the one that is seen; where it still points away from the viewer, as it may at the rim of a coarse
//!   mesh, bent towards the viewer until it is perpendicular to the line of sight.
//!
//! # Glossary
//!
//! The few terms that are this project's own:
//!
//! * **Slot**: the number of a triangle in a frame by its place in memory: cluster number times
//!   [`MAX_TRIANGLES`](tercio_mesh::cluster::MAX_TRIANGLES) plus its number in the cluster. Tile memory stores slots; it says
//!   nothing about visibility.
//! * **Stamp**: 16 samples that are tested against a triangle at once, one row of 16 or two rows of 8, beginning at any
//!   column.
//! * **Sieve**: the step that drops the triangles of a cluster that reach no sample of a tile and groups the others by
//!   size.
//! * **Key**: the rule of visibility as one number of 64 bits ([`visibility_key`](crate::frame::visibility_key)).
//!
//! No operation here is fused: a product is rounded before it is added to, on every machine.

/// Sub-pixel positions along a pixel's edge.
pub const SUBPIXELS: i32 = 256;
/// log2 of [`SUBPIXELS`].
pub const SUBPIXEL_BITS: u32 = 8;
/// A sample's place inside its pixel, in sub-pixels.
pub const SAMPLE: i32 = SUBPIXELS / 2;

/// Triangles reach at most this many sub-pixels from the middle of the picture; those that go farther are
/// clipped. Differences of coordinates stay below 2^24 and are exact in `f32`.
pub const GUARD: f32 = 8_388_608.0;

/// Below this extent in sub-pixels, edge functions and areas fit into 32 bits: they are differences of two
/// products of coordinate differences.
pub const SMALL_EXTENT: i32 = 1 << 15;

/// Below this extent in sub-pixels a cluster is small: from a whole pixel beside it every vertex is at most 16
/// bits away.
pub const SMALL_CLUSTER: i32 = (1 << 16) - SUBPIXELS;

/// First pixel whose sample is at or right of (below) a screen coordinate.
#[inline(always)]
pub fn first_sample(coordinate: i32) -> i32 {
    (coordinate + (SAMPLE - 1)) >> SUBPIXEL_BITS
}

/// Last pixel whose sample is at or left of (above) a screen coordinate.
#[inline(always)]
pub fn last_sample(coordinate: i32) -> i32 {
    (coordinate - SAMPLE) >> SUBPIXEL_BITS
}
