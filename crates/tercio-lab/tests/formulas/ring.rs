//! Sort-twice and the serial ring of document 000, chapter 6: pixels and messages of the renderer's ranks against equation 6.2.

use std::sync::Arc;

use tercio_lab::models::eldridge::sort_twice::composite_passes;
use tercio_lab::simulators::ring::compositing;
use tercio_lab::units::{Pixels, Processors};
use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::comm::Kind;
use tercio_parallel::in_process::draw;
use tercio_parallel::{Composition, Encoding, Organisation, RankReport, Ranks, Sharing};
use tercio_raster::Settings;
use tercio_scene::{Framing, Scene};

const SIZE: (u32, u32) = (96, 64);
const PIXELS: u64 = SIZE.0 as u64 * SIZE.1 as u64;

/// What the ranks sent each other to be composited: of all of them pixels, of each one messages and bytes.
fn composited(count: usize, group: usize, composition: Composition) -> (u64, Vec<(u64, u64)>) {
    let mesh = builtin::make("builtin:teapot@2k").expect("a model");
    let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    let settings = Settings { tile_size: Some(8), ..Settings::one_sample(SIZE.0, SIZE.1) };
    let camera = Framing::default().camera_for_scene(&scene);
    let encoding = Encoding::Dense;
    let sharing = Sharing { composition, encoding, ..Organisation::SortTwice { group }.into() };
    let (_, report) =
        draw(Ranks { count, threads: 1, sharing }, &scene, &camera, &settings).expect("a picture");
    let of_rank = |rank: &RankReport| {
        let pixels = rank.partners.iter().filter(|with| with.kind == Kind::Pixels);
        pixels.fold((0, 0), |sum, with| (sum.0 + with.traffic.sent_messages, sum.1 + with.traffic.sent_bytes))
    };
    (report.ranks.iter().map(|rank| rank.pixels.sent).sum(), report.ranks.iter().map(of_rank).collect())
}

/// Equation 6.2 gives the passes, in each of which every processor passes a pixel on. The pictures of the document's machine are
/// dense, its groups equal.
#[test]
fn ranks_send_the_pixels_of_equation_6_2() {
    let check = |count: usize, group: usize, composition: Composition| {
        let [n, g] = [count, group].map(|count| Processors::new(count as f64));
        let passes = composite_passes(Pixels::new(PIXELS as f64), g, n).get();
        let by_formula = (passes * count as f64).round() as u64;
        if PIXELS.is_multiple_of(count as u64) {
            assert_eq!(by_formula, count as u64 * compositing::passes(count as u32, group as u32, PIXELS));
        }
        let (pixels, _) = composited(count, group, composition);
        assert_eq!(pixels, by_formula, "{composition}, {count} ranks in groups of {group}");
    };
    // Sort-last: with every strategy.
    for count in [2, 3, 8, 12, 15] {
        Composition::ALL.into_iter().for_each(|composition| check(count, 1, composition));
    }
    // In groups the others pass tiles on through ranks that have other tiles, too.
    for (count, group) in [(8, 2), (8, 4), (8, 8), (12, 3), (12, 4), (15, 5), (16, 2), (24, 6)] {
        check(count, group, Composition::DirectSend);
    }
}

/// Along the ring all ranks but the last pass on what they have, once: 12 bytes for each pixel, 6 for each of the 8 rows of a tile, 12
/// for the tile, and 16 for the message.
#[test]
fn the_ring_sends_one_message_of_a_whole_picture() {
    for count in [2, 5, 8, 13] {
        let (_, of_rank) = composited(count, 1, Composition::Ring);
        let picture = 12 * PIXELS + (8 * 6 + 12) * (PIXELS / 64) + 16;
        let mut expected = vec![(1, picture); count];
        expected[0] = (0, 0);
        assert_eq!(of_rank, expected, "{count} ranks");
    }
}
