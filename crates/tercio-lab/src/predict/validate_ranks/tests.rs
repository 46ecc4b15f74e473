use std::sync::Arc;

use tercio_mesh::cluster::{PartitionOptions, partition};

use super::*;

/// Counters and bytes equal those of the ranks, whatever they share.
#[test]
fn counts_are_those_of_the_ranks() {
    for (model, size, distance) in [
        ("builtin:teapot@3k", (150, 110), 1.0),
        ("builtin:soup@300", (131, 67), 1.0),
        // From inside the model: triangles are clipped.
        ("builtin:sphere@2k", (96, 80), 0.05),
        ("builtin:sphere@100", (1, 1), 1.0),
    ] {
        let mesh = tercio_mesh::builtin::make(model).unwrap();
        let bounds = mesh.bounds();
        let mut scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
        // A second instance: ranks begin inside it.
        let mut second = scene.instances[0].clone();
        second.world_from_object.translation += bounds.size() * 0.3;
        scene.instances.push(second);
        let mut camera = views::camera(&bounds, size, 1, 5);
        camera.eye = bounds.center() + (camera.eye - bounds.center()) * distance;
        for organisation in [Organisation::SortFirst, Organisation::SortLast] {
            for ranks in [1, 2, 3, 7] {
                let report = &measure(&scene, &camera, size, ranks, organisation, 1).unwrap()[0];
                let theirs: Vec<_> = report.ranks.iter().map(RankCounts::measured).collect();
                let edge = settings(size).tile_edge();
                let ours = predict_counts(&scene, &camera, size, edge, ranks, organisation).unwrap();
                assert_eq!(ours, theirs, "{model}, {ranks} ranks, {organisation:?}");
                let drawing = times::drawing(&scene, &camera, size, ranks, organisation).unwrap();
                for (ours, theirs) in drawing.iter().zip(&report.ranks) {
                    let theirs = Counters::counted(&theirs.frame);
                    assert_eq!(ours.comparable(), theirs, "{model}, {ranks} ranks, {organisation:?}");
                }
                assert_eq!(ours.iter().map(|c| c.bytes).sum::<u64>(), report.bytes);
                assert_eq!(ours.iter().map(|c| c.messages).sum::<u64>(), report.messages);
            }
        }
    }
}
