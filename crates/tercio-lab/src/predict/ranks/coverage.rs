//! Which samples of the picture the triangles of some clusters cover, by the definition of coverage.

use tercio_raster::frontend::clip::clip_triangle;
use tercio_raster::view::{ObjectView, ScreenVertex, View};
use tercio_scene::Scene;

/// Calls `emit` for every sample of the picture that a triangle of some clusters covers, counted through the instances,
/// and returns how many triangles there are.
pub(super) fn each_sample(
    scene: &Scene,
    view: &View,
    clusters: std::ops::Range<usize>,
    mut emit: impl FnMut(u32, u32),
) -> u64 {
    let (mut triangles, mut first) = (0, 0);
    for instance in &scene.instances {
        let (object, mesh): (ObjectView, _) = (view.object(instance), &*instance.mesh);
        for (_, cluster) in (first..).zip(mesh.views()).filter(|(number, _)| clusters.contains(number)) {
            for t in 0..cluster.triangles() {
                triangles += 1;
                let positions = cluster.corner_positions(t);
                let projected = positions.map(|p| object.project(p));
                if projected.iter().all(|v| v.inside) {
                    fill(projected, view, &mut emit);
                } else {
                    clip_triangle(&object, positions, projected, |piece| fill(piece, view, &mut emit));
                }
            }
        }
        first += mesh.clusters().len();
    }
    triangles
}

/// The samples of one triangle: right of all edges that run clockwise round it, on an edge only if that runs upwards or
/// level to the right.
fn fill(corners: [ScreenVertex; 3], view: &View, emit: &mut impl FnMut(u32, u32)) {
    use tercio_raster::conventions::{SAMPLE, SUBPIXELS};
    let mut p = corners.map(|v| [i64::from(v.x), i64::from(v.y)]);
    let side =
        |a: [i64; 2], b: [i64; 2], s: [i64; 2]| (b[0] - a[0]) * (s[1] - a[1]) - (b[1] - a[1]) * (s[0] - a[0]);
    let area = side(p[0], p[1], p[2]);
    if area == 0 {
        return;
    }
    if area < 0 {
        p.swap(1, 2);
    }
    // Pixels, a few more than needed, whose samples may lie between the least and the greatest coordinate.
    let pixels = |k: usize, size: u32| {
        let (a, b, c) = (p[0][k], p[1][k], p[2][k]);
        let pixel = |coordinate: i64| coordinate.div_euclid(i64::from(SUBPIXELS));
        pixel(a.min(b).min(c)).max(0)..=pixel(a.max(b).max(c)).min(i64::from(size) - 1)
    };
    for y in pixels(1, view.height) {
        for x in pixels(0, view.width) {
            let sample = [x, y].map(|c| c * i64::from(SUBPIXELS) + i64::from(SAMPLE));
            let covered = (0..3).all(|k| {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                let owns_edge = b[1] < a[1] || b[1] == a[1] && b[0] > a[0];
                side(a, b, sample) >= i64::from(!owns_edge)
            });
            if covered {
                emit(x as u32, y as u32);
            }
        }
    }
}
