//! What a frame amounts to, counted without the renderer.
//!
//! Only the projection to the screen and clipping are shared with it; coverage, tiles and entries are counted here by
//! their definition, so that equal numbers mean something.

use rayon::prelude::*;
use serde::Serialize;
use tercio_mesh::ClusteredMesh;
use tercio_raster::frontend::clip::clip_triangle;
use tercio_raster::view::{ObjectView, ScreenVertex, View};
use tercio_scene::{Camera, Scene};

use super::PredictError;
use crate::workloads::{BoundingBox, BoxScene, PixelBox};

/// A picture to be predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Pixels along the edge of a tile.
    pub tile: u32,
    /// Triangles go only into tiles of which they may cover a sample, not into all that their box touches.
    pub exact_binning: bool,
}

/// Counts of a frame. Those that the renderer counts, too, have the same meaning there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counters {
    /// Triangles of the model.
    pub triangles: u64,
    /// Triangles, or pieces that clipping leaves of them, with a sample of the picture in their box.
    pub drawn: u64,
    /// Entries of triangles in tiles.
    pub entries: u64,
    /// Tiles of the picture.
    pub tiles: u64,
    /// Tiles with an entry.
    pub tiles_used: u64,
    /// Entries of the fullest tile.
    pub largest_tile: u64,
    /// Blocks of 4x4 samples that boxes of triangles touch.
    pub box_blocks: u64,
    /// Samples covered, hidden or not.
    pub samples_covered: u64,
    /// Pixels that show a triangle.
    pub pixels_shaded: u64,
    /// Pixels of the picture.
    pub pixels: u64,
}

impl Counters {
    /// Those that the renderer counts, too, by name.
    pub fn comparable(&self) -> [(&'static str, u64); 7] {
        [
            ("triangles", self.triangles),
            ("triangles drawn", self.drawn),
            ("entries", self.entries),
            ("tiles used", self.tiles_used),
            ("largest tile", self.largest_tile),
            ("samples covered", self.samples_covered),
            ("pixels shown", self.pixels_shaded),
        ]
    }
}

/// Some triangles' share of the counts.
struct Part {
    counters: Counters,
    fill: Vec<u32>,
    shown: Vec<bool>,
    boxes: Vec<BoundingBox>,
}

/// Counts of a frame, and the boxes of its triangles in samples, in the order of the clusters.
///
/// # Errors
/// A camera that makes no view.
pub fn count(scene: &Scene, camera: &Camera, picture: Picture) -> Result<(Counters, BoxScene), PredictError> {
    let view = View::new(camera, &scene.bounds(), picture.width, picture.height)?;
    let columns = picture.width.div_ceil(picture.tile);
    let tiles = columns as usize * picture.height.div_ceil(picture.tile) as usize;
    let pixels = picture.width as usize * picture.height as usize;
    let mut sum = Part::empty(tiles, pixels);
    for instance in &scene.instances {
        let (object, mesh) = (view.object(instance), &*instance.mesh);
        // Few parts, because each has a picture of its own.
        let share = mesh.clusters.len().div_ceil(rayon::current_num_threads().max(1)).max(1);
        let parts: Vec<Part> = (0..mesh.clusters.len().div_ceil(share))
            .into_par_iter()
            .map(|k| {
                let mut part = Part::empty(tiles, pixels);
                for cluster in k * share..((k + 1) * share).min(mesh.clusters.len()) {
                    part.cluster(mesh, cluster, &object, picture, columns);
                }
                part
            })
            .collect();
        parts.into_iter().for_each(|p| sum.add(p));
    }
    let fill = &sum.fill;
    let counters = Counters {
        tiles: tiles as u64,
        tiles_used: fill.iter().filter(|&&f| f > 0).count() as u64,
        largest_tile: u64::from(fill.iter().copied().max().unwrap_or(0)),
        pixels_shaded: sum.shown.iter().filter(|&&s| s).count() as u64,
        pixels: pixels as u64,
        ..sum.counters
    };
    Ok((counters, BoxScene { boxes: sum.boxes }))
}

impl Part {
    fn empty(tiles: usize, pixels: usize) -> Self {
        Self {
            counters: Counters::default(),
            fill: vec![0; tiles],
            shown: vec![false; pixels],
            boxes: Vec::new(),
        }
    }

    fn add(&mut self, o: Self) {
        let c = &mut self.counters;
        c.triangles += o.counters.triangles;
        c.drawn += o.counters.drawn;
        c.entries += o.counters.entries;
        c.box_blocks += o.counters.box_blocks;
        c.samples_covered += o.counters.samples_covered;
        self.fill.iter_mut().zip(o.fill).for_each(|(a, b)| *a += b);
        self.shown.iter_mut().zip(o.shown).for_each(|(a, b)| *a |= b);
        self.boxes.extend(o.boxes);
    }

    fn cluster(&mut self, mesh: &ClusteredMesh, number: usize, view: &ObjectView, p: Picture, columns: u32) {
        let cluster = &mesh.clusters[number];
        let first = cluster.first_vertex as usize;
        let vertices: Vec<ScreenVertex> = (first..first + usize::from(cluster.vertices))
            .map(|i| view.project([mesh.x[i], mesh.y[i], mesh.z[i]]))
            .collect();
        let first = cluster.first_triangle as usize;
        for t in first..first + usize::from(cluster.triangles) {
            self.counters.triangles += 1;
            let numbers = [0, 1, 2].map(|k| usize::from(mesh.corners[k][t]));
            let corners = numbers.map(|n| vertices[n]);
            if corners.iter().all(|c| c.inside) {
                self.triangle(corners, p, columns);
                continue;
            }
            let at = |n: usize| {
                let i = cluster.first_vertex as usize + n;
                [mesh.x[i], mesh.y[i], mesh.z[i]]
            };
            clip_triangle(view, numbers.map(at), corners, |piece| self.triangle(piece, p, columns));
        }
    }

    fn triangle(&mut self, corners: [ScreenVertex; 3], p: Picture, columns: u32) {
        let hidden = BoundingBox { visible: false, pixels: PixelBox { x0: 0, y0: 0, x1: 0, y1: 0 } };
        let triangle = Halfplanes::new(corners.map(|c| (i64::from(c.x), i64::from(c.y))));
        let screen = PixelBox::screen(p.width, p.height);
        let Some((triangle, pixels)) = triangle.and_then(|t| Some((t, t.samples()?.intersection(&screen)?)))
        else {
            self.boxes.push(hidden);
            return;
        };
        self.boxes.push(BoundingBox { visible: true, pixels });
        self.counters.drawn += 1;
        let blocks = |first: i32, last: i32| (last / 4 - first / 4 + 1) as u64;
        self.counters.box_blocks += blocks(pixels.x0, pixels.x1) * blocks(pixels.y0, pixels.y1);
        let edge = p.tile as i32;
        // A small triangle in one tile only goes there untested.
        let one_tile = pixels.x0 / edge == pixels.x1 / edge && pixels.y0 / edge == pixels.y1 / edge;
        let tested = p.exact_binning && !(one_tile && triangle.is_small());
        for row in pixels.y0 / edge..=pixels.y1 / edge {
            for column in pixels.x0 / edge..=pixels.x1 / edge {
                let corner = [column * edge, row * edge];
                let tile = PixelBox {
                    x0: pixels.x0.max(corner[0]),
                    y0: pixels.y0.max(corner[1]),
                    x1: pixels.x1.min(corner[0] + edge - 1),
                    y1: pixels.y1.min(corner[1] + edge - 1),
                };
                if !tested || triangle.may_cover(&tile) {
                    self.counters.entries += 1;
                    self.fill[row as usize * columns as usize + column as usize] += 1;
                }
            }
        }
        for y in pixels.y0..=pixels.y1 {
            for x in pixels.x0..=pixels.x1 {
                if triangle.covers(x, y) {
                    self.counters.samples_covered += 1;
                    self.shown[y as usize * p.width as usize + x as usize] = true;
                }
            }
        }
    }
}

/// A triangle as the points at which three linear functions are not negative; those on an edge count if it is a left
/// or upper one.
#[derive(Clone, Copy, Debug)]
struct Halfplanes {
    corners: [(i64, i64); 3],
    /// Growth to the right, growth downwards, and 1 where the edge itself is outside.
    edges: [(i64, i64, i64); 3],
}

/// Sub-pixels a pixel, and from a pixel's corner to its sample.
const PIXEL: i64 = tercio_raster::conventions::SUBPIXELS as i64;
const SAMPLE: i64 = tercio_raster::conventions::SAMPLE as i64;

impl Halfplanes {
    /// `None` without area.
    fn new(mut corners: [(i64, i64); 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let area = (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1);
        if area == 0 {
            return None;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        // Clockwise on the screen: the inside lies right of each edge, seen along it.
        let edge = |k: usize| {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            let (right, down) = (from.1 - to.1, to.0 - from.0);
            let left_or_top = right > 0 || right == 0 && down > 0;
            (right, down, i64::from(!left_or_top))
        };
        Some(Self { corners, edges: [edge(0), edge(1), edge(2)] })
    }

    /// Pixels whose samples lie in the bounding box.
    fn samples(&self) -> Option<PixelBox> {
        let range = |of: fn(&(i64, i64)) -> i64| {
            let values = self.corners.map(|c| of(&c));
            let (low, high) = (values.into_iter().min()?, values.into_iter().max()?);
            let first = (low - SAMPLE).div_euclid(PIXEL) + i64::from((low - SAMPLE).rem_euclid(PIXEL) > 0);
            Some((i32::try_from(first).ok()?, i32::try_from((high - SAMPLE).div_euclid(PIXEL)).ok()?))
        };
        let ((x0, x1), (y0, y1)) = (range(|c| c.0)?, range(|c| c.1)?);
        PixelBox::new([x0, y0], [x1, y1])
    }

    fn is_small(&self) -> bool {
        let extent = |of: fn(&(i64, i64)) -> i64| {
            let v = self.corners.map(|c| of(&c));
            v[0].max(v[1]).max(v[2]) - v[0].min(v[1]).min(v[2])
        };
        extent(|c| c.0).max(extent(|c| c.1)) < i64::from(tercio_raster::conventions::SMALL_EXTENT)
    }

    fn inside(&self, edge: usize, x: i32, y: i32) -> bool {
        let ((right, down, outside), from) = (self.edges[edge], self.corners[edge]);
        let (dx, dy) = (i64::from(x) * PIXEL + SAMPLE - from.0, i64::from(y) * PIXEL + SAMPLE - from.1);
        right * dx + down * dy >= outside
    }

    fn covers(&self, x: i32, y: i32) -> bool {
        (0..3).all(|k| self.inside(k, x, y))
    }

    /// False if one edge has every sample of a rectangle on its outer side.
    fn may_cover(&self, r: &PixelBox) -> bool {
        (0..3).all(|k| {
            let (right, down, _) = self.edges[k];
            self.inside(k, if right > 0 { r.x1 } else { r.x0 }, if down > 0 { r.y1 } else { r.y0 })
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use tercio_mesh::cluster::{PartitionOptions, partition};
    use tercio_raster::{Binning, Renderer, Settings, Sorting};

    use super::*;
    use crate::predict::{measure, views};

    #[test]
    fn counts_are_the_renderers() {
        for (model, size, tile, binning) in [
            ("builtin:teapot@20k", (320, 200), 32, Binning::Exact),
            ("builtin:soup@500", (257, 129), 16, Binning::Exact),
            ("builtin:soup@500", (257, 129), 64, Binning::BoundingBox),
            // From inside the model: triangles are clipped.
            ("builtin:sphere@3k", (320, 200), 64, Binning::Exact),
        ] {
            let mesh = tercio_mesh::builtin::make(model).unwrap();
            let bounds = mesh.bounds();
            let scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
            let mut camera = views::camera(&bounds, size, 1, 5);
            if model.contains("sphere") {
                camera.eye = bounds.center() + bounds.size() * 0.1;
            }
            let mut settings = Settings::new(size.0, size.1);
            (settings.tile_size, settings.binning) = (Some(tile), binning);
            settings.sorting = Sorting::Triangles;
            let stats = Renderer::new().render(&scene, &camera, &settings).unwrap().stats;
            let exact_binning = binning == Binning::Exact;
            let picture = Picture { width: size.0, height: size.1, tile, exact_binning };
            let (c, boxes) = count(&scene, &camera, picture).unwrap();
            assert_eq!(boxes.boxes.iter().filter(|b| b.visible).count() as u64, c.drawn);
            assert_eq!(c.comparable(), measure::counted(&stats), "{model}");
        }
    }
}
