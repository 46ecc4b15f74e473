//! Clusters that ranks have since the last frame are not sent again.

use std::collections::BTreeSet;
use std::sync::Arc;

use tercio_parallel::between_processes::draw_frame;
use tercio_parallel::comm::{Communicator, threads};
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{Division, FrameReport, Organisation, ParallelError, Sharing};
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::{Frame, Outputs, Renderer, SamplePattern, Settings};
use tercio_scene::{Camera, Scene};

use crate::model::{camera, in_parts, model, split_evenly, twice, whole};
use crate::{ONE, settings};

/// A frame: how far away the camera is, in radii; how ranks share it, and with which settings.
type Of = (f64, Sharing, Settings);

/// What a rank returns of a frame: the picture and the report of rank 0, and what `look` found.
type Drawn<T> = (Option<(Frame, FrameReport)>, T);

/// Draws frames with the same ranks, and holds them against those of one renderer. `change` gets the number of the frame and the scene
/// before the frame is drawn (that of each rank's parts, and the whole one), `look` the rank, the scene and the camera.
fn draw<T: Send>(
    ranks: usize,
    frames: &[Of],
    change: impl Fn(usize, &mut Scene) + Sync,
    look: impl Fn(usize, &Scene, &Camera, &Settings) -> T + Sync,
) -> Vec<(FrameReport, Vec<T>)> {
    let mesh = model("builtin:gyroid@2k", 100);
    let parts = split_evenly(&mesh, ranks);
    let mut scene = whole(&mesh, twice);
    let bounds = scene.bounds();
    let camera_of = |radii: f64| camera(&bounds, radii);
    let results = threads::run(ranks, |comm| {
        let mut scene = in_parts(comm, &parts, twice)?;
        let mut own = Rank::new();
        let frame = |(number, (radii, sharing, settings)): (usize, &Of)| -> Result<Drawn<T>, ParallelError> {
            change(number, &mut scene);
            let (camera, mut frame) = (camera_of(*radii), Frame::default());
            let task = Task { sharing: *sharing, scene: &scene, camera: &camera, settings };
            let report = draw_frame(&mut own, comm, &task, &mut frame)?;
            Ok((report.map(|report| (frame, report)), look(comm.rank(), &scene, &camera, settings)))
        };
        frames.iter().enumerate().map(frame).collect::<Result<Vec<_>, _>>()
    });
    let mut of_ranks: Vec<_> =
        results.expect("pictures").into_iter().map(|frames| frames.into_iter()).collect();
    let mut of_frame = |(number, (radii, sharing, settings)): (usize, &Of)| {
        change(number, &mut scene);
        let all: Vec<Drawn<T>> = of_ranks.iter_mut().filter_map(Iterator::next).collect();
        let (mut pictures, looks): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        let (found, report) = pictures[0].take().expect("rank 0 has the picture");
        let expected = Renderer::new().render(&scene, &camera_of(*radii), settings).expect("a picture");
        assert_eq!(found.difference(&expected), None, "{ranks} ranks, {sharing:?}, {radii} radii");
        (report, looks)
    };
    frames.iter().enumerate().map(&mut of_frame).collect()
}

#[test]
fn an_instance_that_comes_back_is_sent_again() {
    let sharing = Sharing { division: Division::Interleaved, ..Organisation::SortFirst.into() };
    let frames = [2.0; 4].map(|radii| (radii, sharing, settings(ONE)));
    let change = |number: usize, scene: &mut Scene| match number {
        1 => scene.instances.truncate(1),
        2 => twice(scene),
        _ => {}
    };
    let drawn = draw(3, &frames, change, |_, _, _, _| ());
    let sent = |frame: usize| drawn[frame].0.ranks.iter().filter_map(|rank| rank.clusters_sent).sum::<u64>();
    assert!(sent(0) > sent(2) && sent(2) > 0, "{} and {}", sent(0), sent(2));
    assert_eq!([sent(1), sent(3)], [0, 0]);
}

/// Which clusters of a rank's scene each of so many ranks needs, if tile k belongs to rank k modulo their number.
fn needed(ranks: usize, scene: &Scene, camera: &Camera, settings: &Settings) -> Vec<BTreeSet<u32>> {
    let context = FrameContext::new(scene, camera, settings, 1).expect("a frame");
    let mut sorted = Sorted::default();
    Renderer::new().sort(&context, &mut sorted);
    let tiles = |rank: usize| {
        (0..context.grid.count() as u32).filter(|&tile| tile as usize % ranks == rank).collect::<Vec<_>>()
    };
    (0..ranks).map(|rank| sorted.clusters_in(&tiles(rank)).into_iter().collect()).collect()
}

#[test]
fn only_what_a_rank_has_not_is_sent() {
    let sharing = Sharing { division: Division::Interleaved, ..Organisation::SortFirst.into() };
    // There, nearer, nearer still, and back.
    let frames = [2.0, 2.0, 1.9, 0.6, 2.0].map(|radii| (radii, sharing, settings(ONE)));
    for ranks in [2, 5] {
        let look = |_: usize, scene: &Scene, camera: &Camera, settings: &Settings| {
            needed(ranks, scene, camera, settings)
        };
        let drawn = draw(ranks, &frames, |_, _| (), look);
        let (mut all_sent, mut all_kept) = (0, 0);
        for (number, (report, needs)) in drawn.iter().enumerate() {
            for (rank, of_rank) in report.ranks.iter().enumerate() {
                let (mut sent, mut kept, mut bits) = (0, 0, 0);
                for to in (0..ranks).filter(|&to| to != rank) {
                    let nothing = BTreeSet::new();
                    let had = number.checked_sub(1).map_or(&nothing, |last| &drawn[last].1[rank][to]);
                    let needs = &needs[rank][to];
                    sent += needs.difference(had).count() as u64;
                    kept += needs.intersection(had).count() as u64;
                    // Of each of the two instances, whose clusters have numbers behind each other.
                    let half = of_rank.clusters as u32 / 2;
                    let first = had.range(..half).count();
                    bits += 2 * 16 + first.div_ceil(8) + (had.len() - first).div_ceil(8);
                }
                let found = (of_rank.clusters_sent, of_rank.clusters_kept);
                assert_eq!(found, (Some(sent), Some(kept)), "{ranks} ranks, frame {number}, rank {rank}");
                let bytes = of_rank.cluster_bytes.expect("clusters are sent");
                assert_eq!(bytes > bits as u64, sent > 0, "frame {number}, rank {rank}: {bytes}, {bits}");
                assert!(number != 1 || (sent, bytes) == (0, bits as u64), "the same frame: {sent}, {bytes}");
                all_sent += if number == 2 { sent } else { 0 };
                all_kept += if number == 2 { kept } else { 0 };
            }
        }
        assert!(0 < all_sent && all_sent < all_kept, "{ranks} ranks: {all_sent} sent, {all_kept} kept");
    }
}

/// Every cluster that is needed, or none?
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sent {
    All,
    Some,
    None,
}

#[test]
fn ranks_forget_what_is_of_no_use() {
    let first = Sharing::from(Organisation::SortFirst);
    let (last, of_three) =
        (Sharing::from(Organisation::SortLast), Sharing::from(Organisation::SortTwice { group: 3 }));
    let adaptive = Sharing { division: Division::Adaptive, ..first };
    let with_ids = settings(SamplePattern::Sparse4);
    let without = Settings { outputs: Outputs::default(), ..with_ids.clone() };
    let frames: Vec<(f64, Sharing, &Settings, Sent)> = vec![
        (2.0, first, &with_ids, Sent::All),
        (2.0, first, &with_ids, Sent::None),
        // Without numbers of faces.
        (2.0, first, &without, Sent::All),
        (2.0, adaptive, &without, Sent::Some),
        (1.9, adaptive, &without, Sent::Some),
        // Other groups; the last rank of four is alone in its group.
        (2.0, of_three, &without, Sent::All),
        (2.0, of_three, &without, Sent::None),
        (2.0, first, &without, Sent::All),
        (2.0, last, &without, Sent::None),
        (2.0, first, &without, Sent::All),
        // Another mesh, with the same content.
        (2.0, first, &without, Sent::All),
        (2.0, first, &without, Sent::None),
    ];
    let of: Vec<Of> = frames.iter().map(|&(radii, sharing, s, _)| (radii, sharing, s.clone())).collect();
    let change = |number: usize, scene: &mut Scene| {
        if number == 10 {
            let mesh = Arc::new((*scene.instances[0].mesh).clone());
            scene.instances.iter_mut().for_each(|instance| instance.mesh = mesh.clone());
        }
    };
    let drawn = draw(4, &of, change, |_, _, _, _| ());
    for (number, ((report, _), (.., expected))) in drawn.iter().zip(&frames).enumerate() {
        let sum = |of: fn(&tercio_parallel::RankReport) -> Option<u64>| {
            report.ranks.iter().filter_map(of).sum::<u64>()
        };
        let found = match (sum(|rank| rank.clusters_sent), sum(|rank| rank.clusters_kept)) {
            (0, _) => Sent::None,
            (_, 0) => Sent::All,
            _ => Sent::Some,
        };
        assert_eq!(found, *expected, "frame {number}");
    }
}
