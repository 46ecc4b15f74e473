use std::sync::Arc;

use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::comm::{Communicator as _, threads};
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{Matter, ParallelError, Ranks, between_processes, in_process};
use tercio_raster::{Frame, Settings};
use tercio_scene::{Camera, Scene};

use super::network::Source;
use super::together::{Resources, choose_together};
use super::*;
use crate::predict::ranks::RanksError;
use crate::predict::views;

fn made(model: &str, (width, height): (u32, u32)) -> (Scene, Camera) {
    let mesh = builtin::make(model).expect("a built-in model");
    let bounds = mesh.bounds();
    let scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
    (scene, views::camera(&bounds, (width, height), 1, 7))
}

fn handed_over() -> Network {
    Network::in_process(&machine().expect("built in")).expect("it has a network")
}

/// Ranks with a processor each.
fn job(ranks: usize, network: Network) -> Job {
    Job { ranks, threads: 1, processors: ranks, network }
}

fn chosen(scene: &Scene, camera: &Camera, settings: &Settings, job: Job, limits: &Limits) -> Choice {
    choose(&Picture { scene, camera, settings }, job, limits).expect("a picture")
}

const SIZE: (u32, u32) = (640, 480);

#[test]
fn the_choice_is_the_same_every_time() {
    let (scene, camera) = made("builtin:gyroid@20k", SIZE);
    for settings in [Settings::one_sample(SIZE.0, SIZE.1), Settings::new(SIZE.0, SIZE.1)] {
        for ranks in [1, 2, 5, 16, 100] {
            let again = || {
                let mut choice =
                    chosen(&scene, &camera, &settings, job(ranks, handed_over()), &Limits::default());
                (choice.seconds, choice.measuring) = (0.0, 0.0);
                choice
            };
            let first = again();
            assert_eq!(first, again());
            let totals: Vec<f64> = first.candidates.iter().map(|c| c.terms.total()).collect();
            assert!(totals.is_sorted() && totals.iter().all(|t| t.is_finite() && *t > 0.0), "{totals:?}");
        }
    }
}

#[test]
fn one_rank_exchanges_nothing() {
    let (scene, camera) = made("builtin:teapot@5k", SIZE);
    let settings = Settings::new(SIZE.0, SIZE.1);
    let slow = Network { latency: 1.0, bandwidth: 1.0, source: Source::Measured { partners: 1 } };
    let choice = chosen(&scene, &camera, &settings, job(1, slow), &Limits::default());
    let [only] = choice.candidates[..] else { panic!("{choice:?}") };
    let Terms { exchange, composite, collect, draw, front_end } = only.terms;
    assert_eq!(([exchange, composite, collect], only.sent), ([0.0; 3], Sums::default()));
    assert!(draw > 0.0 && front_end > 0.0);
}

#[test]
fn on_a_slow_network_the_fewest_bytes_win() {
    let (scene, camera) = made("builtin:gyroid@60k", SIZE);
    let settings = Settings::new(SIZE.0, SIZE.1);
    // 10 kB/s: nothing but bytes counts.
    let slow = Network { latency: 1e-6, bandwidth: 1e4, source: Source::Measured { partners: 1 } };
    for ranks in [2, 4, 9] {
        let choice = chosen(&scene, &camera, &settings, job(ranks, slow), &Limits::default());
        let best = choice.candidates[0];
        assert_eq!(best.sharing.organisation, Organisation::SortFirst, "{best:?}");
        let fewest = choice.candidates.iter().map(|c| c.sent.bytes).fold(f64::INFINITY, f64::min);
        assert!(best.sent.bytes <= 1.1 * fewest, "{ranks}: {best:?}, {fewest}");
    }
}

#[test]
fn where_messages_take_long_few_of_them_are_sent() {
    let (scene, camera) = made("builtin:teapot@5k", SIZE);
    let settings = Settings::one_sample(SIZE.0, SIZE.1);
    let late = Network { latency: 0.5, bandwidth: 1e12, source: Source::Measured { partners: 1 } };
    let choice = chosen(&scene, &camera, &settings, job(8, late), &Limits::default());
    // Only finished pixels: every other way has a round more.
    assert_eq!(choice.sharing().organisation, Organisation::SortFirst, "{:?}", choice.candidates[0]);
    let worst = choice.candidates.last().expect("some").sharing;
    assert!(worst.organisation.composites(8), "{worst:?}");
}

/// Many clusters and hardly a pixel: testing all clusters on every rank is what must not be done.
#[test]
fn in_an_almost_empty_picture_the_front_end_is_shared() {
    let (scene, camera) = made("builtin:sphere@200k", (64, 64));
    // The camera is far away.
    let eye = camera.target + (camera.eye - camera.target) * 200.0;
    let camera = Camera { eye, ..camera };
    let settings = Settings::one_sample(64, 64);
    let fast = Network { latency: 1e-7, bandwidth: 1e11, source: Source::Measured { partners: 1 } };
    let choice = chosen(&scene, &camera, &settings, job(8, fast), &Limits::default());
    assert_ne!(choice.sharing().organisation, Organisation::SortFirst, "{:?}", choice.candidates[0]);
    let of = |organisation| {
        let is = |c: &&Predicted| c.sharing.organisation == organisation;
        choice.candidates.iter().find(is).expect("a candidate").terms
    };
    let (first, middle) = (of(Organisation::SortFirst), of(Organisation::SortMiddle));
    assert!(first.front_end > middle.front_end, "{first:?} {middle:?}");
}

#[test]
fn limits_are_kept() {
    let (scene, camera) = made("builtin:teapot@5k", SIZE);
    let settings = Settings::new(SIZE.0, SIZE.1);
    let composition = Some(Composition::Ring);
    let choose = |limits: &Limits| chosen(&scene, &camera, &settings, job(6, handed_over()), limits);
    let ring = choose(&Limits { composition, ..Limits::default() });
    assert!(ring.candidates.iter().all(|c| c.sharing.composition == Composition::Ring));
    let both = choose(&Limits { group: Some(4), division: Some(Division::Columns), composition, all: false });
    let organisation = Organisation::SortTwice { group: 4 };
    assert_eq!(both.candidates.len(), 1);
    let (division, composition) = (Division::Columns, Composition::Ring);
    let expected = Sharing { division, composition, ..organisation.into() };
    assert_eq!(both.sharing(), expected);
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let none =
        super::choose(&picture, job(3, handed_over()), &Limits { group: Some(4), ..Limits::default() });
    assert!(matches!(none, Err(PredictError::NoCandidate(_))), "{none:?}");
}

/// Twice the ranks take about twice the steps at most: nothing is done for pairs of ranks, or for each tile of each rank.
#[test]
fn choosing_among_many_ranks_takes_few_steps() {
    let (scene, camera) = made("builtin:gyroid@100k", (1920, 1080));
    let settings = Settings::new(1920, 1080);
    let steps = |ranks: usize| {
        let choice = chosen(&scene, &camera, &settings, job(ranks, handed_over()), &Limits::default());
        (choice.steps / choice.candidates.len() as u64) as f64
    };
    let few: Vec<f64> = [2, 4, 8, 16].map(steps).to_vec();
    let many: Vec<f64> = [128, 256, 512, 1024].map(steps).to_vec();
    for [less, more] in few.array_windows().chain(many.array_windows()) {
        assert!(*more < 2.5 * less, "{few:?} {many:?}");
    }
    // At most a few loops over all tiles and what is in them, for each candidate.
    assert!(few[3] < 4e4 && many[3] < 5e5, "{few:?} {many:?}");
}

/// Bytes that are predicted are 0.4 to 2.5 times those that ranks send.
#[test]
fn predicted_bytes_are_about_those_that_are_sent() {
    let mut wrong = Vec::new();
    for model in ["builtin:teapot@30k", "builtin:gyroid@60k", "builtin:terrain@30k"] {
        let (scene, camera) = made(model, SIZE);
        for settings in [Settings::one_sample(SIZE.0, SIZE.1), Settings::new(SIZE.0, SIZE.1)] {
            for ranks in [2, 5] {
                let choice =
                    chosen(&scene, &camera, &settings, job(ranks, handed_over()), &Limits::default());
                let mut done = Vec::new();
                for candidate in &choice.candidates {
                    // One division of each.
                    let of = (candidate.sharing.organisation, candidate.sharing.composition);
                    if done.contains(&of) {
                        continue;
                    }
                    done.push(of);
                    let ranks = Ranks { count: ranks, threads: 1, sharing: candidate.sharing };
                    let (_, report) = in_process::draw(ranks, &scene, &camera, &settings).expect("a frame");
                    let ratio = candidate.sent.bytes / report.bytes as f64;
                    let what = format!("{model}, {} samples, {:?}", report.samples, candidate.sharing);
                    if !(0.4..2.5).contains(&ratio) {
                        wrong.push(format!("{what}: {ratio} of {}", report.bytes));
                    }
                }
                assert!(done.len() > 3);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// More ranks than tiles: few of them own one and send it to rank 0.
#[test]
fn predicted_messages_of_many_ranks_are_about_those_that_are_sent() {
    let size = (160, 120);
    let (scene, camera) = made("builtin:gyroid@20k", size);
    let settings = Settings::one_sample(size.0, size.1);
    for composition in [Composition::DirectSend, Composition::Tree, Composition::radix_k(8)] {
        let count = 96;
        let sharing = Sharing { composition, ..Organisation::SortLast.into() };
        let limits = Limits { composition: Some(composition), ..Limits::default() };
        let choice = chosen(&scene, &camera, &settings, job(count, handed_over()), &limits);
        let candidate = choice.candidates.iter().find(|c| c.sharing == sharing).expect("sort-last");
        let ranks = Ranks { count, threads: 1, sharing };
        let (_, report) = in_process::draw(ranks, &scene, &camera, &settings).expect("a frame");
        let ratio = candidate.sent.messages / report.messages as f64;
        assert!((0.95..1.05).contains(&ratio), "{sharing:?}: {ratio} of {}", report.messages);
    }
}

#[test]
fn all_ranks_choose_the_same_and_draw_it() {
    let (scene, camera) = made("builtin:teapot@5k", (200, 150));
    let settings = Settings::new(200, 150);
    let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
    let resources = Resources { threads: 1, processors: 2 };
    let alone = tercio_raster::Renderer::new().render(&scene, &camera, &settings).expect("a picture");
    for ranks in [1, 2, 3, 8] {
        let all = threads::run(ranks, |comm| {
            let chosen = choose_together(comm, &picture, resources, &Limits::default());
            let (sharing, choice) = chosen.map_err(of_ranks)?;
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            let mut frame = Frame::default();
            let report = between_processes::draw_frame(&mut Rank::new(), comm, &task, &mut frame)?;
            assert_eq!((choice.is_some(), report.is_some()), (comm.rank() == 0, comm.rank() == 0));
            if let Some(choice) = choice {
                assert_eq!(choice.sharing(), sharing);
                assert_eq!(frame.planes.color, alone.planes.color);
            }
            Ok(sharing)
        });
        let all = all.expect("all draw");
        assert!(all.iter().all(|sharing| *sharing == all[0]), "{all:?}");
    }
}

fn of_ranks(error: RanksError) -> ParallelError {
    match error {
        RanksError::Parallel(error) => error,
        RanksError::Predict(error) => panic!("{error}"),
    }
}

/// One rank chooses with other limits, draws another picture, or was started with an organisation: all end with one message.
#[test]
fn ranks_that_differ_end() {
    let (scene, camera) = made("builtin:teapot@5k", (64, 64));
    let settings = Settings::new(64, 64);
    let resources = Resources { threads: 1, processors: 2 };
    let end = |odd: usize, how: &str| {
        let result = threads::run(5, |comm| {
            let is_odd = comm.rank() == odd;
            if is_odd && how == "fixed" {
                let sharing = Organisation::SortMiddle.into();
                let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
                let mut frame = Frame::default();
                return between_processes::draw_frame(&mut Rank::new(), comm, &task, &mut frame).map(|_| ());
            }
            let limits = match is_odd && how == "limits" {
                true => Limits { division: Some(Division::Rows), ..Limits::default() },
                false => Limits::default(),
            };
            let shift = if is_odd && how == "camera" { [0.25, 0.0] } else { [0.0; 2] };
            let camera = Camera { shift, ..camera };
            let picture = Picture { scene: &scene, camera: &camera, settings: &settings };
            choose_together(comm, &picture, resources, &limits).map(|_| ()).map_err(of_ranks)
        });
        match result.expect_err("a rank differs") {
            ParallelError::Differs { what, .. } => what,
            other => panic!("{other}"),
        }
    };
    for odd in [0, 1, 4] {
        assert_eq!(end(odd, "fixed"), Matter::Organisation);
        assert_eq!(end(odd, "limits"), Matter::Organisation);
        assert_eq!(end(odd, "camera"), Matter::Camera);
    }
}
