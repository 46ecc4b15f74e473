//! The projected vertices of clusters that are small on the screen.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, u16x32, u32x16};
use tercio_mesh::cluster::{ClusterView, MAX_VERTICES};

use super::{CornerNumbers, CornerTable, Projected, positions, project};
use crate::conventions::{SAMPLE, SMALL_EXTENT, SUBPIXEL_BITS, SUBPIXELS};
use crate::screen::PixelRect;
use crate::simd::{LANES, each3, lookup, part, splat_i};
use crate::view::{ObjectView, ScreenVertex, Sight};

/// The projected vertices of a small cluster that is inside the near plane and the guard band. Its coordinates are
/// local: relative to a pixel beside the cluster, so that x and y fit into 16 bits each.
#[derive(Debug)]
pub struct LocalVertices {
    /// Sub-pixels from the upper left corner of [`LocalVertices::pixel`]: x in the lower 16 bits, y in the upper.
    xy: [i32; MAX_VERTICES],
    /// Depths, as the bits of an `f32`.
    d: [i32; MAX_VERTICES],
    /// Column and row of the pixel that is the origin of the local coordinates.
    pub pixel: [i32; 2],
    /// The cluster extends over [`SMALL_EXTENT`] sub-pixels or more, so that its triangles may, too.
    pub is_wide: bool,
    /// One of its triangles does, so that its areas may not fit into 32 bits.
    pub has_wide_triangles: bool,
}

impl Default for LocalVertices {
    fn default() -> Self {
        Self {
            xy: [0; MAX_VERTICES],
            d: [0; MAX_VERTICES],
            pixel: [0; 2],
            is_wide: false,
            has_wide_triangles: false,
        }
    }
}

impl LocalVertices {
    /// Projects all vertices of a cluster that is less than [`SMALL_CLUSTER`](crate::conventions::SMALL_CLUSTER)
    /// sub-pixels across and down.
    #[inline(always)]
    pub fn project<S: Simd>(&mut self, simd: S, object: &ObjectView, cluster: &ClusterView) {
        let axes = cluster.positions();
        let mut out_of_range = 0;
        let mut first = 0;
        while first < axes[0].len() {
            let v = project(simd, object, positions(simd, &axes, first));
            if first == 0 {
                let beside = |coordinate: i32| (coordinate - SMALL_EXTENT / 2) >> SUBPIXEL_BITS;
                self.pixel = [beside(v.x[0]), beside(v.y[0])];
            }
            out_of_range |= self.store(simd, first, &v);
            first += LANES;
        }
        (self.is_wide, self.has_wide_triangles) = (false, false);
        if out_of_range & 0xffff != 0 {
            self.project_wide(simd, object, cluster);
        }
    }

    /// Stores 16 vertices. Returns the lanes that are out of range: [`SMALL_EXTENT`] or more from the origin pixel, or
    /// to the left of it or above it.
    #[inline(always)]
    fn store<S: Simd>(&mut self, simd: S, first: usize, v: &Projected<S>) -> u32 {
        let [x, y] = self.pixel.map(|p| p << SUBPIXEL_BITS);
        let to = first..first + LANES;
        v.d.bitcast::<i32x16<S>>().store_slice(&mut self.d[to.clone()]);
        part(
            simd,
            #[inline(always)]
            || {
                let (x, y) = (v.x - x, v.y - y);
                ((x & 0xffff) | (y << 16)).store_slice(&mut self.xy[to]);
                let in_range = ((x | y) & !(SMALL_EXTENT - 1)).simd_eq(splat_i(simd, 0));
                !in_range.to_bitmask() as u32
            },
        )
    }

    /// The same for a cluster that may be wide, or whose first vertex is not near its middle.
    #[cold]
    #[inline(never)]
    fn project_wide<S: Simd>(&mut self, simd: S, object: &ObjectView, cluster: &ClusterView) {
        simd.vectorize(
            #[inline(always)]
            || {
                let axes = &cluster.positions();
                let count = axes[0].len();
                let (mut least, mut most) = ([i32::MAX; 2], [i32::MIN; 2]);
                for first in (0..count).step_by(LANES) {
                    let v = project(simd, object, positions(simd, axes, first));
                    for lane in 0..LANES {
                        for (k, coordinate) in [v.x[lane], v.y[lane]].into_iter().enumerate() {
                            least[k] = least[k].min(coordinate);
                            most[k] = most[k].max(coordinate);
                        }
                    }
                }
                self.pixel = [least[0] >> SUBPIXEL_BITS, least[1] >> SUBPIXEL_BITS];
                for k in 0..2 {
                    self.is_wide |= most[k] - least[k] >= SMALL_EXTENT;
                }
                for first in (0..count).step_by(LANES) {
                    let v = project(simd, object, positions(simd, axes, first));
                    self.store(simd, first, &v);
                }
                self.has_wide_triangles = self.is_wide && self.is_any_triangle_wide(simd, cluster);
            },
        );
    }

    /// Does a triangle extend over [`SMALL_EXTENT`] sub-pixels or more?
    #[inline(always)]
    fn is_any_triangle_wide<S: Simd>(&self, simd: S, cluster: &ClusterView) -> bool {
        let (corners, count) = (CornerTable::new(cluster), cluster.triangles());
        let mut most = splat_i(simd, 0);
        for first in (0..count).step_by(LANES) {
            // Of the lanes behind the last triangle, each has the last one.
            let triangles = std::array::from_fn(|lane| (first + lane).min(count - 1) as u8);
            for k in self.coordinates(simd, &corners.look_up(simd, &triangles)) {
                most = most.max(k[0].max(k[1]).max(k[2]) - k[0].min(k[1]).min(k[2]));
            }
        }
        most.simd_ge(splat_i(simd, SMALL_EXTENT)).any_true()
    }

    /// One vertex in screen coordinates.
    pub fn vertex(&self, corner: u8) -> ScreenVertex {
        let v = usize::from(corner) % MAX_VERTICES;
        let xy = self.xy[v] as u32;
        ScreenVertex {
            x: (self.pixel[0] << SUBPIXEL_BITS) + (xy & 0xffff) as i32,
            y: (self.pixel[1] << SUBPIXEL_BITS) + (xy >> 16) as i32,
            d: f32::from_bits(self.d[v] as u32),
            inside: true,
        }
    }

    /// Depths of the corners of 16 triangles.
    #[inline(always)]
    pub fn depths<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [f32x16<S>; 3] {
        each3!(K => lookup(simd, &self.d, &corners[K]).bitcast())
    }

    /// Depths of 16 vertices, from vertex `first` on, a multiple of 16.
    #[inline(always)]
    pub fn depths_of_16<S: Simd>(&self, simd: S, first: usize) -> f32x16<S> {
        i32x16::from_slice(simd, &self.d[first..first + LANES]).bitcast()
    }

    /// Local coordinates of the corners of 16 triangles: x, y.
    #[inline(always)]
    pub fn coordinates<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [[i32x16<S>; 3]; 2] {
        let xy: [u32x16<S>; 3] = each3!(K => lookup(simd, &self.xy, &corners[K]).bitcast());
        part(
            simd,
            #[inline(always)]
            || [each3!(K => (xy[K] & 0xffff).bitcast()), each3!(K => (xy[K] >> 16).bitcast())],
        )
    }

    /// Local coordinates of all vertices, x and y interleaved, 16 vertices per register.
    #[inline(always)]
    pub fn packed<S: Simd>(&self, simd: S) -> [u16x32<S>; 4] {
        let (xy, _) = self.xy.as_chunks::<LANES>();
        [
            i32x16::load_array(simd, xy[0]).bitcast(),
            i32x16::load_array(simd, xy[1]).bitcast(),
            i32x16::load_array(simd, xy[2]).bitcast(),
            i32x16::load_array(simd, xy[3]).bitcast(),
        ]
    }

    /// The sample of a pixel of the picture, in local coordinates.
    #[inline(always)]
    pub fn sample_of(&self, pixel: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|k| (pixel[k] - self.pixel[k]) * SUBPIXELS + SAMPLE)
    }

    /// The offset from local coordinates to coordinates relative to the middle of the picture.
    #[inline(always)]
    pub fn offset_from_middle(&self, sight: &Sight) -> [i32; 2] {
        [0, 1].map(|k| (self.pixel[k] << SUBPIXEL_BITS) - sight.middle[k])
    }

    /// A rectangle of pixels of the picture, relative to [`LocalVertices::pixel`].
    #[inline(always)]
    pub fn to_local(&self, rect: PixelRect) -> PixelRect {
        let [x, y] = self.pixel;
        PixelRect { x0: rect.x0 - x, x1: rect.x1 - x, y0: rect.y0 - y, y1: rect.y1 - y }
    }
}
