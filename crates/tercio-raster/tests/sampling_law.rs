//! Pictures with several samples per pixel: every path draws the bytes of the reference.

mod common;

use common::*;
use tercio_mesh::Mesh;
use tercio_raster::{Cull, Filter, Frame, SamplePattern, SampleShading, Sampling, Settings, SimdLevel};
use tercio_raster::{Sorting, resolve_into};
use tercio_scene::{Background, Camera, Scene};

/// Every pattern, shading and filter.
fn all_samplings() -> impl Iterator<Item = Sampling> {
    let shadings = [SampleShading::Pixel, SampleShading::Sample];
    let filters = [Filter::Box, Filter::Tent];
    SamplePattern::ALL.into_iter().flat_map(move |pattern| {
        shadings.into_iter().flat_map(move |shading| {
            filters.into_iter().map(move |filter| Sampling { pattern, shading, filter })
        })
    })
}

fn check_every_path(mesh: &Mesh, camera: &Camera, settings: &Settings, what: &str) {
    check_paths(mesh, camera, settings, &[(3, 1, None), (64, 128, Some(2))], what);
}

#[test]
fn a_soup_that_crosses_every_plane() {
    let mesh = soup(20_000, 1);
    let camera = perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0);
    for pattern in [SamplePattern::Sparse4, SamplePattern::Sparse16] {
        let settings = Settings { sampling: Sampling::of(pattern), ..everything(111, 87) };
        check_every_path(&mesh, &camera, &settings, &format!("inside, {pattern}"));
    }
}

#[test]
fn every_sampling() {
    let mesh = soup(4_000, 2);
    let plain = with_second_instance(scene(&mesh));
    let camera = perspective([0.5, 1.0, 3.0], [0.0; 3], 40.0);
    for sampling in all_samplings() {
        for tile_size in [8, 32] {
            let settings = Settings { sampling, tile_size: Some(tile_size), ..everything(75, 58) };
            let expected = draw_reference(&mesh, &plain, &camera, &settings);
            for sorting in [Sorting::Clusters, Sorting::Triangles] {
                let settings = Settings { sorting, ..settings.clone() };
                let what = format!("{sampling:?}, {sorting:?}, tiles of {tile_size}");
                assert_same(&expected, &draw(&plain, &camera, &settings), &what);
            }
        }
    }
}
