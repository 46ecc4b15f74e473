//! Regions that move from frame to frame: the pictures are those of one renderer, and the ranks have about the same work.

use std::sync::Arc;

use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::comm::Kind;
use tercio_parallel::in_process::{Crew, draw_frames};
use tercio_parallel::{Division, FrameReport, Organisation, Ranks, Sharing};
use tercio_raster::{Frame, Outputs, Renderer, Sampling, Settings};
use tercio_scene::{Camera, Framing, Scene};

fn scene(model: &str) -> Scene {
    let mesh = builtin::make(model).expect("a model");
    Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())))
}

/// Cameras around a scene, this many degrees from each other.
fn turn(scene: &Scene, settings: &Settings, frames: usize, step: f64) -> Vec<Camera> {
    let camera = |frame: usize| {
        let azimuth = 30.0 + step * frame as f64;
        Framing { azimuth, ..settings.framing() }.camera_for_scene(scene)
    };
    (0..frames).map(camera).collect()
}

fn adaptive(organisation: Organisation) -> Sharing {
    Sharing { division: Division::Adaptive, ..organisation.into() }
}

fn load_messages(report: &FrameReport) -> u64 {
    report.by_kind().into_iter().find(|of| of.0 == Kind::Load).map_or(0, |of| of.1.sent_messages)
}

#[test]
fn every_frame_has_the_bytes_of_one_renderer() {
    let opaque = scene("builtin:teapot@4k");
    let mut clear = opaque.clone();
    clear.instances[0].surface.opacity = 0.4;
    for (scene, sampling) in
        [(&opaque, Sampling::NONE), (&opaque, Sampling::default()), (&clear, Sampling::default())]
    {
        let settings =
            Settings { outputs: Outputs::ALL, sampling, tile_size: Some(16), ..Settings::new(131, 93) };
        let mut cameras = turn(scene, &settings, 4, 25.0);
        // Nothing but a few tiles at the border, then the whole again.
        cameras.push(Camera { shift: [0.9, 0.0], ..cameras[0] });
        cameras.push(cameras[1]);
        let draw = |camera: &Camera| Renderer::new().render(scene, camera, &settings).expect("a picture");
        let expected: Vec<Frame> = cameras.iter().map(draw).collect();
        for organisation in [
            Organisation::SortFirst,
            Organisation::SortMiddle,
            Organisation::SortTwice { group: 2 },
            Organisation::SortTwice { group: 3 },
        ] {
            for count in [1, 2, 3, 5, 8, 64] {
                let threads = 1 + count % 2;
                let ranks = Ranks { count, threads, sharing: adaptive(organisation) };
                let check = |number: usize, frame: &mut Frame| {
                    if let Some(difference) = frame.difference(&expected[number]) {
                        panic!("{ranks:?}, frame {number}: {difference}");
                    }
                };
                let reports = draw_frames(ranks, scene, &cameras, &settings, check).expect("pictures");
                // What the last frame cost is sent, once there is one.
                let last = load_messages(reports.last().expect("frames"));
                assert_eq!(last > 0, organisation.group(count) > 1, "{ranks:?}");
            }
        }
    }
}

/// The same ranks draw a picture of another size, with another division, or in other groups, in between.
#[test]
fn what_is_known_of_the_last_frame_may_be_of_no_use() {
    let scene = scene("builtin:gyroid@4k");
    let first = adaptive(Organisation::SortFirst);
    let twice = |group| adaptive(Organisation::SortTwice { group });
    let mut crew = Crew::default();
    for (sharing, width, count, knows) in [
        (first, 131, 5, false),
        (first, 131, 5, true),
        (first, 231, 5, false),
        (first, 231, 5, true),
        (Organisation::SortFirst.into(), 231, 5, false),
        (first, 231, 5, false),
        (twice(4), 231, 5, false),
        (twice(4), 231, 5, true),
        (twice(5), 231, 5, false),
        (first, 231, 5, true),
        (Organisation::SortLast.into(), 231, 5, false),
        (first, 231, 4, false),
        (first, 231, 4, true),
    ] {
        let settings = Settings { tile_size: Some(16), ..Settings::one_sample(width, 93) };
        let camera = settings.framing().camera_for_scene(&scene);
        let expected = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
        let ranks = Ranks { count, threads: 1, sharing };
        let (found, report) = crew.draw(ranks, &scene, &camera, &settings).expect("a picture");
        assert_eq!(found.difference(&expected), None, "{ranks:?}, {width}");
        assert_eq!(load_messages(&report) > 0, knows, "{ranks:?}, {width}");
    }
}

/// Most over mean of the ranks' work.
fn imbalance(report: &FrameReport) -> f64 {
    let work: Vec<u64> = report.ranks.iter().map(|rank| rank.frame.backend.work()).collect();
    *work.iter().max().expect("ranks") as f64 * work.len() as f64 / work.iter().sum::<u64>() as f64
}

#[test]
fn ranks_have_about_the_same_work_once_it_is_known() {
    for model in ["builtin:teapot@300k", "builtin:gyroid@300k", "builtin:terrain@300k"] {
        let scene = scene(model);
        let settings = Settings::one_sample(1920, 1080);
        let cameras = turn(&scene, &settings, 3, 1.0);
        for count in [2, 3, 7, 16] {
            let ranks = Ranks { count, threads: 1, sharing: adaptive(Organisation::SortFirst) };
            let reports = draw_frames(ranks, &scene, &cameras, &settings, |_, _| ()).expect("pictures");
            let found: Vec<f64> = reports.iter().map(imbalance).collect();
            // The first frame is divided by an estimate.
            assert!(found[0] <= 1.35, "{model}, {count} ranks: {found:?}");
            assert!(found[1..].iter().all(|&most| most <= 1.2), "{model}, {count} ranks: {found:?}");
        }
    }
}
