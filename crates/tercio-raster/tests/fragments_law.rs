//! Parts of a frame that are drawn apart, as fragments, and merged are the frame.

mod common;

use common::{assert_same, draw, everything, perspective, scene, scene_with, soup, with_second_instance};
use proptest::prelude::*;
use tercio_mesh::cluster::PartitionOptions;
use tercio_raster::binning::Sorted;
use tercio_raster::context::FrameContext;
use tercio_raster::depth_bounds::DepthBounds;
use tercio_raster::frame::fragments::{FragmentHead, FragmentLayout, write_fragment};
use tercio_raster::frame::{FragmentError, FragmentsOfTile, Pixel, TileFragments};
use tercio_raster::{
    Filter, Frame, Outputs, Part, Renderer, SamplePattern, SampleShading, Sampling, Settings, SimdLevel,
    TileSet,
};
use tercio_scene::{Camera, Instance, Scene};

/// The fragments of each part of a frame.
fn parts(scene: &Scene, camera: &Camera, settings: &Settings, of: u32) -> Vec<Vec<TileFragments>> {
    let part = |number: u32| {
        let clusters = Part { number, of }.range(scene.cluster_count() as u32).into();
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
        FragmentsOfTile { tile, parts: own.map(|of| &of.bytes[..]).collect(), has_finished: false }
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

/// How near each of some parts of a frame may draw, all tiles of it.
fn bounds(
    context: &FrameContext,
    settings: &Settings,
    scene: &Scene,
    camera: &Camera,
    of: u32,
) -> Vec<DepthBounds> {
    let part = |number: u32| {
        let clusters = Part { number, of }.range(scene.cluster_count() as u32).into();
        let own = Settings { clusters, ..settings.clone() };
        let own = FrameContext::new(scene, camera, &own, 1).expect("a frame");
        let mut sorted = Sorted::default();
        Renderer::new().sort(&own, &mut sorted);
        let mut bounds = DepthBounds::new(&context.grid, (0..context.grid.count() as u32).collect());
        bounds.tiles_mut().for_each(|(tile, of)| sorted.raise_bounds(&own, tile, of));
        bounds
    };
    (0..of).map(part).collect()
}

/// Finished blocks of all parts, and the fragments that are left, are together the picture; also if later parts know what earlier ones
/// hide, which culls some of their clusters.
#[test]
fn blocks_that_are_finished_are_those_of_the_picture() {
    const PARTS: u32 = 3;
    let mesh = tercio_mesh::builtin::make("builtin:teapot@4k").expect("a model");
    let mut scene = scene_with(&mesh, &PartitionOptions { max_triangles: 16, ..PartitionOptions::default() });
    let camera = Settings::new(157, 103).framing().camera_for_scene(&scene);
    // Another one behind it.
    let place = scene.bounds().center() * 0.5 + (camera.target - camera.eye);
    let behind = glam::DAffine3::from_scale_rotation_translation(
        glam::DVec3::splat(0.5),
        glam::DQuat::IDENTITY,
        place,
    );
    scene.instances.push(Instance { world_from_object: behind, ..scene.instances[0].clone() });
    let mut untold = std::collections::HashMap::new();
    for (sampling, tells) in
        samplings().into_iter().flat_map(|sampling| [false, true].map(|tells| (sampling, tells)))
    {
        // Of the largest tiles several workers draw parts.
        for (outputs, size, workers) in [
            (Outputs::ALL, 32, 1),
            (Outputs::default(), 64, 2),
            (Outputs::default(), 8, 1),
            (Outputs::ALL, 128, 3),
        ] {
            let settings = Settings { sampling, outputs, tile_size: Some(size), ..everything(157, 103) };
            let expected = draw(&scene, &camera, &settings);
            let context = FrameContext::new(&scene, &camera, &settings, 1).expect("a frame");
            let tiles = context.grid.count();
            let bounds = bounds(&context, &settings, &scene, &camera, PARTS);
            let mut hidden = DepthBounds::new(&context.grid, (0..tiles as u32).collect());
            let mut frames = Vec::new();
            for number in 0..PARTS as usize {
                let mut others = DepthBounds::new(&context.grid, (0..tiles as u32).collect());
                for (tile, to) in others.tiles_mut() {
                    let theirs = (0..PARTS as usize).filter(|&other| other != number);
                    for of in theirs.filter_map(|other| bounds[other].of(tile)) {
                        to.iter_mut().zip(of).for_each(|(to, &depth)| *to = to.max(depth));
                    }
                }
                let clusters = Part { number: number as u32, of: PARTS };
                let clusters = clusters.range(scene.cluster_count() as u32).into();
                let own = Settings { clusters, keep_fragments: true, ..settings.clone() };
                let mut own = FrameContext::new(&scene, &camera, &own, workers).expect("a frame");
                own.nearest_of_others = Some(others);
                own.hidden_by_others = tells.then(|| hidden.clone());
                let (mut renderer, mut sorted, mut frame) =
                    (Renderer::new(), Sorted::default(), Frame::default());
                frame.resize(&settings);
                renderer.sort(&own, &mut sorted);
                renderer.draw(&own, &sorted, &TileSet::ALL, &mut frame);
                for TileFragments { tile, finished: of_tile, .. } in &frame.fragments {
                    let before = hidden.of_mut(*tile).expect("a tile");
                    before.iter_mut().zip(&of_tile.hides).for_each(|(old, &depth)| *old = old.max(depth));
                }
                frames.push(frame);
            }
            let pixels = |frame: &Frame| frame.fragments.iter().map(|of| of.finished.pixels).sum::<u64>();
            let in_blocks: u64 = frames.iter().map(pixels).sum();
            let is_by_block = sampling.filter != Filter::Tent;
            let what = format!("{sampling:?}, tiles of {size}, {tells}: {in_blocks} pixels are finished");
            let visible = expected.stats.backend.pixels_visible;
            assert_eq!(in_blocks > visible / 20, is_by_block, "{what}");
            // Some blocks are finished, and some hide what is farther.
            let mut depths: Vec<f32> = hidden.tiles_mut().flat_map(|(_, of)| of.to_vec()).collect();
            depths.retain(|&depth| depth > 0.0);
            assert_eq!(depths.contains(&f32::INFINITY), is_by_block, "{what}");
            assert_eq!(depths.iter().any(|depth| depth.is_finite()), is_by_block, "{what}");
            // Clusters behind what others hide are culled.
            let hidden: u64 = frames.iter().map(|frame| frame.stats.backend.clusters_hidden).sum();
            match tells {
                true => assert_eq!(hidden > untold[&(size, format!("{sampling:?}"))], is_by_block, "{what}"),
                false => _ = untold.insert((size, format!("{sampling:?}")), hidden),
            }
            // The first part owns all tiles, and gets the finished pixels of the others.
            let fragments: Vec<Vec<TileFragments>> =
                frames.iter_mut().map(|frame| std::mem::take(&mut frame.fragments)).collect();
            let mut of_tiles = by_tile(&fragments, tiles);
            of_tiles.iter_mut().for_each(|of_tile| {
                of_tile.has_finished = is_by_block;
                of_tile.parts.retain(|bytes| !bytes.is_empty());
            });
            let mut frames = frames.into_iter();
            let mut frame = frames.next().expect("a part");
            let merged =
                Renderer::new().merge(&context, &of_tiles, &mut frame).expect("fragments of these tiles");
            assert_eq!(merged + in_blocks, visible, "{what}");
            for other in frames.filter(|_| is_by_block) {
                for place in 0..157 * 103 {
                    let pixel = Pixel::of_background(&scene.background, place as u32 / 157, 103);
                    let (mut differs, mut bytes) = ([false], Vec::new());
                    other.planes.differ_from(&outputs, place..place + 1, &pixel, &mut differs);
                    if differs[0] {
                        other.planes.write_bytes(&outputs, place..place + 1, &mut bytes);
                        frame.planes.read_bytes(&outputs, &bytes, place..place + 1);
                    }
                }
            }
            assert_same(&expected, &frame, &what);
        }
    }
}

/// What an earlier frame has left in the memory of a renderer does not matter.
#[test]
fn a_renderer_that_draws_and_merges_can_be_reused() {
    let plain = scene(&soup(2_000, 3));
    let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut renderer = Renderer::new();
    for outputs in
        [Outputs::ALL, Outputs { ids: true, ..Outputs::NONE }, Outputs { depth: true, ..Outputs::NONE }]
    {
        for _ in 0..3 {
            let settings = Settings { outputs, tile_size: Some(32), ..everything(70, 60) };
            let keeping = Settings { keep_fragments: true, ..settings.clone() };
            let context = FrameContext::new(&plain, &camera, &settings, 1).expect("a frame");
            let mut frame = Frame::default();
            pool.install(|| {
                let drawn = renderer.render(&plain, &camera, &keeping).expect("fragments").fragments;
                frame.resize(&settings);
                renderer.merge(&context, &by_tile(&[drawn], context.grid.count()), &mut frame)
            })
            .expect("fragments of these tiles");
            assert_same(&draw(&plain, &camera, &settings), &frame, &format!("{outputs:?}"));
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
    for (byte, value, what) in [(5, 255, "a pixel"), (6, 16, "a fifth sample")] {
        let error = changed(&|parts| parts[0].bytes[byte] = value).expect_err(what);
        let first = good[0][0].tile;
        assert!(
            matches!(error, FragmentError::Place { tile, at: 0, .. } if tile == first),
            "{what}: {error}"
        );
    }
    // Tiles of 16 pixels have four blocks.
    for (first, count, is_valid) in [(0, 4, true), (3, 1, true), (3, 2, false), (4, 1, false), (0, 0, false)]
    {
        let head = FragmentHead { primitive: count, place: first, ..FragmentHead::default() };
        let found = changed(&|parts| parts[0].bytes.extend(bytemuck::bytes_of(&head)));
        let blocks = |error| matches!(error, FragmentError::Blocks { first: of, .. } if of == first);
        assert_eq!(found.is_ok(), is_valid, "{first}, {count}");
        assert!(found.is_ok() || found.is_err_and(blocks), "{first}, {count}");
    }
    let context = FrameContext::new(&plain, &camera, &settings, 1).expect("a frame");
    let mut frame = Frame::default();
    frame.resize(&settings);
    let fifth = FragmentsOfTile { tile: 4, parts: vec![&good[0][0].bytes], has_finished: false };
    let error = Renderer::new().merge(&context, &[fifth], &mut frame);
    assert_eq!(error, Err(FragmentError::Tile { tile: 4, tiles: 4 }));
}

/// A fragment as bytes: its place, the mask of its samples, what decides on its alpha and depth.
fn fragment(of: (u16, u16, u8, u32), sampling: &Sampling) -> Vec<u8> {
    let (place, mask, kind, depth) = of;
    let mask = mask & ((1u32 << sampling.pattern.count()) - 1) as u16;
    let alpha = [1.0, 0.5, 0.0, f32::NAN, -3.0, f32::INFINITY][usize::from(kind) % 6];
    // With a filter that is wider than a pixel, there is room for more pixels in a row.
    let stride = if sampling.filter == Filter::Tent { 16 } else { 8 };
    let place = place % 8 * stride + place / 8 % 8;
    let head = FragmentHead { primitive: depth % 5, place, mask, color: [0.1, 0.2, 0.3, alpha] };
    // Also what is no depth: NaN, infinity, negative numbers.
    let depth = if kind < 128 { 0.5 + depth as f32 * 1e-10 } else { f32::from_bits(depth) };
    let depths = |sample: usize| depth + sample as f32 * 1e-3;
    let layout = FragmentLayout::new(&Outputs::ALL, false);
    let mut bytes = vec![0; layout.bytes(mask.count_ones() as usize)];
    write_fragment(layout, &head, head.primitive.into(), || [0.0, 0.0, 1.0], || 7, depths, &mut bytes);
    bytes
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), samples in 0usize..6) {
        let plain = scene(&soup(10, 2));
        let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
        let settings = Settings { tile_size: Some(8), sampling: samplings()[samples], ..everything(8, 8) };
        let parts = vec![vec![TileFragments { tile: 0, bytes, ..TileFragments::default() }]];
        merge(&plain, &camera, &settings, &parts).ok();
    }

    #[test]
    fn arbitrary_fragments_never_panic(
        fragments in prop::collection::vec(any::<(u16, u16, u8, u32)>(), 0..40),
        samples in 0usize..6,
        opacity in prop_oneof![Just(1.0f32), Just(0.5)],
    ) {
        let mut plain = scene(&soup(10, 2));
        plain.instances[0].surface.opacity = opacity;
        let camera = perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0);
        let sampling = samplings()[samples];
        let settings = Settings { tile_size: Some(8), sampling, ..everything(8, 8) };
        let fragments: Vec<_> = fragments.into_iter().filter(|of| of.1 & 1 == 1).collect();
        let is_opaque = fragments.iter().all(|of| of.2 % 6 == 0);
        let bytes = fragments.iter().flat_map(|&of| fragment(of, &sampling)).collect();
        let merged = merge(&plain, &camera, &settings, &[vec![TileFragments { tile: 0, bytes, ..TileFragments::default() }]]);
        match merged {
            Ok(_) => prop_assert!(is_opaque || opacity < 1.0),
            Err(FragmentError::Translucent { tile: 0, .. }) => prop_assert!(!is_opaque && opacity == 1.0),
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        }
    }
}
