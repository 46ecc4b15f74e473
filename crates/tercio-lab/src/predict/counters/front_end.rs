//! Clusters into the tiles: whole where they are small on the screen, else triangle by triangle.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use tercio_mesh::ClusteredMesh;
use tercio_raster::frontend::clip::clip_triangle;
use tercio_raster::frontend::cull::{ClusterLanes, ClusterTests, Placement, place};
use tercio_raster::simd::LANES;
use tercio_raster::view::{ObjectView, ScreenVertex, View};
use tercio_raster::{Binning, Cull, LastStage, Settings, Sorting};
use tercio_scene::{Camera, Instance, Scene};

use super::Counters;
use super::triangle::Triangle;
use super::{PredictError, whole};
use crate::workloads::PixelBox;

/// Clusters in more tiles than this are taken apart.
const MOST_TILES: usize = 16;
/// Clusters of a part of the work.
const SHARE: usize = 64 * LANES;

/// What is seen from where, and how it is drawn.
pub struct Frame<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
    pub view: View,
    pub objects: Vec<ObjectView>,
    /// Number of each instance's first primitive.
    pub first_primitive: Vec<u64>,
    /// Pixels along the edge of a tile.
    pub tile: i32,
    /// Tiles across and down.
    pub tiles: [usize; 2],
}

/// A cluster that goes into the tiles as a whole.
#[derive(Clone, Copy, Debug)]
pub struct WholeCluster {
    pub instance: usize,
    /// Its number in the mesh.
    pub cluster: usize,
    /// No sample of it is nearer.
    pub nearest: f32,
    /// Pixels that it may reach.
    pub pixels: PixelBox,
}

/// The tiles' entries, in the order of the clusters.
#[derive(Debug, Default)]
pub struct Bins {
    pub clusters: Vec<WholeCluster>,
    pub triangles: Vec<Triangle>,
    /// Numbers in `clusters`, by tile.
    pub clusters_of: Vec<Vec<u32>>,
    /// Numbers in `triangles`, by tile.
    pub triangles_of: Vec<Vec<u32>>,
    /// Whether a tile has drawn each of `clusters`.
    pub drawn: Vec<AtomicBool>,
}

impl Bins {
    /// Tiles of the picture.
    pub fn tiles(&self) -> usize {
        self.clusters_of.len()
    }

    /// Bytes of the clusters that some tile has drawn.
    pub fn bytes_drawn(&self, frame: &Frame) -> u64 {
        let drawn = self.clusters.iter().zip(&self.drawn).filter(|(_, drawn)| drawn.load(Ordering::Relaxed));
        drawn.map(|(c, _)| whole::bytes(&frame.scene.instances[c.instance].mesh, c.cluster)).sum()
    }

    /// Entries of a tile.
    pub fn fill(&self, tile: usize) -> usize {
        self.clusters_of[tile].len() + self.triangles_of[tile].len()
    }
}

/// What some clusters became.
#[derive(Default)]
struct Part {
    counters: Counters,
    clusters: Vec<WholeCluster>,
    triangles: Vec<Triangle>,
    /// Tile and number in `triangles`.
    entries: Vec<(usize, u32)>,
}

/// Sorts all clusters of a frame into its tiles.
pub fn sort(frame: &Frame, counters: &mut Counters) -> Bins {
    let all: usize = frame.scene.instances.iter().map(|i| i.mesh.clusters().len()).sum();
    let drawn = frame.settings.clusters.range(all as u32);
    let (mut shares, mut before) = (Vec::new(), 0);
    for (instance, i) in frame.scene.instances.iter().enumerate() {
        let clusters = i.mesh.clusters().len();
        let own = |number: u32| (number as usize).saturating_sub(before).min(clusters);
        let (begin, end) = (own(drawn.start), own(drawn.end));
        shares.extend((begin..end).step_by(SHARE).map(|from| (instance, from, (from + SHARE).min(end))));
        before += clusters;
    }
    let parts: Vec<Part> =
        shares.into_par_iter().map(|(instance, from, to)| Part::of(frame, instance, from, to)).collect();
    let tiles = frame.tiles[0] * frame.tiles[1];
    let mut bins = Bins {
        clusters_of: vec![Vec::new(); tiles],
        triangles_of: vec![Vec::new(); tiles],
        ..Bins::default()
    };
    for part in parts {
        counters.add(&part.counters);
        let first = bins.triangles.len() as u32;
        for (tile, number) in part.entries {
            bins.triangles_of[tile].push(first + number);
        }
        for cluster in part.clusters {
            let number = bins.clusters.len() as u32;
            let tiles = frame.tiles_of(&cluster.pixels).filter(|(tile, _)| frame.draws(*tile));
            tiles.for_each(|(tile, _)| bins.clusters_of[tile].push(number));
            bins.clusters.push(cluster);
        }
        bins.triangles.extend(part.triangles);
    }
    counters.clusters_whole = bins.clusters.len() as u64;
    counters.triangles_binned = bins.triangles.len() as u64;
    let sum = |lists: &[Vec<u32>]| lists.iter().map(|l| l.len() as u64).sum();
    counters.cluster_entries = sum(&bins.clusters_of);
    counters.entries = sum(&bins.triangles_of);
    bins.drawn.resize_with(bins.clusters.len(), AtomicBool::default);
    counters.largest_tile = (0..tiles).map(|t| bins.fill(t)).max().unwrap_or(0) as u64;
    bins
}

impl<'a> Frame<'a> {
    /// A scene under a camera.
    ///
    /// # Errors
    /// A camera that makes no view.
    pub fn new(scene: &'a Scene, camera: &Camera, settings: &'a Settings) -> Result<Self, PredictError> {
        let view = View::new(camera, &scene.bounds(), settings.width, settings.height)?;
        let tile = settings.tile_edge();
        let mut primitives = 0;
        let mut first_primitive = Vec::new();
        for instance in &scene.instances {
            first_primitive.push(primitives);
            primitives += instance.mesh.triangle_count() as u64;
        }
        Ok(Self {
            scene,
            settings,
            objects: scene.instances.iter().map(|i| view.object(i)).collect(),
            view,
            first_primitive,
            tile: tile as i32,
            tiles: [settings.width, settings.height].map(|n| n.div_ceil(tile) as usize),
        })
    }

    /// Tiles that a box of pixels touches, and its part in each.
    fn tiles_of(&self, pixels: &PixelBox) -> impl Iterator<Item = (usize, PixelBox)> {
        let (edge, columns, pixels) = (self.tile, self.tiles[0], *pixels);
        (pixels.y0 / edge..=pixels.y1 / edge).flat_map(move |row| {
            (pixels.x0 / edge..=pixels.x1 / edge).map(move |column| {
                let [x, y] = [column * edge, row * edge];
                let part = PixelBox {
                    x0: pixels.x0.max(x),
                    y0: pixels.y0.max(y),
                    x1: pixels.x1.min(x + edge - 1),
                    y1: pixels.y1.min(y + edge - 1),
                };
                (row as usize * columns + column as usize, part)
            })
        })
    }

    /// Is this tile in the part of the picture that is drawn?
    pub fn draws(&self, tile: usize) -> bool {
        self.settings.tiles.contains(tile as u32)
    }

    /// Is one of the tiles that a box of pixels touches?
    fn draws_some_of(&self, pixels: &PixelBox) -> bool {
        self.tiles_of(pixels).any(|(tile, _)| self.draws(tile))
    }

    /// Does the colour of a primitive stand at its vertices or at itself?
    pub fn is_colored(&self, primitive: u64) -> bool {
        let instance = self.first_primitive.partition_point(|&first| first <= primitive).max(1) - 1;
        self.is_instance_colored(instance)
    }

    /// Do the colours of an instance stand at vertices or triangles?
    pub fn is_instance_colored(&self, instance: usize) -> bool {
        let Instance { mesh, surface, .. } = &self.scene.instances[instance];
        let layout = mesh.layout();
        let colors = layout.vertex_colors || layout.face_colors;
        surface.use_mesh_colors && (colors || layout.triangle_materials && !mesh.materials.is_empty())
    }

    /// Is this triangle left out by its facing?
    pub fn culls(&self, instance: usize, triangle: &Triangle) -> bool {
        let mirrored = self.objects[instance].mirrored;
        match self.settings.cull {
            Cull::Auto | Cull::None => false,
            Cull::Back => !triangle.has_area || triangle.clockwise != mirrored,
            Cull::Front => !triangle.has_area || triangle.clockwise == mirrored,
        }
    }

    /// The vertices of a cluster on the screen.
    pub fn project(&self, instance: usize, cluster: usize) -> Vec<ScreenVertex> {
        let (mesh, object) = (&*self.scene.instances[instance].mesh, &self.objects[instance]);
        let cluster = mesh.cluster(cluster);
        (0..cluster.vertices()).map(|v| object.project(cluster.position(v))).collect()
    }
}

impl Part {
    fn of(frame: &Frame, instance: usize, from: usize, to: usize) -> Self {
        let mut part = Self::default();
        let clusters = &frame.scene.instances[instance].mesh.clusters();
        let mut lanes = ClusterLanes::default();
        for first in (from..to).step_by(LANES) {
            let sixteen = first..(first + LANES).min(to);
            let mut tests = ClusterTests::default();
            if frame.settings.cluster_culling {
                // A cluster shows only its back, or only its front, whatever a mirror makes of it.
                let back = match frame.settings.cull {
                    Cull::Auto | Cull::None => None,
                    Cull::Back => Some(true),
                    Cull::Front => Some(false),
                };
                lanes.load(&clusters[sixteen.clone()]);
                let scalar = fearless_simd::Fallback::new();
                tests = ClusterTests::new(scalar, &frame.view, &frame.objects[instance], &lanes, back);
            }
            for (lane, cluster) in sixteen.enumerate() {
                part.sort(frame, instance, cluster, &tests, lane);
            }
        }
        part
    }

    fn sort(&mut self, frame: &Frame, instance: usize, number: usize, tests: &ClusterTests, lane: usize) {
        let mesh = &*frame.scene.instances[instance].mesh;
        let cluster = &mesh.clusters()[number];
        let is = |mask: u32| mask >> lane & 1 == 1;
        let c = &mut self.counters;
        c.clusters += 1;
        c.triangles += u64::from(cluster.triangles);
        let outside = is(tests.outside)
            || frame.settings.cluster_culling
                && !is(tests.inside)
                && place(&frame.view, &frame.objects[instance], cluster) == Placement::Outside;
        if outside {
            c.clusters_outside += 1;
            return;
        }
        if is(tests.one_side) {
            c.clusters_facing += 1;
            return;
        }
        if is(tests.no_sample) {
            c.clusters_no_sample += 1;
            return;
        }
        let [x0, x1, y0, y1] = [0, 1, 2, 3].map(|k| tests.rect[k][lane]);
        let pixels = PixelBox { x0, y0, x1, y1 };
        if is(tests.inside) && !frame.draws_some_of(&pixels) {
            return;
        }
        if frame.settings.last_stage == LastStage::Cull {
            return;
        }
        let small = is(tests.small) && frame.settings.sorting == Sorting::Clusters;
        if small && frame.tiles_of(&pixels).count() <= MOST_TILES {
            let nearest = tests.nearest[lane];
            self.clusters.push(WholeCluster { instance, cluster: number, nearest, pixels });
            return;
        }
        c.vertices_apart += u64::from(cluster.vertices);
        c.triangles_apart += u64::from(cluster.triangles);
        self.take_apart(frame, instance, number);
    }

    /// Bins the triangles of a cluster. The renderer looks at 16 at a time, and first at those that are clipped:
    /// where several threads share a tile, the order decides who draws what.
    fn take_apart(&mut self, frame: &Frame, instance: usize, number: usize) {
        let mesh: &ClusteredMesh = &frame.scene.instances[instance].mesh;
        let cluster = mesh.cluster(number);
        let vertices = frame.project(instance, number);
        let triangles: Vec<usize> = (0..cluster.triangles()).collect();
        for sixteen in triangles.chunks(LANES) {
            let numbers = |t: usize| cluster.corners_of(t).map(usize::from);
            let whole = |t: usize| numbers(t).iter().all(|&n| vertices[n].inside);
            for &t in sixteen.iter().filter(|&&t| !whole(t)) {
                let at = |n: usize| cluster.position(n);
                let corners = numbers(t).map(|n| vertices[n]);
                clip_triangle(&frame.objects[instance], numbers(t).map(at), corners, |piece| {
                    self.triangle(frame, instance, cluster.primitive(t), piece);
                });
            }
            for &t in sixteen.iter().filter(|&&t| whole(t)) {
                self.triangle(frame, instance, cluster.primitive(t), numbers(t).map(|n| vertices[n]));
            }
        }
    }

    /// `primitive` is the number in its mesh.
    fn triangle(&mut self, frame: &Frame, instance: usize, primitive: u32, corners: [ScreenVertex; 3]) {
        let primitive = frame.first_primitive[instance] + u64::from(primitive);
        let Some(triangle) = Triangle::new(corners, primitive) else { return };
        let screen = PixelBox::screen(frame.settings.width, frame.settings.height);
        let Some(pixels) = triangle.samples().and_then(|s| s.intersection(&screen)) else { return };
        if frame.culls(instance, &triangle) || !frame.draws_some_of(&pixels) {
            return;
        }
        let entry = self.triangles.len() as u32;
        self.triangles.push(triangle);
        // One tile needs no test.
        let tested = frame.settings.binning == Binning::Exact && frame.tiles_of(&pixels).count() > 1;
        let tiles = frame
            .tiles_of(&pixels)
            .filter(|(tile, part)| frame.draws(*tile) && (!tested || triangle.may_cover(part)));
        self.entries.extend(tiles.map(|(tile, _)| (tile, entry)));
    }
}
