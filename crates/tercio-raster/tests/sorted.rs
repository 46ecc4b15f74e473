//! The two halves of a frame: a rank can draw what another rank has sorted.

mod common;

use common::{assert_same, draw, everything, perspective, scene, soup, with_second_instance};
use tercio_raster::binning::{Numbering, Sorted, SortedError};
use tercio_raster::context::FrameContext;
use tercio_raster::screen::PixelRect;
use tercio_raster::{Frame, Part, Renderer, SamplePattern, Sampling, Settings, Sorting, TileSet};

const SIZE: (u32, u32) = (211, 157);

fn settings(tile_size: u32, sorting: Sorting) -> Settings {
    Settings { tile_size: Some(tile_size), sorting, ..everything(SIZE.0, SIZE.1) }
}

/// Every rank sorts a share of the clusters and sends each other rank the bins of that rank's tiles.
#[test]
fn bins_sent_as_bytes_give_the_same_picture() {
    let mesh = soup(4_000, 3);
    let both = with_second_instance(scene(&mesh));
    for camera in
        [perspective([0.1, 0.2, 0.3], [1.0, 0.0, -1.0], 75.0), perspective([1.0, 2.0, 9.0], [0.0; 3], 35.0)]
    {
        for (tile_size, sorting) in
            [(16, Sorting::Clusters), (64, Sorting::Clusters), (32, Sorting::Triangles)]
        {
            let settings = settings(tile_size, sorting);
            let expected = draw(&both, &camera, &settings);
            let tiles = (SIZE.0.div_ceil(tile_size) * SIZE.1.div_ceil(tile_size)) as usize;
            let own = |rank: u32| TileSet::every(3, rank, tiles);
            let mut messages = vec![Vec::new(); 3];
            let mut renderer = Renderer::new();
            for number in 0..3 {
                let clusters = Part { number, of: 3 }.range(both.cluster_count() as u32).into();
                let part = Settings { clusters, ..settings.clone() };
                let context = FrameContext::new(&both, &camera, &part, 2).unwrap();
                let mut sorted = Sorted::default();
                renderer.sort(&context, &mut sorted);
                let mut numbering = Numbering::default();
                for to in 0..3 {
                    let (mut message, tiles) = (Vec::new(), own(to).numbers(tiles).collect::<Vec<_>>());
                    sorted.write_bytes(&context.grid, &tiles, &mut numbering, &mut message);
                    messages[to as usize].push(message);
                }
            }
            let mut frame = Frame::default();
            frame.resize(&settings);
            for (rank, messages) in (0..).zip(&messages) {
                let own = own(rank);
                let settings = Settings { tiles: own.clone(), ..settings.clone() };
                let context = FrameContext::new(&both, &camera, &settings, 1).unwrap();
                let mut sorted = Sorted::default();
                // The order of the messages does not matter.
                let messages = messages.iter().rev().map(|message| &message[..]);
                sorted.read_bytes(&context, messages).expect("what was written");
                renderer.draw(&context, &sorted, &own, &mut frame);
            }
            assert_same(&expected, &frame, &format!("{tile_size}, {sorting:?}"));
        }
    }
}

#[test]
fn invalid_bytes_are_refused() {
    let mesh = soup(500, 5);
    let scene = scene(&mesh);
    let camera = perspective([1.0, 2.0, 9.0], [0.0; 3], 35.0);
    let all = settings(32, Sorting::Triangles);
    let context = FrameContext::new(&scene, &camera, &all, 1).unwrap();
    let mut sorted = Sorted::default();
    let mut renderer = Renderer::new();
    renderer.sort(&context, &mut sorted);
    let mut bytes = Vec::new();
    let tiles: Vec<u32> = (0..context.grid.count() as u32).collect();
    sorted.write_bytes(&context.grid, &tiles, &mut Numbering::default(), &mut bytes);
    let mut found = Sorted::default();
    // The second of two messages is the one that is not valid.
    let read = |invalid: &[u8]| {
        let error = Sorted::default().read_bytes(&context, [&bytes[..], invalid]);
        error.map_err(|(number, error)| {
            assert_eq!(number, 1);
            error
        })
    };
    assert_eq!(found.read_bytes(&context, [&bytes[..], &[]]), Ok(()));
    assert_eq!(
        (0..30).map(|tile| found.fill(tile)).sum::<u64>(),
        (0..30).map(|tile| sorted.fill(tile)).sum::<u64>()
    );

    for length in (1..bytes.len()).step_by(13) {
        assert_eq!(read(&bytes[..length]), Err(SortedError::Length { bytes: length }));
    }
    let other = settings(16, Sorting::Triangles);
    let other = FrameContext::new(&scene, &camera, &other, 1).unwrap();
    assert!(matches!(Sorted::default().read_bytes(&other, [&bytes[..]]), Err((0, SortedError::Grid { .. }))));
    // Whichever word of the bytes is altered, the bytes are refused or can be drawn.
    let (mut refused, mut frame) = (0, Frame::default());
    frame.resize(&all);
    for at in (0..bytes.len() - 4).step_by(4).take(3_000) {
        for value in [u32::MAX, 0x7f7f_ffff, 1 << 20] {
            let mut altered = bytes.clone();
            altered[at..at + 4].copy_from_slice(&value.to_ne_bytes());
            let mut sorted = Sorted::default();
            match sorted.read_bytes(&context, [&altered[..]]) {
                Ok(()) if at % 64 == 0 => renderer.draw(&context, &sorted, &TileSet::ALL, &mut frame),
                Ok(()) => {}
                Err((_, error)) => {
                    refused += 1;
                    assert!(!error.to_string().is_empty());
                }
            }
        }
    }
    assert!(refused > 1_000, "only {refused} alterations were refused");
}

/// Of every pixel that shows a whole cluster some entry of its tile says so, and there are as many entries as are counted.
#[test]
fn the_clusters_of_a_tile_reach_what_it_shows() {
    let mesh = soup(2_000, 9);
    let scene = scene(&mesh);
    let camera = perspective([1.0, 2.0, 9.0], [0.0; 3], 35.0);
    for pattern in [SamplePattern::Center, SamplePattern::Sparse4] {
        // No cluster is in so many tiles that it is taken apart.
        let settings = Settings { sampling: Sampling::of(pattern), ..settings(64, Sorting::Clusters) };
        let frame = draw(&scene, &camera, &settings);
        let context = FrameContext::new(&scene, &camera, &settings, 1).unwrap();
        let (mut renderer, mut sorted) = (Renderer::new(), Sorted::default());
        renderer.sort(&context, &mut sorted);
        let (mut entries, mut shown) = (0, 0);
        for tile in 0..context.grid.count() as u32 {
            entries += sorted.clusters_of(tile).count() as u64;
            let own = context.grid.rect(tile, context.size());
            for (y, x) in (own.y0..own.y1 + 1).flat_map(|y| (own.x0..own.x1 + 1).map(move |x| (y, x))) {
                let depth = frame.planes.depth[y as usize * SIZE.0 as usize + x as usize];
                let here = PixelRect { x0: x, x1: x, y0: y, y1: y };
                let mut reach = sorted.clusters_of(tile).filter(|c| !c.pixels().intersect(here).is_empty());
                shown += u64::from(depth.is_finite());
                assert!(!depth.is_finite() || reach.any(|_| true), "pixel {x}, {y}");
            }
            for cluster in sorted.clusters_of(tile) {
                assert!(!cluster.pixels().intersect(own).is_empty(), "an entry of tile {tile} is elsewhere");
            }
        }
        assert_eq!(entries, frame.stats.binning.cluster_entries);
        assert_eq!(frame.stats.binning.triangles, 0, "none is taken apart, or a pixel might show it");
        assert!(shown > 5_000, "{shown}");
    }
}

#[test]
fn drawing_a_set_of_tiles_leaves_the_others_unchanged() {
    let mesh = soup(500, 5);
    let scene = scene(&mesh);
    let camera = perspective([1.0, 2.0, 9.0], [0.0; 3], 35.0);
    let settings = settings(32, Sorting::Clusters);
    let context = FrameContext::new(&scene, &camera, &settings, 1).unwrap();
    let (mut renderer, mut sorted, mut frame) = (Renderer::new(), Sorted::default(), Frame::default());
    frame.resize(&settings);
    frame.planes.ids.fill(7_000_000);
    renderer.sort(&context, &mut sorted);
    renderer.draw(&context, &sorted, &TileSet::from_fn(35, |tile| tile == 8), &mut frame);
    let inside = |p: usize| (32..64).contains(&(p % 211)) && (32..64).contains(&(p / 211));
    for (p, &id) in frame.planes.ids.iter().enumerate() {
        assert_eq!(id != 7_000_000, inside(p), "pixel {p}");
    }
}

#[test]
fn a_set_for_other_tiles_is_refused() {
    let tiles = TileSet::every(2, 0, 10);
    for tile_size in [None, Some(64)] {
        let refused = Settings { tiles: tiles.clone(), tile_size, ..everything(SIZE.0, SIZE.1) }.check();
        assert!(refused.is_err_and(|e| e.to_string().contains("set of tiles")), "{tile_size:?}");
    }
}
