//! Up to 1,024 ranks: more than clusters and tiles, and more than a machine has processors.

mod common;

use common::*;
use tercio_parallel::{Composition, Division, Organisation, Ranks, Sharing};
use tercio_raster::{Frame, Renderer, SamplePattern, Sampling, Settings};
use tercio_scene::Scene;

/// Small, with many clusters; the second instance may be seen through.
fn model(opacity: f32) -> Scene {
    let mut scene = with_second_instance(scene("builtin:gyroid@500", 4));
    scene.instances[1].surface.opacity = opacity;
    scene
}

fn alone(scene: &Scene, settings: &Settings) -> Frame {
    Renderer::new().render(scene, &camera(scene, 2.0, false), settings).expect("a picture")
}

fn many(count: usize, sharing: Sharing) -> Ranks {
    Ranks { count, threads: 1, sharing }
}

/// With one sample, with several, and with layers.
fn kinds() -> [(Scene, Settings, &'static str); 3] {
    let settings = Settings { tile_size: Some(8), ..Settings::one_sample(64, 48) };
    let samples = Settings { sampling: Sampling::of(SamplePattern::Sparse2), ..settings.clone() };
    [
        (model(1.0), settings, "one sample"),
        (model(1.0), samples.clone(), "samples"),
        (model(0.5), samples, "layers and samples"),
    ]
}

#[test]
fn a_thousand_ranks() {
    let twice = Organisation::SortTwice { group: 32 };
    let organisations = [
        &[Organisation::SortFirst, Organisation::SortMiddle, twice][..],
        &[Organisation::SortLast],
        &[Organisation::SortLast],
    ];
    for ((scene, settings, what), organisations) in kinds().into_iter().zip(organisations) {
        let (camera, expected) = (camera(&scene, 2.0, false), alone(&scene, &settings));
        for &organisation in organisations {
            check_against(&expected, &scene, &camera, &settings, many(1024, organisation.into()), what);
        }
    }
}

/// Counts beside powers of two, primes and others. Each is drawn in another way with each composition; that all of them are right for
/// 1,023 ranks is tested where no thread is needed for each.
#[test]
fn every_composition_of_many_ranks() {
    for (number, (scene, settings, what)) in kinds().into_iter().enumerate() {
        let (camera, expected) = (camera(&scene, 2.0, false), alone(&scene, &settings));
        for (row, count) in [17, 31, 33, 64, 100, 255, 257, 1023].into_iter().enumerate() {
            for (column, composition) in Composition::ALL.into_iter().enumerate() {
                if (row + column) % 3 == number && (count < 256 || column % 2 == row % 2) {
                    let last = Sharing { composition, ..Organisation::SortLast.into() };
                    check_against(&expected, &scene, &camera, &settings, many(count, last), what);
                }
            }
        }
    }
}

/// Every way to divide the picture, and groups of which the last one is smaller.
#[test]
fn every_division_of_many_ranks() {
    let [_, (scene, settings, what), _] = kinds();
    let (camera, expected) = (camera(&scene, 2.0, false), alone(&scene, &settings));
    for division in Division::ALL {
        for (count, organisation) in [
            (33, Organisation::SortFirst),
            (65, Organisation::SortMiddle),
            (100, Organisation::SortTwice { group: 7 }),
        ] {
            let sharing = Sharing { division, ..organisation.into() };
            check_against(&expected, &scene, &camera, &settings, many(count, sharing), what);
        }
    }
}
