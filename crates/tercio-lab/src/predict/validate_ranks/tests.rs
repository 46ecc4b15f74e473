use std::sync::Arc;

use tercio_mesh::cluster::{PartitionOptions, partition};

use super::*;
use crate::predict::ranks::exchange::KINDS;

/// Counters and bytes equal those of the ranks, for any way of sharing.
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
        // A second instance, so that a rank's part begins inside it.
        let mut second = scene.instances[0].clone();
        second.world_from_object.translation += bounds.size() * 0.3;
        scene.instances.push(second);
        let mut camera = views::camera(&bounds, size, 1, 5);
        camera.eye = bounds.center() + (camera.eye - bounds.center()) * distance;
        for organisation in [Organisation::SortFirst, Organisation::SortLast] {
            for ranks in [1, 2, 3, 7] {
                let settings = Settings::one_sample(size.0, size.1);
                let work =
                    RanksWork::count(&scene, &camera, &settings, (ranks, organisation.into())).unwrap();
                let measured = MeasuredRanks::draw(&scene, &camera, &work.sharing, 1).unwrap();
                let report = &measured.reports[0];
                for (rank, theirs) in report.ranks.iter().enumerate() {
                    let what = format!("{model}, {ranks} ranks, {organisation:?}");
                    assert_eq!(work.messages.counts(rank), RankCounts::measured(theirs), "{what}");
                    let drawn = Counters::from_stats(&theirs.frame);
                    assert_eq!(work.drawing[rank].comparable(), drawn.comparable(), "{what}");
                }
                assert_eq!(work.messages.total(), (report.messages, report.bytes));
            }
        }
    }
}

/// A small model, and costs that do not matter.
fn small() -> (Machine, ExchangeCosts, [Model; 1]) {
    let machine = crate::machines::builtin("two-core-2026").unwrap().unwrap();
    let (scene, bounds) =
        crate::predict::calibrate::prepare(tercio_mesh::builtin::make("builtin:gyroid@5k").unwrap());
    (machine, ExchangeCosts([1e-9; KINDS]), [Model { name: "gyroid".into(), scene, bounds }])
}

#[test]
fn rows_are_what_is_predicted_and_compare_every_frame() {
    let (machine, costs, models) = small();
    let size = (99, 77);
    let how = [(1, Organisation::SortFirst), (3, Organisation::SortLast)];
    for clock in [Clock::Wall, Clock::Processor] {
        let options = Options { views: 2, frames: 2, rounds: 2, processors: 2, clock };
        let table = Table { models: &models, sizes: &[size], how: &how, options };
        let mut calls = 0;
        let rows = compare(&machine, &costs, table, MeasuredRanks::draw, || calls += 1).unwrap();
        assert_eq!((rows.len(), calls), (2, 4));
        for (row, how) in rows.iter().zip(how) {
            // 6 counters of the exchange and 22 of the renderer, 4 frames of each view.
            assert_eq!((row.differing.len(), row.compared), (0, 2 * 4 * 28 * how.0), "{row:?}");
            assert!(row.measured.frame.is_finite() && row.measured.frame > 0.0);
            if clock == Clock::Wall {
                let of_view = |view| {
                    let camera = views::camera(&models[0].bounds, size, view, 2);
                    let settings = Settings::one_sample(size.0, size.1);
                    let work = RanksWork::count(&models[0].scene, &camera, &settings, (how.0, how.1.into()))
                        .unwrap();
                    predict(&machine, &costs, &work, 2).unwrap().total()
                };
                let mean = (of_view(0) + of_view(1)) / 2.0;
                assert!((row.predicted.frame / mean - 1.0).abs() < 1e-9);
            }
        }
    }
}

/// Messages between threads instead of MPI: the ranks share nothing but messages.
#[test]
fn the_ranks_of_a_job_follow_rank_0() {
    use tercio_parallel::comm::threads;

    const RANKS: usize = 3;
    let (mut machine, costs, models) = small();
    machine.mpi = machine.network.clone();
    let machine = machine.over_mpi().unwrap();
    let how = [(RANKS, Organisation::SortFirst), (RANKS, Organisation::SortLast)];
    let options = Options { views: 2, frames: 2, rounds: 2, processors: 2, clock: Clock::Wall };
    let table = Table { models: &models, sizes: &[(99, 77), (64, 80)], how: &how, options };
    let all = threads::run(RANKS, |comm| {
        if comm.rank() > 0 {
            return follow(comm, table).map(|()| Vec::new());
        }
        let draw = |scene: &Scene, camera: &Camera, sharing: &Sharing, frames| {
            MeasuredRanks::draw_between(comm, scene, camera, sharing, frames)
        };
        compare(&machine, &costs, table, draw, || ()).map_err(|e| match e {
            RanksError::Parallel(error) => error,
            RanksError::Predict(error) => panic!("{error}"),
        })
    });
    let mut all = all.unwrap();
    let rows = all.remove(0);
    assert!(rows.len() == 4 && all.iter().all(Vec::is_empty));
    let alone = compare(&machine, &costs, table, MeasuredRanks::draw, || ()).unwrap();
    for (row, alone) in rows.iter().zip(&alone) {
        assert_eq!((row.differing.len(), row.compared), (0, 2 * 4 * 28 * RANKS), "{row:?}");
        assert!(row.measured.frame.is_finite() && row.measured.frame > 0.0);
        assert_eq!((row.messages, row.bytes, row.predicted), (alone.messages, alone.bytes, alone.predicted));
    }
}
