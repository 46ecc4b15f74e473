//! A frame like the one before allocates no memory for messages.

use std::sync::Arc;
use std::time::Duration;

use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::comm::threads::{ThreadComm, run};
use tercio_parallel::comm::{CommError, Traffic};
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{Communicator, Organisation};
use tercio_raster::{Frame, Settings};
use tercio_scene::{Camera, Projection, Scene};

/// Counts all messages, and those for which there was no memory to reuse.
struct Watched<'a> {
    inner: &'a mut ThreadComm,
    fresh: usize,
    sent: usize,
}

impl Communicator for Watched<'_> {
    fn rank(&self) -> usize {
        self.inner.rank()
    }
    fn size(&self) -> usize {
        self.inner.size()
    }
    fn send(&mut self, to: usize, message: Vec<u8>) -> Result<(), CommError> {
        self.sent += 1;
        self.inner.send(to, message)
    }
    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        self.inner.receive(from)
    }
    fn receive_within(&mut self, from: usize, time: Duration) -> Result<Option<Vec<u8>>, CommError> {
        self.inner.receive_within(from, time)
    }
    fn buffer(&mut self, to: usize) -> Vec<u8> {
        let buffer = self.inner.buffer(to);
        self.fresh += usize::from(buffer.capacity() == 0);
        buffer
    }
    fn give_back(&mut self, from: usize, message: Vec<u8>) {
        self.inner.give_back(from, message);
    }
    fn traffic(&self) -> Traffic {
        self.inner.traffic()
    }
    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.inner.signal(to)
    }
    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.inner.await_signal(from)
    }
}

#[test]
fn memory_is_allocated_for_the_messages_of_one_frame_only() {
    let mesh = builtin::make("builtin:gyroid@4k").expect("a model");
    let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    let bounds = scene.bounds();
    let camera = Camera {
        eye: bounds.center() + glam::DVec3::new(0.3, 0.4, 0.9) * bounds.radius() * 2.6,
        target: bounds.center(),
        up: glam::DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.8 },
        near: None,
        shift: [0.0; 2],
    };
    let settings = Settings { tile_size: Some(16), ..Settings::one_sample(160, 120) };
    for organisation in [
        Organisation::SortFirst,
        Organisation::SortMiddle,
        Organisation::SortLast,
        Organisation::SortTwice { group: 2 },
    ] {
        let task = Task { sharing: organisation.into(), scene: &scene, camera: &camera, settings: &settings };
        const FRAMES: usize = 10;
        let counted = run(3, |comm| {
            let (mut own, mut frame) = (Rank::new(), Frame::default());
            let mut watched = Watched { inner: comm, fresh: 0, sent: 0 };
            for _ in 0..FRAMES {
                own.draw_into(&mut watched, &task, &mut frame)?;
                // After this all messages have been read.
                watched.barrier()?;
            }
            Ok((watched.fresh, watched.sent))
        });
        for (rank, (fresh, sent)) in counted.expect("frames").into_iter().enumerate() {
            assert!(sent.is_multiple_of(FRAMES), "{organisation:?}, rank {rank}: {sent} messages");
            assert!(fresh <= sent / FRAMES, "{organisation:?}, rank {rank}: {fresh} of {sent} messages");
            assert!(fresh > 0 || sent == 0, "{organisation:?}, rank {rank}: memory from nowhere");
        }
    }
}
