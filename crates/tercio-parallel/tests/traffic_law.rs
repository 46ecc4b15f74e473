//! Messages and bytes of whole frames, against a count of the pixels that travel. The count knows the formats (a trailer of 16
//! bytes, spans of 6 bytes, 4 for a colour, 8 for a key, 12 for a tile), but shares no code with what writes them: pixels are
//! counted in pictures that a renderer has drawn alone.

use std::collections::HashMap;
use std::sync::Arc;

use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::comm::Kind;
use tercio_parallel::composite::{Shared, Touched};
use tercio_parallel::in_process::draw;
use tercio_parallel::{Composition, Division, Encoding, FrameReport, Organisation, Ranks, Sharing};
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::{ClusterSet, Frame, Outputs, Part, Renderer, Settings};
use tercio_scene::{Background, Camera, Projection, Scene};

const TRAILER: u64 = 16;
const SIZE: (u32, u32) = (150, 110);
const EDGE: u32 = 16;

fn made(model: &str) -> (Scene, Camera) {
    let mesh = builtin::make(model).expect("a model");
    let mut scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    // No surface has this colour.
    scene.background = Background::Solid([0.0, 1.0, 0.0, 1.0]);
    let bounds = scene.bounds();
    let camera = Camera {
        eye: bounds.center() + glam::DVec3::new(0.3, 0.4, 0.9) * bounds.radius() * 2.6,
        target: bounds.center(),
        up: glam::DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.8 },
        near: None,
        shift: [0.0; 2],
    };
    (scene, camera)
}

fn settings() -> Settings {
    Settings { tile_size: Some(EDGE), ..Settings::one_sample(SIZE.0, SIZE.1) }
}

const ACROSS: u32 = SIZE.0.div_ceil(EDGE);
/// Up to so many ranks send each other bins without content, too.
const FEW: usize = 8;
const TILES: usize = (ACROSS * SIZE.1.div_ceil(EDGE)) as usize;

/// Pixels of a tile, row by row: which of them are to be sent.
type Pixels = Vec<Vec<bool>>;

/// The pixels of a tile for which something holds.
fn pixels(tile: u32, holds: impl Fn(usize) -> bool) -> Pixels {
    let (x0, y0) = (tile % ACROSS * EDGE, tile / ACROSS * EDGE);
    let row = |y: u32| (x0..(x0 + EDGE).min(SIZE.0)).map(|x| holds((y * SIZE.0 + x) as usize)).collect();
    (y0..(y0 + EDGE).min(SIZE.1)).map(row).collect()
}

/// Bytes of pixels with so many bytes each.
fn bytes(pixels: &Pixels, of_pixel: u64) -> u64 {
    let of_row = |row: &Vec<bool>| {
        let starts = (0..row.len()).filter(|&x| row[x] && (x == 0 || !row[x - 1])).count() as u64;
        6 * starts + of_pixel * row.iter().filter(|&&sent| sent).count() as u64
    };
    pixels.iter().map(of_row).sum()
}

/// Parts of tiles.
type Message = Vec<(u32, Pixels)>;

/// Messages and bytes that each rank sends.
type Sent = Vec<(u64, u64)>;

fn sent(report: &FrameReport) -> Sent {
    report.ranks.iter().map(|rank| (rank.traffic.sent_messages, rank.traffic.sent_bytes)).collect()
}

/// What a renderer alone draws with some of the clusters, and the tiles in which its front end finds something.
fn drawn(scene: &Scene, camera: &Camera, clusters: ClusterSet, settings: &Settings) -> (Frame, Vec<bool>) {
    let outputs = Outputs { keys: true, ..settings.outputs };
    let settings = Settings { clusters, outputs, ..settings.clone() };
    let frame = Renderer::new().render(scene, camera, &settings).expect("a picture");
    let context = FrameContext::new(scene, camera, &settings, 1).expect("a context");
    let mut sorted = Sorted::default();
    Renderer::new().sort(&context, &mut sorted);
    let found = sorted.tiles_with_entries(&context.grid);
    (frame, (0..TILES as u32).map(|tile| found.contains(tile)).collect())
}

/// Is a pixel not the background?
fn is_shown(frame: &Frame, pixel: usize) -> bool {
    frame.planes.color[pixel] != [0, 255, 0, 255]
}

fn report(scene: &Scene, camera: &Camera, count: usize, sharing: Sharing) -> FrameReport {
    let (_, report) =
        draw(Ranks { count, threads: 1, sharing }, scene, camera, &settings()).expect("a picture");
    report
}

const MODELS: [&str; 3] = ["builtin:teapot@3k", "builtin:soup@500", "builtin:sphere@100"];

#[test]
fn sort_first_and_sort_middle_send_what_their_tiles_show() {
    for model in MODELS {
        let (scene, camera) = made(model);
        let (whole, _) = drawn(&scene, &camera, ClusterSet::ALL, &settings());
        for count in [1, 2, 3, 7, 12, TILES + 2] {
            // Tile k belongs to rank k modulo the number of ranks.
            let mut finished: Sent = vec![(0, 0); count];
            for tile in 0..TILES as u32 {
                let owner = tile as usize % count;
                let (messages, sum) = &mut finished[owner];
                if owner > 0 {
                    *messages = 1;
                    *sum += bytes(&pixels(tile, |pixel| is_shown(&whole, pixel)), 4);
                }
            }
            finished.iter_mut().for_each(|(messages, sum)| *sum += *messages * TRAILER);
            let division = Division::Interleaved;
            let first = Sharing { division, ..Organisation::SortFirst.into() };
            assert_eq!(sent(&report(&scene, &camera, count, first)), finished, "{model}, {count} ranks");
            // The same after each has sent bins to each other; of many ranks only those that have some, after all know who has.
            let middle =
                report(&scene, &camera, count, Sharing { division, ..Organisation::SortMiddle.into() });
            let others = count as u64 - 1;
            let clusters = |number| Part { number, of: count as u32 }.range(scene.cluster_count() as u32);
            let of_rank = |number| drawn(&scene, &camera, clusters(number as u32).into(), &settings()).1;
            let found: Vec<Vec<bool>> = (0..count).map(of_rank).collect();
            let is_for =
                |from: usize, to: usize| (0..TILES).any(|tile| tile % count == to && found[from][tile]);
            let receivers =
                |from: usize| (0..count).filter(|&to| to != from && is_for(from, to)).count() as u64;
            // Messages of an exchange of a bit for each rank, in rounds of which each doubles what a rank knows.
            let (rounds, known) =
                (u64::from(count.next_power_of_two().ilog2()), others * count.div_ceil(64) as u64 * 8);
            let of_bins: Sent = (0..count)
                .map(|rank| match count > FEW {
                    true => (receivers(rank) + rounds, known),
                    false => (others, 0),
                })
                .collect();
            let with_bins = finished.iter().zip(&middle.ranks).zip(&of_bins).map(
                |(((messages, bytes), rank), (more, known))| {
                    (messages + more, bytes + rank.bin_bytes + known + more * TRAILER)
                },
            );
            assert_eq!(sent(&middle), with_bins.collect::<Vec<_>>(), "{model}, {count} ranks");
            let bins = middle.by_kind().into_iter().find(|of| of.0 == Kind::Bins).map(|of| of.1);
            let bins = bins.map_or((0, 0), |bins| (bins.sent_messages, bins.sent_bytes));
            let contents: u64 = middle.ranks.iter().map(|rank| rank.bin_bytes).sum();
            let (messages, known) = of_bins.iter().fold((0, 0), |sum, of| (sum.0 + of.0, sum.1 + of.1));
            assert_eq!(bins, (messages, contents + known + messages * TRAILER));
            assert!(count < TILES || messages < count as u64 * others, "some send nothing to each other");
        }
    }
}

/// What each rank sends for compositing, and what each has of the shared tiles in the end: the messages of the schedule are
/// played with the pixels that each rank has drawn. `size` is that of a part of a tile.
fn composited(
    composition: Composition,
    shared: &Shared,
    frames: &[Frame],
    size: impl Fn(&Pixels) -> u64,
) -> (Sent, Vec<HashMap<u32, Pixels>>) {
    let drawn_in = |rank: usize, tile: u32| pixels(tile, |pixel| frames[rank].planes.keys[pixel] != 0);
    let mut have: Vec<HashMap<u32, Pixels>> = vec![HashMap::new(); shared.ranks.len()];
    for (have, &rank) in have.iter_mut().zip(shared.ranks) {
        let own = shared.tiles_of(rank).into_iter().map(|tile| (tile, drawn_in(rank, tile)));
        have.extend(own.filter(|(_, pixels)| bytes(pixels, 12) > 0));
    }
    let mut sent: Sent = vec![(0, 0); frames.len()];
    let schedules: Vec<_> = (0..have.len()).map(|place| composition.rounds(shared, place)).collect();
    let mut transit: HashMap<(usize, usize), Vec<Message>> = HashMap::new();
    // Of each rank: rounds done, and whether it has sent what it sends in the next one.
    let mut at = vec![(0, false); have.len()];
    while at.iter().zip(&schedules).any(|(at, rounds)| at.0 < rounds.len()) {
        let before = at.clone();
        for place in 0..have.len() {
            let Some(round) = schedules[place].get(at[place].0) else { continue };
            if !at[place].1 {
                at[place].1 = true;
                for (to, tiles) in &round.sends {
                    let parts: Vec<_> =
                        tiles.iter().filter_map(|tile| have[place].remove_entry(tile)).collect();
                    let (messages, sum) = &mut sent[shared.ranks[place]];
                    *messages += 1;
                    *sum += TRAILER + parts.iter().map(|(_, pixels)| size(pixels)).sum::<u64>();
                    transit.entry((place, *to)).or_default().push(parts);
                }
            }
            let has_come = |from: &usize| transit.get(&(*from, place)).is_some_and(|queue| !queue.is_empty());
            if round.receives.iter().all(has_come) {
                for from in &round.receives {
                    for (tile, theirs) in transit.get_mut(&(*from, place)).expect("it has come").remove(0) {
                        let own = have[place].entry(tile).or_insert_with(|| pixels(tile, |_| false));
                        let both = own.iter_mut().flatten().zip(theirs.into_iter().flatten());
                        both.for_each(|(own, theirs)| *own |= theirs);
                    }
                }
                at[place] = (at[place].0 + 1, false);
            }
        }
        assert_ne!(at, before, "{composition}: a deadlock");
    }
    (sent, have)
}

#[test]
fn sort_last_sends_what_each_composition_moves() {
    let mut with_pixels = 0;
    for model in MODELS {
        let (scene, camera) = made(model);
        for count in [2, 3, 5, 8] {
            let whole = settings();
            let context = FrameContext::new(&scene, &camera, &whole, 1).expect("a context");
            let sets = Renderer::divide_clusters(&context, count);
            let (frames, found): (Vec<_>, Vec<_>) =
                sets.into_iter().map(|clusters| drawn(&scene, &camera, clusters, &whole)).unzip();
            let touched = Touched::new(TILES, found.iter().map(|found| |tile: u32| found[tile as usize]));
            let ranks_of = |tile: u32| (0..count).filter(|&rank| found[rank][tile as usize]).count();
            let tiles: Vec<u32> = (0..TILES as u32).filter(|&tile| ranks_of(tile) > 1).collect();
            let ranks: Vec<usize> =
                (0..count).filter(|&rank| tiles.iter().any(|&tile| found[rank][tile as usize])).collect();
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            for composition in Composition::ALL.into_iter().chain([Composition::radix_k(2)]) {
                let size = |part: &Pixels| 12 + bytes(part, 12);
                let (mut expected, have) = composited(composition, &shared, &frames, size);
                with_pixels +=
                    expected.iter().filter(|(messages, bytes)| *bytes > messages * TRAILER).count();
                let owners = composition.owners(&shared);
                for (rank, (messages, sum)) in expected.iter_mut().enumerate() {
                    // One bit a tile, in words of 8 bytes, of all others, in as many messages as a tree has levels.
                    let levels = u64::from(count.next_power_of_two().trailing_zeros());
                    *messages += levels;
                    *sum += levels * TRAILER + (count as u64 - 1) * TILES.div_ceil(64) as u64 * 8;
                    let sole =
                        (0..TILES as u32).filter(|&tile| found[rank][tile as usize] && ranks_of(tile) == 1);
                    let sole: Vec<u32> = sole.collect();
                    let place = ranks.iter().position(|&of| of == rank);
                    let owns = place.is_some_and(|place| owners.contains(&place));
                    if rank > 0 && (owns || !sole.is_empty()) {
                        *messages += 1;
                        let shown =
                            |tile: &u32| bytes(&pixels(*tile, |pixel| is_shown(&frames[rank], pixel)), 4);
                        let merged = place.map_or(0, |place| have[place].values().map(|p| bytes(p, 4)).sum());
                        *sum += TRAILER + sole.iter().map(shown).sum::<u64>() + merged;
                    }
                }
                let sharing = Sharing { composition, ..Organisation::SortLast.into() };
                let found = report(&scene, &camera, count, sharing);
                assert_eq!(sent(&found), expected, "{model}, {count} ranks, {composition}");
            }
        }
    }
    assert!(with_pixels > 100, "{with_pixels} ranks send pixels");
}

/// Of dense encoding, what is sent depends on the size of the picture and the number of ranks alone: each message has every
/// pixel of its tiles, 12 bytes each, heads of rows and tiles beside them.
#[test]
fn dense_encoding_sends_every_pixel() {
    let tile_bytes = |tile: u32| 12 + bytes(&pixels(tile, |_| true), 12);
    let picture: u64 = (0..TILES as u32).map(tile_bytes).sum();
    for model in MODELS {
        let (scene, camera) = made(model);
        for count in [2, 3, 4, 8] {
            let found = vec![vec![true; TILES]; count];
            let touched = Touched::new(TILES, found.iter().map(|found| |tile: u32| found[tile as usize]));
            let (tiles, ranks): (Vec<u32>, Vec<usize>) = ((0..TILES as u32).collect(), (0..count).collect());
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            for composition in Composition::ALL {
                let sharing =
                    Sharing { composition, encoding: Encoding::Dense, ..Organisation::SortLast.into() };
                let report = report(&scene, &camera, count, sharing);
                let of_pixels = |(kind, traffic): (Kind, _)| (kind == Kind::Pixels).then_some(traffic);
                let traffic = report.by_kind().into_iter().find_map(of_pixels).expect("ranks composite");
                let rounds = |place| composition.rounds(&shared, place);
                let sends: Vec<(usize, Vec<u32>)> =
                    (0..count).flat_map(rounds).flat_map(|round| round.sends).collect();
                let contents: u64 =
                    sends.iter().flat_map(|(_, tiles)| tiles).map(|&tile| tile_bytes(tile)).sum();
                let messages = sends.len() as u64;
                let what = format!("{model}, {count} ranks, {composition}");
                assert_eq!(traffic.sent_messages, messages, "{what}");
                assert_eq!(traffic.sent_bytes, contents + messages * TRAILER, "{what}");
                if composition == Composition::DirectSend {
                    // Each rank keeps what it owns, and all own the picture together.
                    assert_eq!(contents, (count as u64 - 1) * picture, "{what}");
                }
                assert_eq!(report.encoding, Some(Encoding::Dense));
            }
        }
    }
}

#[test]
fn fragments_are_not_sent_dense() {
    let (scene, camera) = made("builtin:teapot@3k");
    let settings = Settings::new(64, 48);
    let sharing = Sharing { encoding: Encoding::Dense, ..Organisation::SortLast.into() };
    let drawn = |count| draw(Ranks { count, threads: 1, sharing }, &scene, &camera, &settings);
    let error = drawn(2).unwrap_err().to_string();
    assert!(error.contains("encoding of composited pixels must be visible or sparse"), "{error}");
    // A single rank composites nothing.
    assert!(drawn(1).is_ok());
}

/// Dense direct send sends 12 bytes of every pixel that a rank does not own. Compositing sends little more than that for each pixel
/// that it sends, and far less in all where ranks have parts that lie apart.
#[test]
fn compositing_sends_little_beside_dense_direct_send() {
    for model in ["builtin:teapot@20k", "builtin:gyroid@20k"] {
        let (scene, camera) = made(model);
        let settings = Settings::one_sample(640, 480);
        for composition in Composition::ALL {
            for count in [2, 4, 8, 16] {
                let sharing = Sharing { composition, ..Organisation::SortLast.into() };
                let (_, report) = draw(Ranks { count, threads: 1, sharing }, &scene, &camera, &settings)
                    .expect("a picture");
                let sent =
                    report.by_kind().into_iter().find(|of| of.0 == Kind::Pixels).map(|of| of.1.sent_bytes);
                let sent = sent.expect("ranks composite") as f64;
                let pixels: u64 = report.ranks.iter().map(|rank| rank.pixels.sent).sum();
                let dense = 12.0 * 640.0 * 480.0 * (count as f64 - 1.0);
                let (of_pixel, of_dense) = (sent / pixels as f64 / 12.0, sent / dense);
                let what = format!("{model}, {count} ranks, {composition}: {of_pixel}, {of_dense}");
                assert!(pixels > 1000 && of_pixel <= 1.2 && of_dense < 0.2, "{what}");
            }
        }
    }
}

/// With several samples per pixel, a rank hands on no more of what others have drawn than can be seen: of each pixel that is
/// sent (counted in pictures that ranks have drawn alone) every strategy sends at most 1.2 times the bytes that direct send, which
/// sends everything once, has for it. Without blocks that are finished before, which save most.
#[test]
fn fragments_that_are_handed_on_are_those_that_are_seen() {
    for model in ["builtin:teapot@3k", "builtin:soup@500", "builtin:gyroid@20k"] {
        let (scene, camera) = made(model);
        let settings = Settings { tile_size: Some(EDGE), ..Settings::new(SIZE.0, SIZE.1) };
        for count in [3, 8, 16] {
            let context = FrameContext::new(&scene, &camera, &settings, 1).expect("a context");
            let sets = Renderer::divide_clusters(&context, count);
            let (frames, found): (Vec<_>, Vec<_>) =
                sets.into_iter().map(|clusters| drawn(&scene, &camera, clusters, &settings)).unzip();
            let touched = Touched::new(TILES, found.iter().map(|found| |tile: u32| found[tile as usize]));
            let tiles = touched.shared();
            let ranks = touched.ranks_of_any(&tiles);
            let shared = Shared { tiles: &tiles, ranks: &ranks, touched: &touched };
            // Bytes of all ranks.
            let sent = |composition, encoding| {
                let sharing = Sharing { composition, encoding, ..Organisation::SortLast.into() };
                let ranks = Ranks { count, threads: 1, sharing };
                let (_, report) = draw(ranks, &scene, &camera, &settings).expect("a picture");
                let of_fragments = |(kind, traffic): (Kind, _)| (kind == Kind::Fragments).then_some(traffic);
                let traffic = report.by_kind().into_iter().find_map(of_fragments);
                traffic.map_or(0.0, |traffic| (traffic.sent_bytes - traffic.sent_messages * TRAILER) as f64)
            };
            let of_pixel = |composition| {
                let active = |part: &Pixels| part.iter().flatten().filter(|&&drawn| drawn).count() as u64;
                let (of_ranks, _) = composited(composition, &shared, &frames, active);
                let pixels: u64 = of_ranks.iter().map(|(messages, sum)| sum - messages * TRAILER).sum();
                assert!(pixels > 1000, "{model}, {count} ranks, {composition}: {pixels} pixels");
                sent(composition, Encoding::Sparse) / pixels as f64
            };
            let direct = of_pixel(Composition::DirectSend);
            for composition in Composition::ALL.into_iter().chain([Composition::radix_k(2)]) {
                let times = of_pixel(composition) / direct;
                let what = format!("{model}, {count} ranks, {composition}: {times} times {direct} bytes");
                assert!(times <= 1.2, "{what}");
                assert!(
                    sent(composition, Encoding::Visible) <= sent(composition, Encoding::Sparse) * 1.01,
                    "{what}"
                );
            }
        }
    }
}
