//! Ranks that communicate only by messages: picture and counts are those of ranks in one process.

use std::sync::Arc;

use glam::DVec3;
use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::between_processes::draw_frame;
use tercio_parallel::comm::threads;
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::report::RankStages;
use tercio_parallel::{FrameReport, Organisation, Ranks, in_process};
use tercio_raster::stats::StageTimes;
use tercio_raster::{Frame, Settings};
use tercio_scene::{Camera, Projection, Scene};

/// A scene and a camera, made anew as in every process.
fn made() -> (Scene, Camera) {
    let mesh = builtin::make("builtin:teapot@5k").expect("a model");
    let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    let bounds = scene.bounds();
    let eye = bounds.center() + DVec3::new(0.3, 0.4, 0.9) * bounds.radius() * 2.5;
    let projection = Projection::Perspective { fov_y: 0.8 };
    let camera =
        Camera { eye, target: bounds.center(), up: DVec3::Y, projection, near: None, shift: [0.0; 2] };
    (scene, camera)
}

/// The parts of a report that do not change from run to run.
fn counts(mut report: FrameReport) -> FrameReport {
    report.milliseconds = 0.0;
    for rank in &mut report.ranks {
        rank.stages = RankStages::default();
        rank.frame.milliseconds = StageTimes::default();
    }
    report
}

#[test]
fn picture_and_counts_are_those_of_ranks_in_one_process() {
    for organisation in [Organisation::SortFirst, Organisation::SortLast] {
        for count in [1, 2, 3, 7] {
            // So few regions that the last ranks own none.
            let settings = Settings { tile_size: Some(64), ..Settings::one_sample(150, 100) };
            let results = threads::run(count, |comm| {
                let (scene, camera) = made();
                let task = Task { organisation, scene: &scene, camera: &camera, settings: &settings };
                let (mut own, mut frame) = (Rank::new(1)?, Frame::default());
                let report = draw_frame(&mut own, comm, &task, &mut frame)?;
                Ok(report.map(|report| (frame, report)))
            });
            let mut results = results.expect("a picture").into_iter();
            let (frame, report) = results.next().flatten().expect("rank 0 has the picture");
            assert!(results.all(|r| r.is_none()), "others have a report");
            let (scene, camera) = made();
            let ranks = Ranks { count, threads: 1, organisation };
            let (expected, expected_report) =
                in_process::draw(ranks, &scene, &camera, &settings).expect("a picture");
            assert!(frame.planes.color == expected.planes.color, "{organisation:?}, {count} ranks");
            assert_eq!(frame.stats.backend, expected.stats.backend);
            assert_eq!(counts(report), counts(expected_report), "{organisation:?}, {count} ranks");
        }
    }
}
