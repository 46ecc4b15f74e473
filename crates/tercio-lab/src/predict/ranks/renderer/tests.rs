use std::sync::Arc;

use tercio_mesh::cluster::{PartitionOptions, partition};

use super::super::exchange::KINDS;
use super::*;
use crate::machines::builtin;
use crate::predict::views;

const COSTS: ExchangeCosts = ExchangeCosts([1e-9; KINDS]);

fn work(ranks: usize, organisation: Organisation) -> RanksWork {
    let mesh = tercio_mesh::builtin::make("builtin:gyroid@6k").unwrap();
    let bounds = mesh.bounds();
    let scene = views::scene(Arc::new(partition(mesh, &PartitionOptions::default())));
    let size = (200, 150);
    let camera = views::camera(&bounds, size, 1, 7);
    let settings = Settings { tile_size: Some(16), ..Settings::one_sample(size.0, size.1) };
    RanksWork::count(&scene, &camera, &settings, (ranks, organisation.into())).unwrap()
}

#[test]
fn one_rank_draws_as_one_thread() {
    let machine = builtin("two-core-2026").unwrap().unwrap();
    for organisation in [Organisation::SortFirst, Organisation::SortLast] {
        let work = work(1, organisation);
        let frame = predict(&machine, &COSTS, &work, 2).unwrap();
        let alone = FrameTime::on_one_thread(&machine, &work.drawing[0]).total();
        assert!((frame.total() - alone).abs() < 1e-9, "{} {alone}", frame.total());
        assert_eq!((frame.messages, frame.bytes), (0, 0));
    }
}

#[test]
fn phases_of_rank_0_make_up_the_frame() {
    let machine = builtin("two-core-2026").unwrap().unwrap();
    for organisation in [Organisation::SortFirst, Organisation::SortLast] {
        for (ranks, processors) in [(2, 2), (4, 2), (7, 1)] {
            let frame = predict(&machine, &COSTS, &work(ranks, organisation), processors).unwrap();
            let sum: f64 = frame.phases().iter().map(|p| p.1).sum();
            assert!((sum / frame.total() - 1.0).abs() < 1e-9, "{frame:?}");
            // No faster than all processors working without pauses.
            let all: f64 = frame.ranks.iter().map(RankSeconds::busy).sum();
            assert!(frame.total() >= all / processors as f64 * 0.999, "{frame:?}");
        }
    }
}

#[test]
fn processors_that_ranks_share_make_frames_longer() {
    let machine = builtin("two-core-2026").unwrap().unwrap();
    let work = work(4, Organisation::SortLast);
    let [one, two, four] = [1, 2, 4].map(|p| predict(&machine, &COSTS, &work, p).unwrap().total());
    assert!(one > 1.5 * two && two > 1.3 * four, "{one} {two} {four}");
}

#[test]
fn a_network_takes_time_and_one_memory_takes_none() {
    let cluster = builtin("cluster-64").unwrap().unwrap();
    let work = work(4, Organisation::SortLast);
    let seconds = |latency: f64, bandwidth: f64| {
        let mut machine = cluster.clone();
        // Every rank is a node.
        machine.processors.per_node.as_mut().unwrap().value = 1.0;
        let network = machine.network.as_mut().unwrap();
        network.hop.value = latency;
        network.bandwidth.value = bandwidth;
        let frame = predict(&machine, &COSTS, &work, 4).unwrap();
        assert_eq!(frame.carrier, Carrier::Network);
        frame.total()
    };
    let fast = seconds(0.0, 1e15);
    // Compositing waits for the latency of the network once, collecting again; a fat tree of four has paths of up to 4
    // hops.
    assert!(seconds(1e-3, 1e15) >= fast + 4e-3, "{} {fast}", seconds(1e-3, 1e15));
    // Everything that the owners send to rank 0 passes its port.
    let (_, bytes) = work.messages.total();
    let collected: u64 = work.messages.finished[1..].iter().map(|f| f.sent().bytes()).sum();
    let slow = seconds(0.0, 1e6);
    assert!(slow >= collected as f64 / 1e6 && slow < fast + 2.0 * bytes as f64 / 1e6, "{slow}");

    let mut shared = builtin("two-core-2026").unwrap().unwrap();
    let before = predict(&shared, &COSTS, &work, 4).unwrap();
    shared.network.as_mut().unwrap().bandwidth.value = 1.0;
    assert_eq!(before.carrier, Carrier::Threads);
    assert_eq!(predict(&shared, &COSTS, &work, 4).unwrap(), before);
}

#[test]
fn processes_copy_what_they_receive() {
    let mut machine = builtin("two-core-2026").unwrap().unwrap();
    let work = work(4, Organisation::SortLast);
    let threads = predict(&machine, &COSTS, &work, 4).unwrap();
    machine.mpi = machine.network.clone();
    let mut over_mpi = |bandwidth: f64| {
        machine.mpi.as_mut().unwrap().bandwidth.value = bandwidth;
        let frame = predict(&machine.clone().over_mpi().unwrap(), &COSTS, &work, 4).unwrap();
        assert_eq!(frame.carrier, Carrier::Processes);
        frame
    };
    let slow = over_mpi(1e9);
    for (rank, (slow, threads)) in slow.ranks.iter().zip(&threads.ranks).enumerate() {
        let copying = work.messages.bytes_taken(rank) as f64 / 1e9;
        assert!((slow.message - threads.message - copying).abs() < 1e-12, "{rank}: {slow:?} {threads:?}");
    }
    let taken: u64 = (0..4).map(|rank| work.messages.bytes_taken(rank)).sum();
    assert_eq!(taken, work.messages.total().1);
    assert!(slow.total() > threads.total() && slow.memory.messages > threads.memory.messages);
    // Free copying makes no difference.
    assert!((over_mpi(1e18).total() / threads.total() - 1.0).abs() < 1e-6);
}

#[test]
fn a_ring_is_as_slow_as_its_busiest_link() {
    const RANKS: usize = 24;
    let mut machine = builtin("cluster-64").unwrap().unwrap();
    let mut work = work(RANKS, Organisation::SortLast);
    // All ranks send each other the same.
    let pixels = |from, to| {
        (from != to).then_some(super::super::traffic::Pixels { pixels: 1000, ..Default::default() })
    };
    work.messages.composed = (0..RANKS).map(|from| (0..RANKS).map(|to| pixels(from, to)).collect()).collect();
    work.messages.finished.fill(super::super::traffic::Finished::default());
    work.messages.gathered = (0, 0);
    let mut seconds_of_a_byte = |topology| {
        machine.processors.per_node.as_mut().unwrap().value = 1.0;
        1.0 / on_network(&NetworkModel::of(&machine, Some(topology)).unwrap(), &work, 0.0).bandwidth
    };
    let crossbar = seconds_of_a_byte(Topology::Crossbar);
    let ring = seconds_of_a_byte(Topology::Ring);
    // A port passes 23 messages. Paths of 1 to 12 links, 144 together per rank, use two links per rank: 72 messages
    // each, or up to 78 if all messages to the opposite rank go in the same direction.
    assert!((72.0 / 23.0 - 1e-9..=78.0 / 23.0 + 1e-9).contains(&(ring / crossbar)), "{ring} {crossbar}");
}
