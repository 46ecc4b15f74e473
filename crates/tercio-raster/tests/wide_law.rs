//! Primitives whose numbers need more than 32 bits: the picture is the reference's, and that of smaller numbers in the same order.

mod common;

use common::{assert_same, draw, everything, perspective, scene, soup, with_threads};
use tercio_mesh::Mesh;
use tercio_raster::context::{FrameContext, faces_of};
use tercio_raster::conventions::MAX_NUMBERS;
use tercio_raster::frame::{FragmentsOfTile, NO_PRIMITIVE, Pixel};
use tercio_raster::{
    Filter, Frame, Outputs, Part, RenderError, Renderer, SamplePattern, SampleShading, Sampling, Settings,
    SimdLevel, Sorting, reference,
};
use tercio_scene::{Camera, Scene, Share};

/// 2^32.
const LIMIT: u64 = 1 << 32;

/// Triangles, and all of them once more in another order and other colours: at every sample are two of equal depth.
fn doubled(triangles: usize, alpha: u8) -> Mesh {
    let mut mesh = soup(triangles, 5);
    let again: Vec<[u32; 3]> = mesh.triangles.iter().rev().copied().collect();
    mesh.triangles.extend(again);
    mesh.vertex_colors = None;
    let color = |k: usize| [(k * 37 % 256) as u8, if k < triangles { 230 } else { 20 }, 90, alpha];
    mesh.face_colors = Some((0..2 * triangles).map(color).collect());
    mesh
}

/// The scene with triangles and faces of each instance numbered from these numbers on.
fn numbered(mut scene: Scene, bases: &[[u64; 2]]) -> Scene {
    for (instance, &base) in scene.instances.iter_mut().zip(bases) {
        let (triangles, faces) = (instance.mesh.triangle_count() as u64, faces_of(&instance.mesh));
        instance.share = Some(Share { triangles, faces, base: Some(base), ..Share::default() });
    }
    scene
}

/// A second instance at the same place, of one colour.
fn coincident(mut scene: Scene) -> Scene {
    let mut second = scene.instances[0].clone();
    second.surface.base_color = [0.9, 0.2, 0.1];
    second.surface.use_mesh_colors = false;
    scene.instances.push(second);
    scene
}

fn view() -> Camera {
    perspective([0.1, 0.2, 2.3], [0.2, 0.0, -1.0], 60.0)
}

/// All planes but ids.
fn settings(sampling: Sampling) -> Settings {
    let outputs = Outputs { ids: false, ..Outputs::ALL };
    Settings { outputs, sampling, tile_size: Some(16), ..everything(61, 47) }
}

fn samplings() -> Vec<Sampling> {
    let tent = Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse4) };
    let by_sample = Sampling { shading: SampleShading::Sample, ..Sampling::default() };
    vec![Sampling::NONE, Sampling::of(SamplePattern::Sparse4), tent, by_sample]
}

/// A frame without the planes that have numbers of triangles.
fn unnumbered(mut frame: Frame) -> Frame {
    (frame.planes.keys, frame.planes.ties) = (Vec::new(), Vec::new());
    frame
}

/// The fragments of parts of the clusters, merged.
fn merged(scene: &Scene, settings: &Settings, of: u32) -> Frame {
    let parts: Vec<_> = (0..of)
        .map(|number| {
            let clusters = Part { number, of }.range(scene.cluster_count() as u32).into();
            let settings = Settings { clusters, keep_fragments: true, ..settings.clone() };
            draw(scene, &view(), &settings).fragments
        })
        .collect();
    let camera = view();
    let context = FrameContext::new(scene, &camera, settings, 1).expect("a frame");
    // The last part first.
    let of_tile = |tile: u32| FragmentsOfTile {
        tile,
        parts: parts.iter().rev().flatten().filter(|of| of.tile == tile).map(|of| &of.bytes[..]).collect(),
        has_finished: false,
    };
    let tiles: Vec<_> = (0..context.grid.count() as u32).map(of_tile).collect();
    let mut frame = Frame::default();
    frame.resize(settings);
    Renderer::new().merge(&context, &tiles, &mut frame).expect("fragments of these tiles");
    frame
}

/// Pictures of parts of the clusters, composed by their keys and ties.
fn composed(scene: &Scene, settings: &Settings, of: u32) -> Frame {
    let mut composed = draw(scene, &view(), settings);
    let (width, height) = (settings.width, settings.height);
    for y in 0..height {
        let row = (y * width) as usize..((y + 1) * width) as usize;
        composed.planes.fill(row, &Pixel::of_background(&scene.background, y, height));
    }
    for number in (0..of).rev() {
        let clusters = Part { number, of }.range(scene.cluster_count() as u32).into();
        let part = draw(scene, &view(), &Settings { clusters, ..settings.clone() }).planes;
        for pixel in 0..part.keys.len() {
            let key = |planes: &tercio_raster::frame::Planes| (planes.keys[pixel], planes.ties[pixel]);
            if key(&part) > key(&composed.planes) {
                let mut bytes = Vec::new();
                part.write_bytes(&settings.outputs, pixel..pixel + 1, &mut bytes);
                composed.planes.read_bytes(&settings.outputs, &bytes, pixel..pixel + 1);
            }
        }
    }
    composed
}

#[test]
fn pictures_are_those_of_smaller_numbers() {
    const COUNT: u64 = 150;
    for (alpha, opacity) in [(255, 1.0), (90, 1.0), (255, 0.4)] {
        let mesh = doubled(COUNT as usize, alpha);
        let mut plain = scene(&mesh);
        plain.instances[0].surface.opacity = opacity;
        for sampling in samplings() {
            // Many slices of layers.
            let settings = Settings { layer_memory: 1, ..settings(sampling) };
            let narrow = unnumbered(draw(&plain, &view(), &settings));
            for base in [LIMIT - 2 * COUNT, LIMIT - COUNT, LIMIT, 9 * LIMIT - COUNT, MAX_NUMBERS - 2 * COUNT]
            {
                let wide = numbered(plain.clone(), &[[base; 2]]);
                let what = format!("{sampling:?}, alpha {alpha}, opacity {opacity}, from {base}");
                let expected = reference::render(&[&mesh], &wide, &view(), &settings).expect("a picture");
                assert_same(&narrow, &unnumbered(expected.clone()), &format!("{what}: the reference"));
                assert_same(&expected, &draw(&wide, &view(), &settings), &what);
                assert_same(&expected, &merged(&wide, &settings, 3), &format!("{what}: fragments"));
                if sampling == Sampling::NONE && alpha == 255 && opacity == 1.0 {
                    assert_same(&expected, &composed(&wide, &settings, 3), &format!("{what}: keys"));
                }
            }
        }
    }
}

/// Layers of one depth, of which more than the memory holds: slices end between numbers.
#[test]
fn layers_of_one_depth_are_in_the_order_of_their_numbers() {
    const LAYERS: u32 = 9;
    let corners = [[-3.0, -3.0, 0.0], [3.0, -3.0, 0.0], [3.0, 3.0, 0.0], [-3.0, 3.0, 0.0]];
    let triangles = (0..LAYERS).flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|c| 4 * k + c)));
    let color = |k: u32| [(k * 83 % 256) as u8, (k * 47 % 256) as u8, (255 - k * 29 % 256) as u8, 60];
    let mesh = Mesh {
        positions: (0..LAYERS).flat_map(|_| corners).collect(),
        triangles: triangles.collect(),
        face_colors: Some((0..2 * LAYERS).map(|k| color(k / 2)).collect()),
        ..Mesh::default()
    };
    let (plain, camera) = (scene(&mesh), perspective([0.0, 0.0, 2.0], [0.0; 3], 40.0));
    for sampling in samplings() {
        let settings = Settings { layer_memory: 1, ..settings(sampling) };
        let narrow = unnumbered(draw(&plain, &camera, &settings));
        for base in [LIMIT - u64::from(LAYERS), LIMIT, 7 * LIMIT - 3] {
            let wide = numbered(plain.clone(), &[[base; 2]]);
            let what = format!("{sampling:?}, from {base}");
            let expected = reference::render(&[&mesh], &wide, &camera, &settings).expect("a picture");
            assert_same(&narrow, &unnumbered(expected.clone()), &format!("{what}: the reference"));
            assert_same(&expected, &draw(&wide, &camera, &settings), &what);
        }
    }
}

/// Lower numbers win, also where the lower halves of their bits are higher.
#[test]
fn the_lower_of_two_numbers_is_visible() {
    let mesh = doubled(150, 255);
    let both = coincident(scene(&mesh));
    let mut swapped = both.clone();
    swapped.instances.swap(0, 1);
    for sampling in samplings() {
        let settings = settings(sampling);
        let second = unnumbered(draw(&swapped, &view(), &settings));
        let first = unnumbered(draw(&both, &view(), &settings));
        assert!(first.planes.color != second.planes.color);
        let cases = [
            ([LIMIT, 1_000], &second),
            ([1_000, LIMIT], &first),
            ([5 * LIMIT, 4 * LIMIT + 7_000], &second),
            ([4 * LIMIT + 7_000, 5 * LIMIT], &first),
        ];
        for (bases, expected) in cases {
            let wide = numbered(both.clone(), &bases.map(|base| [base; 2]));
            let what = format!("{sampling:?}, from {bases:?}");
            let of_reference = reference::render(&[&mesh, &mesh], &wide, &view(), &settings);
            let of_reference = of_reference.expect("a picture");
            assert_same(expected, &unnumbered(of_reference.clone()), &format!("{what}: the reference"));
            assert_same(&of_reference, &draw(&wide, &view(), &settings), &what);
            assert_same(&of_reference, &merged(&wide, &settings, 4), &format!("{what}: fragments"));
        }
    }
}

/// All SIMD levels, sortings and threads.
#[test]
fn every_path_draws_the_same() {
    let plain = scene(&doubled(400, 255));
    let wide = numbered(plain, &[[LIMIT - 400; 2]]);
    let settings = settings(Sampling::NONE);
    let expected = draw(&wide, &view(), &settings);
    for simd in SimdLevel::available() {
        for sorting in [Sorting::Clusters, Sorting::Triangles] {
            let settings = Settings { simd: Some(simd), sorting, ..settings.clone() };
            assert_same(&expected, &draw(&wide, &view(), &settings), &format!("{simd}, {sorting:?}"));
        }
    }
    for (tile_size, threads) in [(8, 1), (32, 2), (128, 5)] {
        let settings = Settings { tile_size: Some(tile_size), ..settings.clone() };
        let drawn = with_threads(threads, || draw(&wide, &view(), &settings));
        assert_same(&expected, &drawn, &format!("tiles of {tile_size}, {threads} threads"));
    }
}

/// Where no number needs more than 32 bits, keys are what they are without ties, which are 0.
#[test]
fn ties_are_used_where_they_are_needed() {
    let mesh = doubled(150, 255);
    let count = 300;
    let planes = |base: u64| {
        let drawn = draw(&numbered(scene(&mesh), &[[base; 2]]), &view(), &settings(Sampling::NONE));
        (drawn.planes.keys, drawn.planes.ties)
    };
    let (keys, ties) = planes(0);
    assert!(ties.iter().all(|&tie| tie == 0) && keys.iter().any(|&key| key > 0));
    let last = u64::from(NO_PRIMITIVE) - 1 - count;
    let (moved, ties) = planes(last);
    assert!(ties.iter().all(|&tie| tie == 0));
    assert!(keys.iter().zip(moved).all(|(&key, moved)| key == 0 && moved == 0 || key - last == moved));
    let (wide, ties) = planes(last + 1);
    for ((key, wide), tie) in keys.into_iter().zip(wide).zip(ties) {
        let number = u64::from(NO_PRIMITIVE - key as u32) + last + 1;
        let expected = ((key >> 32 << 32) + ((u64::MAX - number) >> 32), (u64::MAX - number) as u32);
        assert_eq!((wide, tie), if key == 0 { (0, 0) } else { expected });
    }
}

#[test]
fn what_cannot_be_numbered_is_an_error() {
    let mesh = doubled(20, 255);
    let (plain, count) = (scene(&mesh), 40);
    let render = |base: [u64; 2], outputs: Outputs| {
        let settings = Settings { outputs, ..settings(Sampling::NONE) };
        Renderer::new()
            .render(&numbered(plain.clone(), &[base]), &view(), &settings)
            .map(|frame| frame.planes)
    };
    let ids = Outputs { ids: true, ..Outputs::NONE };
    let fitting = u64::from(NO_PRIMITIVE) - count;
    let drawn = render([LIMIT, fitting], ids).expect("ids of faces that fit");
    assert!(drawn.ids.iter().any(|&id| id != NO_PRIMITIVE && u64::from(id) >= fitting));
    assert_eq!(render([0, fitting + 1], ids), Err(RenderError::Ids { faces: LIMIT }));
    assert!(render([0, fitting + 1], Outputs::default()).is_ok());
    for base in [MAX_NUMBERS - count + 1, u64::MAX] {
        let error = |what| RenderError::TooMany { what, count: base.saturating_add(count) };
        assert_eq!(render([base, 0], Outputs::default()), Err(error("triangles")));
        assert_eq!(render([0, base], Outputs::default()), Err(error("faces")));
    }
}
