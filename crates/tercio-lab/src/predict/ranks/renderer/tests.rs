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
    let settings = Settings { tile_size: Some(16), ..Settings::new(size.0, size.1) };
    RanksWork::count(&scene, &camera, &settings, (ranks, organisation)).unwrap()
}

#[test]
fn one_rank_draws_as_one_thread_and_makes_keys() {
    let machine = builtin("two-core-2026").unwrap().unwrap();
    for organisation in [Organisation::SortFirst, Organisation::SortLast] {
        let work = work(1, organisation);
        let frame = predict(&machine, &COSTS, &work, 2).unwrap();
        let exchange = Exchange::new(&work.sharing, &work.messages, &work.drawing, (1, f64::INFINITY));
        let more = COSTS.seconds(&exchange.keys(0)) + COSTS.seconds(&exchange.finishing(0));
        let alone = FrameTime::on_one_thread(&machine, &work.drawing[0]).total();
        assert!((frame.total() - alone - more).abs() < 1e-9, "{} {alone} {more}", frame.total());
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
            // No faster than all processors with nothing to wait for.
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
        let network = machine.network.as_mut().unwrap();
        network.hop.value = latency;
        network.bandwidth.value = bandwidth;
        let frame = predict(&machine, &COSTS, &work, 4).unwrap();
        assert!(frame.by_network);
        frame.total()
    };
    let fast = seconds(0.0, 1e15);
    // Composing waits once for the way through the network, collecting again; a fat tree of four has up to 4 hops.
    assert!(seconds(1e-3, 1e15) >= fast + 4e-3, "{} {fast}", seconds(1e-3, 1e15));
    // What the owners send to rank 0 passes its port.
    let (_, bytes) = work.messages.total();
    let collected: u64 = work.messages.finished[1..].iter().map(|p| p.bytes(false)).sum();
    let slow = seconds(0.0, 1e6);
    assert!(slow >= collected as f64 / 1e6 && slow < fast + 2.0 * bytes as f64 / 1e6, "{slow}");

    let mut shared = builtin("two-core-2026").unwrap().unwrap();
    let before = predict(&shared, &COSTS, &work, 4).unwrap();
    shared.network.as_mut().unwrap().bandwidth.value = 1.0;
    assert!(!before.by_network);
    assert_eq!(predict(&shared, &COSTS, &work, 4).unwrap(), before);
}

#[test]
fn a_ring_is_as_slow_as_its_busiest_link() {
    let mut machine = builtin("cluster-64").unwrap().unwrap();
    let work = work(7, Organisation::SortLast);
    let network = machine.network.as_mut().unwrap();
    network.bandwidth.value = 1e6;
    let tree = predict(&machine, &COSTS, &work, 7).unwrap().total();
    machine.network.as_mut().unwrap().topology = crate::machines::Topology::Ring;
    let ring = predict(&machine, &COSTS, &work, 7).unwrap().total();
    assert!(ring > tree, "{ring} {tree}");
}
