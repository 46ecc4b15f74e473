//! Vertices to the screen, and the triangles between them, 16 at a time.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16, u8x64, u16x32, u32x16};
use tercio_mesh::cluster::{ClusterView, MAX_TRIANGLES, MAX_VERTICES};

use crate::binning::PixelRect;
#[cfg(doc)]
use crate::binning::ScreenTriangle;
use crate::conventions::{GUARD, SAMPLE, SMALL_EXTENT, SUBPIXEL_BITS, SUBPIXELS};
use crate::simd::{LANES, MANY, each3, load, lookup, lookup_bytes, part, row, splat, splat_i};
use crate::view::{ObjectView, ScreenVertex, Sight};

/// 16 projected vertices.
pub struct Projected<S: Simd> {
    /// Screen coordinates.
    pub x: i32x16<S>,
    /// Screen coordinates.
    pub y: i32x16<S>,
    /// Depths.
    pub d: f32x16<S>,
    /// Lanes that lie inside the near plane and the guard band; the others hold nothing of use.
    pub inside: mask32x16<S>,
}

/// [`ObjectView::project`], lane by lane.
#[inline(always)]
pub fn project<S: Simd>(simd: S, view: &ObjectView, p: [f32x16<S>; 3]) -> Projected<S> {
    part(
        simd,
        #[inline(always)]
        || {
            let p = relative(simd, view, p);
            let (cx, cy) = (row(simd, &view.x, p), row(simd, &view.y, p));
            let (x, y, d, in_front) = if view.perspective {
                let w = row(simd, &view.w, p);
                let inverse = splat(simd, 1.0) / w;
                let near = splat(simd, view.near);
                (cx * inverse, cy * inverse, near * inverse, w.simd_ge(near))
            } else {
                let d = row(simd, &view.d, p);
                (cx, cy, d, d.simd_le(splat(simd, 1.0)))
            };
            let guard = splat(simd, GUARD);
            Projected {
                x: snap(x) + view.offset[0],
                y: snap(y) + view.offset[1],
                d,
                inside: in_front & x.abs().simd_le(guard) & y.abs().simd_le(guard),
            }
        },
    )
}

/// [`ObjectView::relative`], lane by lane.
#[inline(always)]
pub fn relative<S: Simd>(simd: S, view: &ObjectView, p: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    each3!(K => p[K] - splat(simd, view.pivot[K]))
}

/// 16 vertices of a cluster, from number `first` on.
#[inline(always)]
fn positions<S: Simd>(simd: S, axes: &[&[f32]; 3], first: usize) -> [f32x16<S>; 3] {
    each3!(K => load(simd, &axes[K][first..]))
}

/// To whole sub-pixels, ties to even.
#[inline(always)]
fn snap<S: Simd>(v: f32x16<S>) -> i32x16<S> {
    part(
        v.simd,
        #[inline(always)]
        || v.round_ties_even().to_int(),
    )
}

/// The projected vertices of one cluster.
#[derive(Debug)]
pub struct ClusterVertices {
    /// Screen coordinates.
    pub x: [i32; MAX_VERTICES],
    /// Screen coordinates.
    pub y: [i32; MAX_VERTICES],
    /// Depths, as the bits of an `f32`.
    pub d: [i32; MAX_VERTICES],
    /// Bit v tells that vertex v lies before the near plane or outside the guard band.
    pub beyond: u64,
}

impl Default for ClusterVertices {
    fn default() -> Self {
        let zero = [0; MAX_VERTICES];
        Self { x: zero, y: zero, d: zero, beyond: 0 }
    }
}

impl ClusterVertices {
    /// Projects all vertices of a cluster.
    #[inline(always)]
    pub fn project<S: Simd>(&mut self, simd: S, object: &ObjectView, cluster: &ClusterView) {
        self.beyond = 0;
        let axes = cluster.positions();
        let mut first = 0;
        while first < axes[0].len() {
            let v = project(simd, object, positions(simd, &axes, first));
            let to = first..first + LANES;
            v.x.store_slice(&mut self.x[to.clone()]);
            v.y.store_slice(&mut self.y[to.clone()]);
            v.d.bitcast::<i32x16<S>>().store_slice(&mut self.d[to]);
            self.beyond |= (!v.inside.to_bitmask() & 0xffff) << first;
            first += LANES;
        }
    }

    /// Depths of the corners of 16 triangles.
    #[inline(always)]
    pub fn depths<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [f32x16<S>; 3] {
        each3!(K => lookup(simd, &self.d, &corners[K]).bitcast())
    }

    /// Screen coordinates of the corners of 16 triangles: x, y.
    #[inline(always)]
    pub fn coordinates<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [[i32x16<S>; 3]; 2] {
        [each3!(K => lookup(simd, &self.x, &corners[K])), each3!(K => lookup(simd, &self.y, &corners[K]))]
    }

    /// One vertex.
    #[inline(always)]
    pub fn vertex(&self, corner: u8) -> ScreenVertex {
        let v = usize::from(corner) % MAX_VERTICES;
        ScreenVertex {
            x: self.x[v],
            y: self.y[v],
            d: f32::from_bits(self.d[v] as u32),
            inside: self.beyond >> v & 1 == 0,
        }
    }
}

/// The projected vertices of a small cluster that lies inside the near plane and the guard band, as seen from
/// a pixel beside it, so that both coordinates fit into one register.
#[derive(Debug)]
pub struct LocalVertices {
    /// Sub-pixels to the right of [`LocalVertices::pixel`]'s corner in the lower half, below it in the upper.
    xy: [i32; MAX_VERTICES],
    /// Depths, as the bits of an `f32`.
    d: [i32; MAX_VERTICES],
    /// Column and row of the pixel.
    pub pixel: [i32; 2],
    /// The cluster reaches over [`SMALL_EXTENT`] sub-pixels or more, so that triangles of it may, too.
    pub is_wide: bool,
}

impl Default for LocalVertices {
    fn default() -> Self {
        Self { xy: [0; MAX_VERTICES], d: [0; MAX_VERTICES], pixel: [0; 2], is_wide: false }
    }
}

impl LocalVertices {
    /// Projects all vertices of a cluster of less than [`SMALL_CLUSTER`](crate::conventions::SMALL_CLUSTER)
    /// sub-pixels.
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
            out_of_range |= self.keep(simd, first, &v);
            first += LANES;
        }
        self.is_wide = false;
        if out_of_range & 0xffff != 0 {
            self.project_wide(simd, object, &axes);
        }
    }

    /// Stores 16 vertices; tells which lie [`SMALL_EXTENT`] or more from the pixel, or left of it or above.
    #[inline(always)]
    fn keep<S: Simd>(&mut self, simd: S, first: usize, v: &Projected<S>) -> u32 {
        let [x, y] = self.pixel.map(|p| p << SUBPIXEL_BITS);
        let to = first..first + LANES;
        v.d.bitcast::<i32x16<S>>().store_slice(&mut self.d[to.clone()]);
        part(
            simd,
            #[inline(always)]
            || {
                let (x, y) = (v.x - x, v.y - y);
                ((x & 0xffff) | (y << 16)).store_slice(&mut self.xy[to]);
                let near = ((x | y) & !(SMALL_EXTENT - 1)).simd_eq(splat_i(simd, 0));
                !near.to_bitmask() as u32
            },
        )
    }

    /// The same for a cluster that may be wide, or whose first vertex does not lie about its middle.
    #[cold]
    #[inline(never)]
    fn project_wide<S: Simd>(&mut self, simd: S, object: &ObjectView, axes: &[&[f32]; 3]) {
        simd.vectorize(
            #[inline(always)]
            || {
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
                    self.keep(simd, first, &v);
                }
            },
        );
    }

    /// One vertex in the coordinates of the screen.
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

    /// Depths of 16 vertices, from number `first` on, a multiple of 16.
    #[inline(always)]
    pub fn depths_of_16<S: Simd>(&self, simd: S, first: usize) -> f32x16<S> {
        i32x16::from_slice(simd, &self.d[first..first + LANES]).bitcast()
    }

    /// Coordinates of the corners of 16 triangles as seen from [`LocalVertices::pixel`]: x, y.
    #[inline(always)]
    pub fn coordinates<S: Simd>(&self, simd: S, corners: &CornerNumbers) -> [[i32x16<S>; 3]; 2] {
        let xy: [u32x16<S>; 3] = each3!(K => lookup(simd, &self.xy, &corners[K]).bitcast());
        part(
            simd,
            #[inline(always)]
            || [each3!(K => (xy[K] & 0xffff).bitcast()), each3!(K => (xy[K] >> 16).bitcast())],
        )
    }

    /// Coordinates of all vertices as seen from [`LocalVertices::pixel`], x and y alternately, 16 vertices each.
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

    /// The sample of a pixel of the picture, in sub-pixels, as seen from [`LocalVertices::pixel`].
    #[inline(always)]
    pub fn sample_of(&self, pixel: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|k| (pixel[k] - self.pixel[k]) * SUBPIXELS + SAMPLE)
    }

    /// What is added to coordinates as seen from [`LocalVertices::pixel`] to count them from the middle of the picture.
    #[inline(always)]
    pub fn from_middle(&self, sight: &Sight) -> [i32; 2] {
        [0, 1].map(|k| (self.pixel[k] << SUBPIXEL_BITS) - sight.middle[k])
    }

    /// A rectangle of pixels as seen from [`LocalVertices::pixel`].
    #[inline(always)]
    pub fn see(&self, rect: PixelRect) -> PixelRect {
        let [x, y] = self.pixel;
        PixelRect { x0: rect.x0 - x, x1: rect.x1 - x, y0: rect.y0 - y, y1: rect.y1 - y }
    }
}

/// 16 triangles of a cluster: the numbers of their corners, first, second and third.
pub type CornerNumbers = [[u8; LANES]; 3];

/// The corners of 16 triangles of a cluster, from number `first` on.
#[inline(always)]
pub fn corner_numbers(cluster: &ClusterView, first: usize) -> CornerNumbers {
    let corners = cluster.corners();
    each3!(K => *corners[K][first..].first_chunk().unwrap_or(&[0; LANES]))
}

/// The corners of all triangles of a cluster: first, second and third.
#[derive(Debug)]
pub struct CornerTable([[u8; MAX_TRIANGLES]; 3]);

impl Default for CornerTable {
    fn default() -> Self {
        Self([[0; MAX_TRIANGLES]; 3])
    }
}

impl CornerTable {
    /// Copies the corners of a cluster.
    #[inline(always)]
    pub fn load(&mut self, cluster: &ClusterView) {
        let tables = cluster.corner_tables();
        self.0 = each3!(K => *tables[K]);
    }

    /// Of 64 triangles that stand one after another, `first` a multiple of 64.
    #[inline(always)]
    pub fn of_64<S: Simd>(&self, simd: S, first: usize) -> [u8x64<S>; 3] {
        each3!(K => u8x64::from_slice(simd, &self.0[K][first % MAX_TRIANGLES..][..MANY]))
    }

    /// Of one triangle.
    pub fn of(&self, triangle: u8) -> [u8; 3] {
        self.0.map(|corner| corner[usize::from(triangle) % MAX_TRIANGLES])
    }

    /// Of any 16 triangles.
    #[inline(always)]
    pub fn look_up<S: Simd>(&self, simd: S, triangles: &[u8; LANES]) -> CornerNumbers {
        each3!(K => lookup_bytes(simd, &self.0[K], triangles))
    }
}

/// 16 triangles on the screen, their corners in the order of the mesh.
#[derive(Clone, Copy)]
pub struct ScreenTriangles<S: Simd> {
    /// Screen coordinates of the corners.
    pub x: [i32x16<S>; 3],
    /// Screen coordinates of the corners.
    pub y: [i32x16<S>; 3],
    /// First and last column of pixels whose samples the bounding box holds.
    pub columns: [i32x16<S>; 2],
    /// First and last row.
    pub rows: [i32x16<S>; 2],
}

impl<S: Simd> ScreenTriangles<S> {
    /// From the coordinates of the corners; samples outside `rect` do not count.
    #[inline(always)]
    pub fn new(simd: S, [x, y]: [[i32x16<S>; 3]; 2], rect: PixelRect) -> Self {
        part(
            simd,
            #[inline(always)]
            || Self {
                x,
                y,
                columns: samples(simd, x, [rect.x0, rect.x1]),
                rows: samples(simd, y, [rect.y0, rect.y1]),
            },
        )
    }

    /// Lanes whose bounding box holds a sample.
    #[inline(always)]
    pub fn hits(&self) -> u32 {
        let hits = self.columns[0].simd_le(self.columns[1]) & self.rows[0].simd_le(self.rows[1]);
        hits.to_bitmask() as u32
    }

    /// Lanes of triangles that reach over [`SMALL_EXTENT`] sub-pixels or more, across or down.
    #[inline(always)]
    pub fn large(&self, simd: S) -> u32 {
        part(
            simd,
            #[inline(always)]
            || {
                let limit = splat_i(simd, SMALL_EXTENT);
                let large = extent(self.x).simd_ge(limit) | extent(self.y).simd_ge(limit);
                large.to_bitmask() as u32
            },
        )
    }

    /// Twice the signed area, in square sub-pixels; of use where the triangle is small enough for 32 bits.
    #[inline(always)]
    pub fn area(&self) -> i32x16<S> {
        let (x, y) = (&self.x, &self.y);
        (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    }
}

/// Greatest difference of three coordinates.
#[inline(always)]
fn extent<S: Simd>(v: [i32x16<S>; 3]) -> i32x16<S> {
    v[0].max(v[1]).max(v[2]) - v[0].min(v[1]).min(v[2])
}

/// First and last sample between the least and the greatest of three coordinates, and inside `range`.
#[inline(always)]
fn samples<S: Simd>(simd: S, v: [i32x16<S>; 3], range: [i32; 2]) -> [i32x16<S>; 2] {
    let (least, most) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
    [
        ((least + (SAMPLE - 1)) >> SUBPIXEL_BITS).max(splat_i(simd, range[0])),
        ((most - SAMPLE) >> SUBPIXEL_BITS).min(splat_i(simd, range[1])),
    ]
}

/// The corners of 16 triangles, the farthest first as [`ScreenTriangle::new`] has it: depth is reckoned from
/// there.
#[derive(Clone, Copy)]
pub struct Anchored<S: Simd> {
    /// Screen coordinates.
    pub x: [i32x16<S>; 3],
    /// Screen coordinates.
    pub y: [i32x16<S>; 3],
    /// Depths.
    pub d: [f32x16<S>; 3],
}

impl<S: Simd> Anchored<S> {
    /// Turns the farthest corner, the first among equals, to the front.
    #[inline(always)]
    pub fn new(simd: S, d: [f32x16<S>; 3], t: &ScreenTriangles<S>) -> Self {
        part(
            simd,
            #[inline(always)]
            || {
                let second = d[1].simd_lt(d[0]) & d[1].simd_le(d[2]);
                let third = d[2].simd_lt(d[0]) & d[2].simd_lt(d[1]);
                Self {
                    x: each3!(K => third.select(t.x[(K + 2) % 3], second.select(t.x[(K + 1) % 3], t.x[K]))),
                    y: each3!(K => third.select(t.y[(K + 2) % 3], second.select(t.y[(K + 1) % 3], t.y[K]))),
                    d: each3!(K => third.select(d[(K + 2) % 3], second.select(d[(K + 1) % 3], d[K]))),
                }
            },
        )
    }
}
