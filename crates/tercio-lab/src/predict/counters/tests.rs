use std::sync::Arc;

use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_raster::{Binning, Cull, Renderer, Sorting};

use super::*;
use crate::predict::views;

/// Our counters and the renderer's.
fn compare(
    model: &str,
    size: (u32, u32),
    threads: usize,
    change: impl Fn(&mut Settings, &mut Camera),
) -> Counters {
    let mesh = tercio_mesh::builtin::make(model).unwrap();
    let bounds = mesh.bounds();
    let scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
    let mut camera = views::camera(&bounds, size, 1, 5);
    let mut settings = Settings::new(size.0, size.1);
    change(&mut settings, &mut camera);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let stats = pool.install(|| Renderer::new().render(&scene, &camera, &settings)).unwrap().stats;
    assert_eq!(settings.tile_edge(), stats.tile_size, "{model}");
    let ours = count(&scene, &camera, &settings, threads).unwrap().frame;
    assert_eq!(ours.comparable(), Counters::counted(&stats), "{model} {size:?} {settings:?}");
    let drawn = boxes::boxes(&scene, &camera, size).unwrap();
    assert!(drawn.visible() >= ours.triangles_binned);
    ours
}

#[test]
fn whole_clusters_are_counted_as_the_renderer_counts_them() {
    let c = compare("builtin:gyroid@60k", (320, 200), 1, |_, _| ());
    assert!(c.clusters_hidden > 0 && c.clusters_drawn > 0 && c.clusters_whole > 0, "{c:?}");
    assert!(c.pixels_shaded > c.pixels_visible, "nearer clusters win pixels that are shaded: {c:?}");
    // Pictures whose border cuts tiles and blocks, clusters of several tiles, triangles of every size.
    compare("builtin:teapot@20k", (333, 201), 1, |s, _| s.tile_size = Some(16));
    compare("builtin:teapot@2k", (257, 129), 1, |_, _| ());
    compare("builtin:soup@3k", (257, 129), 1, |_, _| ());
    compare("builtin:terrain@30k", (641, 479), 1, |_, _| ());
}

#[test]
fn every_stage_is_counted() {
    for stage in [LastStage::Cull, LastStage::Bin, LastStage::Sieve, LastStage::Visibility] {
        compare("builtin:gyroid@20k", (200, 200), 1, |s, _| s.last_stage = stage);
    }
}

#[test]
fn facing_sides_are_culled() {
    for cull in [Cull::Back, Cull::Front] {
        let c = compare("builtin:sphere@100k", (640, 640), 1, |s, _| s.cull = cull);
        assert!(c.clusters_facing > 0, "{cull:?} {c:?}");
    }
}

#[test]
fn clusters_are_taken_apart_where_they_are_large_or_clipped() {
    // From inside the model and beside it: some clusters are clipped, some outside.
    let inside = |_: &mut Settings, camera: &mut Camera| camera.eye = camera.target + glam::DVec3::splat(0.1);
    let c = compare("builtin:sphere@3k", (322, 202), 1, inside);
    assert!(c.triangles_binned > 0 && c.clusters_outside > 0, "{c:?}");
    // Both kinds in one tile.
    let c = compare("builtin:teapot@6k", (1001, 777), 1, |_, _| ());
    assert!(c.entries > 0 && c.cluster_entries > 0 && c.pixels_shaded_late > 0, "{c:?}");
}

#[test]
fn triangles_sorted_one_by_one_are_counted() {
    for (model, size, tile, binning) in [
        ("builtin:teapot@20k", (320, 200), 32, Binning::Exact),
        ("builtin:soup@500", (257, 129), 16, Binning::Exact),
        ("builtin:soup@500", (257, 129), 64, Binning::BoundingBox),
    ] {
        let c = compare(model, size, 1, |s, _| {
            (s.sorting, s.tile_size, s.binning) = (Sorting::Triangles, Some(tile), binning);
        });
        assert_eq!(c.clusters_whole, 0);
    }
}

#[test]
fn tiles_that_threads_share_are_counted() {
    // One tile holds nearly all.
    let far = |s: &mut Settings, camera: &mut Camera| {
        camera.eye = camera.target + (camera.eye - camera.target) * 20.0;
        s.tile_size = Some(64);
    };
    let c = compare("builtin:gyroid@60k", (320, 200), 2, far);
    assert!(c.pixels_shaded == c.pixels_shaded_late && c.largest_tile * 2 > c.cluster_entries, "{c:?}");
}
