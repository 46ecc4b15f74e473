//! Parts of a frame that are drawn apart, as fragments, and merged are the frame.

mod common;

use common::{assert_same, draw, everything, perspective, scene, soup, with_second_instance};
use proptest::prelude::*;
use tercio_raster::context::FrameContext;
use tercio_raster::frame::{FragmentError, FragmentsOfTile, TileFragments};
use tercio_raster::{
    Filter, Frame, Outputs, Part, Renderer, SamplePattern, SampleShading, Sampling, Settings, SimdLevel,
};
use tercio_scene::{Camera, Scene};

/// The fragments of each part of a frame.
fn parts(scene: &Scene, camera: &Camera, settings: &Settings, of: u32) -> Vec<Vec<TileFragments>> {
    let part = |number: u32| {
        let clusters = Part { number, of };
        let settings = Settings { clusters, keep_fragments: true, ..settings.clone() };
        let frame = Renderer::new().render(scene, camera, &settings).expect("fragments");
        assert_eq!((frame.planes.color.len(), frame.planes.linear.len()), (0, 0), "there are planes");
        assert!(frame.fragments.is_sorted_by_key(|of_tile| of_tile.tile));
        assert!(frame.fragments.iter().all(|of_tile| !of_tile.bytes.is_empty()));
        frame.fragments
    };
    (0..of).map(part).collect()
}

/// The fragments of all tiles of a frame with so many tiles.
fn by_tile(parts: &[Vec<TileFragments>], tiles: usize) -> Vec<FragmentsOfTile<'_>> {
    let of_tile = |tile: u32| {
        let own = parts.iter().flatten().filter(|of| of.tile == tile);
        FragmentsOfTile { tile, parts: own.map(|of| &of.bytes[..]).collect() }
    };
    (0..tiles as u32).map(of_tile).collect()
}

fn merge(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    parts: &[Vec<TileFragments>],
) -> Result<Frame, FragmentError> {
    let context = FrameContext::new(scene, camera, settings, 1).expect("a frame");
    let mut frame = Frame::default();
    frame.resize(settings);
    Renderer::new().merge(&context, &by_tile(parts, context.grid.count()), &mut frame)?;
    Ok(frame)
}

fn samplings() -> Vec<Sampling> {
    let tent = Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse8) };
    let by_sample = Sampling { shading: SampleShading::Sample, ..Sampling::default() };
    let patterns = [SamplePattern::Sparse2, SamplePattern::Sparse4, SamplePattern::Sparse16];
    [Sampling::NONE, tent, by_sample].into_iter().chain(patterns.map(Sampling::of)).collect()
}

#[test]
fn parts_are_merged_into_the_picture() {
    let mesh = soup(3_000, 6);
    let opaque = with_second_instance(scene(&mesh));
    let mut clear = opaque.clone();
    clear.instances[0].surface.opacity = 0.4;
    let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
    for (sampling, plain) in samplings().into_iter().flat_map(|s| [(s, &opaque), (s, &clear)]) {
        for outputs in [Outputs::ALL, Outputs::default(), Outputs { ids: true, ..Outputs::NONE }] {
            let settings =
                Settings { sampling, outputs, tile_size: Some(32), layer_memory: 1, ..everything(111, 77) };
            let expected = draw(plain, &camera, &settings);
            for of in [1, 2, 5] {
                let mut parts = parts(plain, &camera, &settings, of);
                let frame = merge(plain, &camera, &settings, &parts).expect("fragments of these tiles");
                assert_same(&expected, &frame, &format!("{sampling:?}, {of} parts"));
                // Their order does not matter.
                parts.reverse();
                let frame = merge(plain, &camera, &settings, &parts).expect("fragments of these tiles");
                assert_same(&expected, &frame, &format!("{sampling:?}, {of} parts in reverse"));
            }
        }
    }
}

#[test]
fn fragments_are_the_same_at_every_simd_level() {
    let plain = scene(&soup(2_000, 2));
    let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
    let settings = Settings { tile_size: Some(16), ..everything(60, 50) };
    let at = |level: SimdLevel| {
        let settings = Settings { simd: Some(level), ..settings.clone() };
        let parts = parts(&plain, &camera, &settings, 2);
        merge(&plain, &camera, &settings, &parts).expect("fragments of these tiles")
    };
    let expected = draw(&plain, &camera, &settings);
    for level in SimdLevel::available() {
        assert_same(&expected, &at(level), &level.to_string());
    }
}

#[test]
fn what_is_not_in_the_tile_is_an_error() {
    let plain = scene(&soup(300, 2));
    let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
    let settings = Settings { tile_size: Some(16), ..Settings::new(20, 20) };
    let good = parts(&plain, &camera, &settings, 1);
    let changed = |change: &dyn Fn(&mut Vec<TileFragments>)| {
        let mut parts = good.clone();
        change(&mut parts[0]);
        merge(&plain, &camera, &settings, &parts).map(|_| ())
    };
    assert_eq!(changed(&|_| ()), Ok(()));
    let last = good[0].last().expect("fragments");
    let short = changed(&|parts| _ = parts.last_mut().expect("fragments").bytes.pop());
    assert!(matches!(short, Err(FragmentError::Short { tile, .. }) if tile == last.tile), "{short:?}");
    for (byte, value, what) in [(5, 255, "a pixel"), (6, 0, "no sample"), (6, 16, "a fifth sample")] {
        let error = changed(&|parts| parts[0].bytes[byte] = value).expect_err(what);
        let first = good[0][0].tile;
        assert!(
            matches!(error, FragmentError::Place { tile, at: 0, .. } if tile == first),
            "{what}: {error}"
        );
    }
    let context = FrameContext::new(&plain, &camera, &settings, 1).expect("a frame");
    let mut frame = Frame::default();
    frame.resize(&settings);
    let fifth = FragmentsOfTile { tile: 4, parts: vec![&good[0][0].bytes] };
    let error = Renderer::new().merge(&context, &[fifth], &mut frame);
    assert_eq!(error, Err(FragmentError::Tile { tile: 4, tiles: 4 }));
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), samples in 0usize..6) {
        let plain = scene(&soup(10, 2));
        let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
        let sampling = samplings()[samples];
        let settings = Settings { tile_size: Some(8), sampling, ..everything(8, 8) };
        // Most pixels do not exist.
        let mut bytes = bytes;
        for head in bytes.chunks_mut(30) {
            if let Some(place) = head.get_mut(4..7) {
                place.copy_from_slice(&[place[0] % 64, 0, place[2] % 4]);
            }
        }
        let parts = vec![vec![TileFragments { tile: 0, bytes }]];
        merge(&plain, &camera, &settings, &parts).ok();
    }
}
