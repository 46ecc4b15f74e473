//! The conventions of the renderer, each defined in this one place.
//!
//! * **World and object space**: right-handed. The front of a triangle is the side from which its corners appear in
//!   counter-clockwise order.
//! * **Clip space**: `x`, `y` in sub-pixels times `w`, origin in the middle of the picture (see below), y downwards; `w` is
//!   the distance along the line of sight in [`View::unit`](crate::view::View::unit) (1 for an orthographic camera).
//! * **Screen space**: whole sub-pixels, origin at the upper left corner of the picture, y downwards. One pixel
//!   is [`SUBPIXELS`] sub-pixels; the sample of pixel (i, j) is its centre, at (i, j) * 256 + 128, unless there are
//!   several ([`crate::sampling`]).
//! * **Depth**: `near / w` for a perspective camera, `(far - z) / (far - near)` for an orthographic one: above 0,
//!   at most 1, larger is nearer, 0 where nothing was drawn. It is linear in screen space. The depth of a perspective
//!   camera, as a floating-point number, has the same relative precision at any distance from the near plane, so the
//!   near plane may be arbitrarily close to the eye. The depth of an orthographic camera has an absolute precision of
//!   2^-24 of the distance from near to far plane, which for a camera outside of the scene is about the scene's size.
//!   Between corners the error of the depth is no larger than that caused by snapping, because a triangle extends over
//!   at most 2^24 sub-pixels, as many as `f32` can distinguish.
//! * **Coverage**: exact integer edge functions and the top-left rule: a sample on an edge belongs to the triangle
//!   whose top or left edge it is.
//! * **Visibility**: the larger depth; among equal depths the lower primitive number; of pieces of one clipped triangle,
//!   which may overlap after snapping, the one whose mask of the samples that it covers in the pixel is the larger number.
//! * **Interpolation**: from the farthest corner (the first among equals) for depth, from all three corners for
//!   attributes; never from the origin of a tile or a block. Normals of corners are normalized in world space before
//!   they are interpolated.
//! * **Shading normal** of a pixel, for lighting and for the normals of a frame: the normalized interpolated normal
//!   (the triangle's own in flat shading and without vertex normals). It is negated if it is not on the visible side of
//!   its triangle. If it still points away from the viewer, as can happen at the silhouette of a coarse mesh, it is
//!   bent towards the viewer until it is perpendicular to the line of sight.
//! * **Pixels of several samples**: colours are averaged as linear light from 0 to 1, premultiplied by alpha, with the background's
//!   where nothing was drawn; the mean of 2^n samples is a sum of sums of neighbours in the order of the samples. Depth,
//!   id and normal are those of the sample with the largest key, the first among equals. With a filter wider than a pixel,
//!   colours (and keys, which tell whether a pixel was drawn) also depend on samples of the neighbours inside the
//!   picture; depth, id and normal do not.
//! * **Shading of several samples**: once for each triangle (each piece, if it is clipped) and pixel, at the centre of
//!   the pixel's samples that it covers, hidden or not ([`SampleCells::center`](crate::sampling::SampleCells::center)).
//! * **Rounding**: no fused multiply-add; a product is rounded before it is added, on every machine.
//!
//! # Glossary
//!
//! The terms that are this project's own, or that it uses in a narrow sense:
//!
//! * **Cluster**: neighbouring triangles of a mesh, at most [`MAX_TRIANGLES`](tercio_mesh::cluster::MAX_TRIANGLES),
//!   with their vertices; the unit of culling and binning.
//! * **Primitive number**: the number of a triangle in the order of the input, counted through the instances. It breaks
//!   ties of depth.
//! * **Slot**: the number of a triangle in the order of memory: cluster number times
//!   [`MAX_TRIANGLES`](tercio_mesh::cluster::MAX_TRIANGLES) plus its number in the cluster. Tile memory stores slots;
//!   their order has no influence on visibility.
//! * **Pivot**: the point of a mesh's box nearest to the eye; vertex positions are taken relative to it
//!   ([`ObjectView::pivot`](crate::view::ObjectView::pivot)).
//! * **Anchor**: the farthest corner of a triangle, from which its depth is interpolated.
//! * **Tile memory**: the depth and slot buffers of one tile while it is drawn. A **sample index** is the position of a
//!   sample there: its row times the stride plus its column.
//! * **Stamp**: 16 samples that are tested against a triangle at once, one row of 16 or two rows of 8, beginning at any
//!   column.
//! * **Sieve**: the step that drops the triangles of a cluster that reach no sample of a tile and groups the others by
//!   size. A triangle *reaches* a sample if its bounding box contains it.
//! * **Cell**: one of the equal squares that a pixel is divided into; samples are in the middle of some of them
//!   ([`SampleCells`](crate::sampling::SampleCells)).
//! * **Fragment**: with several samples per pixel, a triangle in a pixel, or at one sample: what is shaded once.
//! * **Halo**: the pixels around a tile that it draws because its filter needs them.
//! * **Band**: the rows of a picture that a frame holds.
//! * **Middle** of the picture: the point where the line of sight meets it, a whole number of sub-pixels from its corner. A
//!   shifted camera ([`Camera::shift`](tercio_scene::Camera)) has it elsewhere than in the centre, even outside.
//! * **Winner**: a sample at which a triangle passed the depth test.
//! * **Look**: the shading features that an instance and the settings require.
//! * **Part**: one of several equal shares of some clusters, or of the entries of a tile.
//! * **Rank**: one of the processes that draw a picture together.
//! * **Key**: depth and primitive number in one number of 64 bits, so that the larger key is visible
//!   ([`visibility_key`](crate::frame::visibility_key)). **Tie**: if primitive numbers need more, which is *wide*, the key has the upper
//!   32 bits of the number, and the tie decides by the others ([`key_and_tie`](crate::frame::key_and_tie)).

/// Sub-pixels along the edge of a pixel.
pub const SUBPIXELS: i32 = 256;
/// log2 of [`SUBPIXELS`].
pub const SUBPIXEL_BITS: u32 = 8;
/// Offset of the middle of a pixel, its only sample if it has one, from its upper left corner, in sub-pixels, in x and in y.
pub const SAMPLE: i32 = SUBPIXELS / 2;

/// The guard band: triangles extend at most this many sub-pixels from the middle of the picture; those that extend
/// farther are clipped. Differences of coordinates stay below 2^24 and are exact in `f32`.
pub const GUARD: f32 = 8_388_608.0;

/// Below this extent in sub-pixels, edge functions and areas fit into 32 bits: they are differences of two
/// products of coordinate differences.
pub const SMALL_EXTENT: i32 = 1 << 15;

/// Below this extent in sub-pixels a cluster is small: relative to a whole pixel beside it, the coordinates of all its
/// vertices fit into 16 bits.
pub const SMALL_CLUSTER: i32 = (1 << 16) - SUBPIXELS;

/// The largest number of clusters of all instances of a scene: slots number their triangles in 32 bits, the largest of which
/// stands for none.
pub const MAX_CLUSTERS: u64 = u32::MAX as u64 / tercio_mesh::cluster::MAX_TRIANGLES as u64 - 1;

/// The largest number of triangles and of input faces of all ranks together.
pub const MAX_NUMBERS: u64 = i64::MAX as u64;

/// Most points at which a texture is sampled for a pixel that covers a long stretch of it.
pub const MAX_ANISOTROPY: u32 = 16;

/// Reflectance of dielectrics that are seen from the front, in physically based shading.
pub const DIELECTRIC: f32 = 0.04;

/// The least roughness in physically based shading: highlights of directional and point lights stay visible.
pub const LEAST_ROUGHNESS: f32 = 0.05;

/// First pixel whose last column (row) of samples is at or right of (below) a screen coordinate. The samples of a pixel
/// are at least `origin` sub-pixels from its borders.
#[inline(always)]
pub fn first_pixel(coordinate: i32, origin: i32) -> i32 {
    (coordinate + (origin - 1)) >> SUBPIXEL_BITS
}

/// Last pixel whose first column (row) of samples is at or left of (above) a screen coordinate; `origin` as in
/// [`first_pixel`].
#[inline(always)]
pub fn last_pixel(coordinate: i32, origin: i32) -> i32 {
    (coordinate - origin) >> SUBPIXEL_BITS
}
