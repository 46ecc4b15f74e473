//! Ranks that share the picture have about the same work.

use std::sync::Arc;

use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::in_process::draw;
use tercio_parallel::{Organisation, Ranks};
use tercio_raster::Settings;
use tercio_scene::Scene;

/// Triangles drawn, most over mean.
fn imbalance(scene: &Scene, settings: &Settings, organisation: Organisation, count: usize) -> f64 {
    let camera = settings.framing().camera_for_scene(scene);
    let ranks = Ranks { count, threads: 1, sharing: organisation.into() };
    let (_, report) = draw(ranks, scene, &camera, settings).expect("a picture");
    let drawn: Vec<u64> = report.ranks.iter().map(|rank| rank.frame.backend.triangles_drawn).collect();
    let (most, sum) = (*drawn.iter().max().expect("ranks"), drawn.iter().sum::<u64>());
    most as f64 * count as f64 / sum as f64
}

#[test]
fn every_number_of_ranks_shares_a_model_in_the_middle() {
    for model in ["builtin:teapot@300k", "builtin:gyroid@300k", "builtin:terrain@300k"] {
        let mesh = builtin::make(model).expect("a model");
        let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
        for settings in [Settings::one_sample(1920, 1080), Settings::new(1920, 1080)] {
            for count in 2..=16 {
                for organisation in [Organisation::SortFirst, Organisation::SortMiddle] {
                    let found = imbalance(&scene, &settings, organisation, count);
                    let samples = settings.sampling.pattern.count();
                    assert!(
                        found <= 1.3,
                        "{model}, {samples} samples, {organisation}, {count} ranks: {found}"
                    );
                }
            }
        }
    }
}
