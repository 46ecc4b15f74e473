//! A whole cluster into a tile.
//!
//! What a sample shows in the end does not depend on the order in which a cluster's triangles are drawn; how often a
//! cluster wins one does, and every win is shaded. The order is the renderer's: small triangles before large ones, 16
//! of a size at a time, one sample of each after another.

use tercio_mesh::ClusteredMesh;
use tercio_raster::LastStage;
use tercio_raster::simd::LANES;

use super::Counters;
use super::front_end::{Frame, WholeCluster};
use super::tile::{STAMP, Tile};
use super::triangle::Triangle;
use crate::workloads::PixelBox;

/// How a triangle is drawn, by the samples of its box.
#[derive(Clone, Copy)]
enum Way {
    /// 16 at a time, one sample of each after another.
    SideBySide,
    /// In stamps of rows of so many samples.
    Stamps(i32),
    /// By itself.
    Alone,
}

/// In the order in which they are drawn: the most samples across and down, and the way. What fits nowhere else, or
/// reaches too far for 32 bits, comes last.
const SIZES: [(i32, i32, Way); 5] = [
    (2, 2, Way::SideBySide),
    (4, 4, Way::SideBySide),
    (8, i32::MAX, Way::Stamps(8)),
    (STAMP, i32::MAX, Way::Stamps(STAMP)),
    (i32::MAX, i32::MAX, Way::Alone),
];
/// So many samples wait for their depth test, at most, when the next 16 triangles are begun.
const MOST_WAITING: usize = 256;

/// A covered sample that waits for its depth test.
struct Covered {
    x: i32,
    y: i32,
    depth: f32,
    primitive: u64,
}

/// A cluster on its way into a tile.
struct Pass<'a> {
    tile: &'a mut Tile,
    waiting: Vec<Covered>,
    won: Vec<(i32, i32)>,
}

/// Draws a cluster; what it wins is shaded at once if `shade` says so.
pub fn draw(frame: &Frame, whole: &WholeCluster, tile: &mut Tile, shade: bool, counters: &mut Counters) {
    let mesh = &*frame.scene.instances[whole.instance].mesh;
    let cluster = mesh.cluster(whole.cluster);
    let vertices = frame.project(whole.instance, whole.cluster);
    counters.vertices += cluster.vertices() as u64;
    counters.triangles_in += cluster.triangles() as u64;
    counters.bytes_read += bytes(mesh, whole.cluster);
    let mut by_size: [Vec<(Triangle, PixelBox)>; SIZES.len()] = Default::default();
    for t in 0..cluster.triangles() {
        let corners = cluster.corners_of(t).map(|v| vertices[usize::from(v)]);
        let primitive = frame.first_primitive[whole.instance] + u64::from(cluster.primitive(t));
        // One without area is set up with the others, but where a side is culled: it shows none.
        let triangle = Triangle::of_any_area(corners, primitive);
        let Some(pixels) = triangle.samples().and_then(|s| s.intersection(&tile.pixels)) else { continue };
        if !frame.culls(whole.instance, &triangle) {
            let (across, down) = (pixels.x1 - pixels.x0 + 1, pixels.y1 - pixels.y0 + 1);
            let fits = |&(most_across, most_down, way): &(i32, i32, Way)| match way {
                Way::Alone => true,
                _ => !triangle.is_wide() && across <= most_across && down <= most_down,
            };
            let size = SIZES.iter().position(fits).unwrap_or(SIZES.len() - 1);
            by_size[size].push((triangle, pixels));
        }
    }
    counters.triangles_drawn += by_size.iter().map(|list| list.len() as u64).sum::<u64>();
    if frame.settings.last_stage == LastStage::Sieve {
        return;
    }
    let mut pass = Pass { tile, waiting: Vec::new(), won: Vec::new() };
    for ((_, _, way), list) in SIZES.into_iter().zip(&by_size) {
        if let Way::Alone = way {
            let drawn = list.iter().filter(|(t, _)| t.has_area);
            drawn.for_each(|(t, _)| pass.tile.triangle(t, counters, |pixel| pass.won.push(pixel)));
            continue;
        }
        for sixteen in list.chunks(LANES) {
            counters.set_ups += 1;
            match way {
                Way::Stamps(width) => sixteen.iter().for_each(|t| pass.stamps(t, width, counters)),
                _ => counters.steps += pass.scan(sixteen),
            }
            if pass.waiting.len() > MOST_WAITING {
                pass.test(counters);
            }
        }
    }
    pass.test(counters);
    let Pass { won, tile, .. } = pass;
    if shade && frame.settings.last_stage > LastStage::Visibility {
        counters.pixels_shaded += won.len() as u64;
        let shadings = won.len().div_ceil(LANES) as u64;
        counters.shadings += shadings;
        let keeps_sides = frame.objects[whole.instance].similarity.is_some();
        if shadings > 0 && !(cluster.head().normals_agree() && keeps_sides) {
            counters.shadings_by_plane += shadings;
        }
        counters.clusters_won += u64::from(!won.is_empty());
        if frame.is_instance_colored(whole.instance) && !won.is_empty() {
            counters.vertices_colored += cluster.vertices() as u64;
        }
        won.into_iter().for_each(|(x, y)| tile.shade(x, y));
    }
}

impl Pass<'_> {
    /// Finds the samples of 16 triangles side by side; tells the steps that it takes.
    fn scan(&mut self, sixteen: &[(Triangle, PixelBox)]) -> u64 {
        let mut steps = 0;
        let most = |size: fn(&PixelBox) -> i32| sixteen.iter().map(|(_, p)| size(p)).max().unwrap_or(0);
        for row in 0..most(|p| p.y1 - p.y0 + 1) {
            let in_row = |p: &PixelBox| p.y0 + row <= p.y1;
            let columns = sixteen.iter().filter(|(_, p)| in_row(p)).map(|(_, p)| p.x1 - p.x0 + 1).max();
            for column in 0..columns.unwrap_or(0) {
                steps += 1;
                for (t, p) in sixteen.iter().filter(|(_, p)| in_row(p) && p.x0 + column <= p.x1) {
                    let (x, y) = (p.x0 + column, p.y0 + row);
                    if t.covers(x, y) {
                        let (depth, primitive) = (t.depth(x, y), t.primitive);
                        self.waiting.push(Covered { x, y, depth, primitive });
                    }
                }
            }
        }
        steps
    }

    /// Draws one triangle in stamps of rows of some width.
    fn stamps(&mut self, (t, p): &(Triangle, PixelBox), width: i32, counters: &mut Counters) {
        let rows_a_stamp = STAMP / width;
        counters.stamps += ((p.y1 - p.y0) / rows_a_stamp + 1) as u64;
        let won = &mut self.won;
        self.tile.cover(t, p, counters, |pixel| won.push(pixel));
    }

    /// Tests the samples that wait.
    fn test(&mut self, counters: &mut Counters) {
        counters.samples_covered += self.waiting.len() as u64;
        for c in self.waiting.drain(..) {
            if self.tile.test(c.x, c.y, c.depth, c.primitive) {
                self.won.push((c.x, c.y));
            }
        }
    }
}

/// Bytes of the cache lines that drawing a cluster touches.
pub fn bytes(mesh: &ClusteredMesh, number: usize) -> u64 {
    let cluster = mesh.cluster(number);
    let colors = cluster.vertex_colors().map_or(0, size_of_val);
    (size_of_val(cluster.hot_lines()) + colors) as u64
}
