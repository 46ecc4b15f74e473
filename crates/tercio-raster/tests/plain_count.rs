//! Compares the renderer's counts with an independent count: in plain integers, directly from the projected triangles
//! of the plain mesh, without clusters, SIMD lanes or depths. What is covered, binned and visible must not depend on
//! how it is drawn.

mod common;

use common::*;
use tercio_mesh::{Mesh, builtin};
use tercio_raster::tally::{self, Counted};
use tercio_raster::{Binning, Cull, LastStage, Settings, Sorting};
use tercio_scene::{Camera, Scene};

/// The counts of a frame that do not require drawing it.
#[derive(Debug, Default, PartialEq, Eq)]
struct Plain {
    /// Triangles, or pieces of clipped ones, with area, not culled, and with a sample of the picture in their box.
    triangles: u64,
    /// By tile, those of them that overlap it, or whose boxes do, depending on the binning.
    entries: Vec<u64>,
    /// By tile, samples covered by each triangle, summed over all triangles.
    covered: Vec<u64>,
    /// By tile, samples covered by any triangle.
    visible: Vec<u64>,
    /// By tile, pixels.
    pixels: Vec<u64>,
}

fn least(c: [i32; 3]) -> i32 {
    c[0].min(c[1]).min(c[2])
}

fn most(c: [i32; 3]) -> i32 {
    c[0].max(c[1]).max(c[2])
}

/// Twice the area; positive clockwise on the screen.
fn area([a, b, c]: [[i32; 2]; 3]) -> i64 {
    let [a, b, c] = [a, b, c].map(|p| p.map(i64::from));
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Can a triangle cover a sample in a rectangle of pixels? Not if all its corners are outside the same edge.
fn may_cover(corners: [[i32; 2]; 3], [columns, rows]: [[i32; 2]; 2]) -> bool {
    let [a, b, c] = corners;
    let clockwise = if area(corners) > 0 { [a, b, c] } else { [a, c, b] };
    (0..3).all(|k| {
        let (from, to) = (clockwise[k], clockwise[(k + 1) % 3]);
        // The rectangle's corner that is farthest inside the edge decides; samples on a left or top edge are inside.
        let (left, top) = (to[1] < from[1], to[1] == from[1] && to[0] > from[0]);
        columns.iter().any(|x| {
            rows.iter().any(|y| {
                let value = area([from, to, [x * 256 + 128, y * 256 + 128]]);
                value > 0 || value == 0 && (left || top)
            })
        })
    })
}

impl Plain {
    fn count(meshes: &[&Mesh], scene: &Scene, camera: &Camera, settings: &Settings, tile: i32) -> Self {
        let size = [settings.width as i32, settings.height as i32];
        let tiles = size.map(|n| (n + tile - 1) / tile);
        let number = |x: i32, y: i32| (y / tile * tiles[0] + x / tile) as usize;
        let zero = vec![0; (tiles[0] * tiles[1]) as usize];
        let mut plain = Self { entries: zero.clone(), covered: zero.clone(), ..Self::default() };
        (plain.visible, plain.pixels) = (zero.clone(), zero);
        let mut shown = vec![false; (size[0] * size[1]) as usize];
        each_triangle(meshes, scene, camera, (settings.width, settings.height), |instance, v| {
            let corners = v.map(|v| [v.x, v.y]);
            let mirrored = scene.instances[instance].world_from_object.matrix3.determinant() < 0.0;
            let clockwise = area(corners) > 0;
            let culled = match settings.cull {
                Cull::Auto | Cull::None => false,
                Cull::Back => clockwise != mirrored,
                Cull::Front => clockwise == mirrored,
            };
            // Samples are in the middle of pixels, at 128 of 256 sub-pixels.
            let first = |k: usize| ((least(corners.map(|c| c[k])) + 127) >> 8).max(0);
            let last = |k: usize| ((most(corners.map(|c| c[k])) - 128) >> 8).min(size[k] - 1);
            let [x, y] = [0, 1].map(|k| [first(k), last(k)]);
            if area(corners) == 0 || culled || x[0] > x[1] || y[0] > y[1] {
                return;
            }
            plain.triangles += 1;
            let in_one_tile = number(x[0], y[0]) == number(x[1], y[1]);
            for row in y[0] / tile..=y[1] / tile {
                for column in x[0] / tile..=x[1] / tile {
                    let inside = |[first, last]: [i32; 2], k: i32| {
                        [first.max(k * tile), last.min(k * tile + tile - 1)]
                    };
                    let is_tested = settings.binning == Binning::Exact && !in_one_tile;
                    if !is_tested || may_cover(corners, [inside(x, column), inside(y, row)]) {
                        plain.entries[(row * tiles[0] + column) as usize] += 1;
                    }
                }
            }
            for y in y[0]..=y[1] {
                for x in x[0]..=x[1] {
                    if covers(corners, [x, y]) != 0 {
                        plain.covered[number(x, y)] += 1;
                        shown[(y * size[0] + x) as usize] = true;
                    }
                }
            }
        });
        for (index, shown) in (0..).zip(shown) {
            let tile = number(index % size[0], index / size[0]);
            plain.pixels[tile] += 1;
            plain.visible[tile] += u64::from(shown);
        }
        plain
    }
}

/// Models whose triangles are small and large, thin, disconnected, clipped, and facing either way.
fn each_picture(mut with: impl FnMut(&str, &[&Mesh], &Scene, &Camera, &Settings)) {
    for (model, (width, height), eye) in [
        ("builtin:teapot@2k", (257, 129), [3.0, 2.0, 4.0]),
        ("builtin:gyroid@5k", (200, 150), [30.0, 20.0, 40.0]),
        ("builtin:soup@500", (131, 67), [2.0, 1.0, 2.0]),
        // From inside: some triangles are clipped.
        ("builtin:sphere@3k", (160, 120), [0.1, 0.2, 0.1]),
        ("builtin:terrain@6k", (128, 128), [2.0, 3.0, 2.0]),
    ] {
        let mesh = builtin::make(model).expect("a model");
        let scene = with_second_instance(scene(&mesh));
        let bounds = scene.bounds();
        let eye = bounds.center() + glam::DVec3::from(eye) * bounds.size().length() / 4.0;
        let camera = perspective(eye.to_array(), bounds.center().to_array(), 40.0);
        for cull in [Cull::Auto, Cull::Back, Cull::Front] {
            for tile_size in [8, 32, 128] {
                let settings =
                    Settings { cull, tile_size: Some(tile_size), ..Settings::one_sample(width, height) };
                let what = format!("{model}, {cull:?}, tiles of {tile_size}");
                with(&what, &[&mesh, &mesh], &scene, &camera, &settings);
            }
        }
    }
}

fn count(scene: &Scene, camera: &Camera, settings: &Settings, workers: usize) -> Counted {
    tally::count(scene, camera, settings, workers).expect("a picture")
}

#[test]
fn counts_of_triangles_binned_one_by_one_equal_the_plain_count() {
    each_picture(|what, meshes, scene, camera, settings| {
        for binning in [Binning::Exact, Binning::BoundingBox] {
            let settings = Settings { sorting: Sorting::Triangles, binning, ..settings.clone() };
            let tile = settings.tile_edge() as i32;
            let plain = Plain::count(meshes, scene, camera, &settings, tile);
            let counted = count(scene, camera, &settings, 1);
            let (binning, backend) = (&counted.stats.binning, &counted.stats.backend);
            let all: u64 = meshes.iter().map(|m| m.triangles.len() as u64).sum();
            assert_eq!(counted.stats.frontend.triangles_in, all, "{what}");
            assert_eq!(binning.triangles, plain.triangles, "{what}");
            let sum = |of_tiles: &[u64]| of_tiles.iter().sum::<u64>();
            let entries = sum(&plain.entries);
            assert_eq!((binning.entries, binning.tiles), (entries, plain.entries.len() as u64), "{what}");
            assert_eq!(binning.overlap, entries as f64 / plain.triangles.max(1) as f64, "{what}");
            assert_eq!(binning.tiles_used, plain.entries.iter().filter(|n| **n > 0).count() as u64, "{what}");
            assert_eq!(binning.largest_tile, plain.entries.iter().copied().max().unwrap_or(0), "{what}");
            assert_eq!(backend.samples_covered, sum(&plain.covered), "{what}");
            assert_eq!(backend.pixels_visible, sum(&plain.visible), "{what}");
            // All pixels are shaded at the end of their tile, so each is shaded once.
            assert_eq!(backend.pixels_shaded, backend.pixels_visible, "{what}");
            let by_tile = |of: fn(&tally::TileWork) -> u64| counted.tiles.iter().map(of).collect::<Vec<_>>();
            assert_eq!(by_tile(|t| t.details.entries_drawn), plain.entries, "{what}");
            assert_eq!(by_tile(|t| t.counts.samples_covered), plain.covered, "{what}");
            assert_eq!(by_tile(|t| t.counts.pixels_visible), plain.visible, "{what}");
            assert_eq!(by_tile(|t| t.details.pixels), plain.pixels, "{what}");
        }
    });
}

#[test]
fn counts_of_whole_clusters_agree_with_the_plain_count() {
    each_picture(|what, meshes, scene, camera, settings| {
        let plain = Plain::count(meshes, scene, camera, settings, settings.tile_edge() as i32);
        for workers in [1, 2, 7] {
            let counted = count(scene, camera, settings, workers);
            let by_tile = |of: fn(&tally::TileWork) -> u64| counted.tiles.iter().map(of).collect::<Vec<_>>();
            assert_eq!(by_tile(|t| t.counts.pixels_visible), plain.visible, "{what}, {workers}");
            assert_eq!(by_tile(|t| t.details.pixels), plain.pixels, "{what}, {workers}");
            // Occluded clusters need not be drawn, and pixels may be shaded and later overdrawn.
            let covered = by_tile(|t| t.counts.samples_covered);
            assert!(covered.iter().zip(&plain.covered).all(|(ours, all)| ours <= all), "{what}, {workers}");
            let shaded = by_tile(|t| t.counts.pixels_shaded);
            assert!(shaded.iter().zip(&plain.visible).all(|(ours, seen)| ours >= seen), "{what}, {workers}");
        }
    });
}

/// The counts of a frame's statistics equal those of the full tally, whatever the number of threads that execute it.
#[test]
fn all_tallies_are_equal() {
    each_picture(|what, _, scene, camera, settings| {
        for workers in [1, 2, 3] {
            for last_stage in [LastStage::Bin, LastStage::Sieve, LastStage::Visibility, LastStage::Output] {
                let settings = Settings { last_stage, ..settings.clone() };
                let drawn = with_threads(workers, || draw(scene, camera, &settings)).stats;
                let counted =
                    [1, 2, 5].map(|pool| with_threads(pool, || count(scene, camera, &settings, workers)));
                for found in &counted {
                    let name = format!("{what}, {workers} workers, {last_stage:?}");
                    assert_eq!(found.stats.frontend, drawn.frontend, "{name}");
                    assert_eq!(found.stats.backend, drawn.backend, "{name}");
                    let mut binning = found.stats.binning;
                    binning.bytes = drawn.binning.bytes;
                    assert_eq!(binning, drawn.binning, "{name}");
                    assert_eq!(
                        (found.stats.threads, found.stats.tile_size),
                        (workers, drawn.tile_size),
                        "{name}"
                    );
                    assert_eq!(
                        (&found.tiles, found.details),
                        (&counted[0].tiles, counted[0].details),
                        "{name}"
                    );
                    assert_eq!(found.bytes_touched, counted[0].bytes_touched, "{name}");
                }
            }
        }
    });
}

/// A tile that holds nearly all of the work is drawn by all workers, and the counts depend only on their number.
#[test]
fn counts_of_a_shared_tile_depend_on_the_workers_only() {
    let mesh = builtin::make("builtin:gyroid@60k").expect("a model");
    let scene = scene(&mesh);
    let bounds = scene.bounds();
    let eye = bounds.center() + glam::DVec3::new(0.5, 0.4, 1.0) * bounds.size().length() * 12.0;
    let camera = perspective(eye.to_array(), bounds.center().to_array(), 40.0);
    let settings = Settings { tile_size: Some(64), ..Settings::one_sample(320, 200) };
    let alone = count(&scene, &camera, &settings, 1);
    let mut drawn_before = alone.stats.backend.clusters_drawn;
    for workers in [2, 5, 64] {
        let drawn = with_threads(workers.min(5), || draw(&scene, &camera, &settings)).stats.backend;
        for pool in [1, 2, 3] {
            let shared = with_threads(pool, || count(&scene, &camera, &settings, workers));
            assert!(shared.tiles.iter().any(|t| t.is_shared), "{workers}");
            let visible = shared.stats.backend.pixels_visible;
            assert_eq!((visible, visible), (alone.stats.backend.pixels_visible, drawn.pixels_visible));
            if workers <= 5 {
                assert_eq!(shared.stats.backend, drawn, "{workers} workers, {pool} threads");
            }
            // A worker's occlusion tests do not see what the others have drawn.
            assert!(shared.stats.backend.clusters_drawn >= drawn_before, "{workers}");
            if pool == 3 {
                drawn_before = shared.stats.backend.clusters_drawn;
            }
        }
    }
}
