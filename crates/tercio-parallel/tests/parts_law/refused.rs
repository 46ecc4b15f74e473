//! Parts that do not belong together, and messages that are damaged, are errors.

use std::sync::Arc;
use std::time::Duration;

use tercio_mesh::{ClusteredMesh, FileMaterial, Mesh};
use tercio_parallel::comm::threads::{self, ThreadComm};
use tercio_parallel::comm::{CommError, Communicator, Traffic};
use tercio_parallel::organisation::envelope::TRAILER;
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{Organisation, ParallelError, PartsError, Ranks, in_process, parts};
use tercio_raster::Frame;
use tercio_scene::{Scene, Share, SurfaceEdges};

use crate::model::{camera, in_parts, model, split_evenly, twice, whole};
use crate::{ONE, settings};

/// The error of ranks with these parts.
fn error_of(parts: &[(ClusteredMesh, u64)]) -> ParallelError {
    let numbered = threads::run(parts.len(), |comm| {
        let (mut mesh, faces) = parts[comm.rank()].clone();
        parts::number(comm, &mut mesh, faces)
    });
    numbered.expect_err("no parts of one model")
}

#[test]
fn parts_of_different_models_are_refused() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let change = |change: fn(&mut Mesh)| {
        let mut changed = mesh.clone();
        change(&mut changed);
        let (own, other) = (split_evenly(&mesh, 3), split_evenly(&changed, 3));
        let parts = [own[0].clone(), own[1].clone(), other[2].clone()];
        error_of(&parts).to_string()
    };
    assert!(change(|mesh| mesh.origin.x += 1.0).contains("rank 2 has a part of a model with another origin"));
    assert!(change(|mesh| mesh.exponent += 1).contains("another unit"));
    assert!(change(|mesh| mesh.normals = None).contains("other normals"));
    assert!(change(|mesh| mesh.materials.push(FileMaterial::default())).contains("other materials"));
    let mut many = split_evenly(&mesh, 2);
    many[1].1 = u64::MAX;
    assert!(matches!(error_of(&many), ParallelError::Parts(PartsError::TooLarge { .. })));
}

#[test]
fn parts_that_do_not_make_a_model_are_refused() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let parts = split_evenly(&mesh, 2);
    let camera = camera(&whole(&mesh, |_| ()).bounds(), 2.0);
    let settings = settings(ONE);
    let error = |change: fn(usize, &mut Scene)| {
        let drawn = threads::run(2, |comm| {
            let mut scene = in_parts(comm, &parts, twice)?;
            change(comm.rank(), &mut scene);
            let sharing = Organisation::SortLast.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            Rank::new().draw_into(comm, &task, &mut Frame::default())
        });
        match drawn.expect_err("no model") {
            ParallelError::Parts(error) => error,
            error => panic!("{error}"),
        }
    };
    assert_eq!(error(|_, scene| scene.instances[1].share = None), PartsError::Whole { instance: 1 });
    let late = |rank: usize, scene: &mut Scene| {
        let share = &mut scene.instances[1].share;
        *share = share.map(|share| Share { first_triangle: share.first_triangle + rank as u64, ..share });
    };
    assert!(matches!(error(late), PartsError::Share { instance: 1, rank: 1, .. }));
    let edges = |_, scene: &mut Scene| {
        let sides = vec![SurfaceEdges::ALL; scene.instances[1].mesh.triangle_count()];
        scene.instances[1].edges = Some(Arc::new(SurfaceEdges::new([0; 3], 1.0, Some(sides))));
    };
    assert_eq!(error(edges), PartsError::Edges { instance: 1 });
    let translucent =
        |rank: usize, scene: &mut Scene| scene.instances[0].surface.opacity -= rank as f32 * 0.5;
    assert_eq!(error(translucent), PartsError::Translucency { instance: 0, rank: 1 });

    // One part on all ranks of a process, or alone.
    let scenes = threads::run(2, |comm| in_parts(comm, &parts, |_| ())).expect("scenes");
    for (rank, count) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
        let ranks = Ranks { count, threads: 1, sharing: Organisation::SortLast.into() };
        let drawn = in_process::draw(ranks, &scenes[rank], &camera, &settings);
        assert!(matches!(drawn, Err(ParallelError::Parts(PartsError::Share { .. }))), "{rank} of {count}");
    }
}

/// Changes the messages between ranks 1 and 2.
struct Damaging<'a, F> {
    comm: &'a mut ThreadComm,
    damage: F,
}

impl<F: Fn(&mut Vec<u8>)> Communicator for Damaging<'_, F> {
    fn rank(&self) -> usize {
        self.comm.rank()
    }
    fn size(&self) -> usize {
        self.comm.size()
    }
    fn send(&mut self, to: usize, mut message: Vec<u8>) -> Result<(), CommError> {
        // Clusters are by far the longest messages.
        if self.rank() == 1 && to == 2 && message.len() > 1000 {
            // What the message is stays at its end.
            let trailer = message.split_off(message.len() - TRAILER);
            (self.damage)(&mut message);
            message.extend(trailer);
        }
        self.comm.send(to, message)
    }
    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        self.comm.receive(from)
    }
    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        self.comm.receive_within(from, time)
    }
    fn traffic(&self) -> Traffic {
        self.comm.traffic()
    }
    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.comm.signal(to)
    }
    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.comm.await_signal(from)
    }
}

#[test]
fn damaged_messages_are_errors() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let parts = split_evenly(&mesh, 3);
    let camera = camera(&whole(&mesh, |_| ()).bounds(), 2.0);
    let settings = settings(ONE);
    let draw = |damage: &(dyn Fn(&mut Vec<u8>) + Sync)| {
        threads::run(3, |comm| {
            let scene = in_parts(comm, &parts, |_| ())?;
            let sharing = Organisation::SortMiddle.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            let comm = &mut Damaging { comm, damage };
            Rank::new().draw_into(comm, &task, &mut Frame::default())
        })
    };
    let length = std::sync::atomic::AtomicUsize::new(0);
    let note = |message: &mut Vec<u8>| length.store(message.len(), std::sync::atomic::Ordering::SeqCst);
    draw(&note).expect("a picture");
    let length = length.into_inner();
    assert!(length > 1000, "clusters are sent");
    let mut errors = 0;
    for at in (0..length).step_by(length / 60) {
        let shorter = draw(&|message: &mut Vec<u8>| message.truncate(at)).expect_err("a shorter message");
        let other = draw(&|message: &mut Vec<u8>| message[at] ^= 0xff);
        for error in [Some(shorter), other.err()].into_iter().flatten() {
            errors += 1;
            let is_expected = matches!(
                error,
                ParallelError::Clusters { from: 1, .. }
                    | ParallelError::Comm(CommError::Transport { rank: 1, .. })
            );
            assert!(is_expected, "byte {at}: {error}");
        }
    }
    assert!(errors > 70, "{errors}");
    let longer = draw(&|message: &mut Vec<u8>| message.push(0)).expect_err("a longer message");
    assert!(longer.to_string().contains("not clusters of 1 instances"), "{longer}");
}
