//! Numbers of primitives that need more than 32 bits: the picture is that of smaller numbers in the same order.

use std::sync::Arc;

use tercio_mesh::Mesh;
use tercio_parallel::{Composition, Division, Encoding, Organisation, ParallelError, Sharing};
use tercio_raster::context::faces_of;
use tercio_raster::frame::NO_PRIMITIVE;
use tercio_raster::{Filter, Frame, Outputs, RenderError, Renderer, SamplePattern, Sampling, Settings};
use tercio_scene::{Instance, Scene, Share};

use crate::model::{camera, model, split, split_evenly, whole};
use crate::{ALL, ONE, check, draw, settings, sharings};

/// 2^32.
const LIMIT: u64 = 1 << 32;

/// A model, and all of its triangles once more in another order and other colours: at every sample are two of equal depth. Returns
/// the number of triangles that are there twice, too.
fn doubled(name: &str, alpha: u8) -> (Mesh, u64) {
    let mut mesh = model(name, alpha);
    let count = mesh.triangles.len();
    (mesh.vertex_colors, mesh.face_of_triangle) = (None, None);
    let again: Vec<[u32; 3]> = mesh.triangles.iter().rev().copied().collect();
    mesh.triangles.extend(again);
    let color =
        |k: usize| [(k * 37 % 256) as u8, if k < count { 230 } else { 20 }, (k / 3 % 256) as u8, alpha];
    mesh.face_colors = Some((0..2 * count).map(color).collect());
    (mesh, count as u64)
}

/// Numbers the triangles and faces of each instance from these numbers on.
fn number_from(scene: &mut Scene, bases: &[[u64; 2]]) {
    for (instance, &base) in scene.instances.iter_mut().zip(bases) {
        let (triangles, faces) = (instance.mesh.triangle_count() as u64, faces_of(&instance.mesh));
        let own = Share { triangles, faces, ..Share::default() };
        instance.share = Some(Share { base: Some(base), ..instance.share.unwrap_or(own) });
    }
}

/// A second instance at the same place, of one colour.
fn coincident(scene: &mut Scene) {
    let mut second = scene.instances[0].clone();
    second.surface.base_color = [0.9, 0.2, 0.1];
    second.surface.use_mesh_colors = false;
    scene.instances.push(second);
}

/// The planes that do not have numbers.
fn without_numbers(pattern: SamplePattern) -> Settings {
    let outputs = Outputs { keys: false, ties: false, ids: false, ..Outputs::ALL };
    Settings { outputs, ..settings(pattern) }
}

fn serial(mesh: &Mesh, dress: impl Fn(&mut Scene), radii: f64, settings: &Settings) -> Frame {
    let scene = whole(mesh, dress);
    Renderer::new().render(&scene, &camera(&scene.bounds(), radii), settings).expect("a picture")
}

/// Draws with these numbers, by one renderer and by ranks, and holds it against the picture of `narrow`.
#[track_caller]
fn check_wide(
    mesh: &Mesh,
    narrow: impl Fn(&mut Scene),
    dress: impl Fn(&mut Scene) + Sync,
    ranks: impl IntoIterator<Item = usize>,
    settings: &Settings,
    sharings: impl Iterator<Item = Sharing> + Clone,
) {
    let radii = 2.0;
    let expected = serial(mesh, narrow, radii, settings);
    assert_eq!(serial(mesh, &dress, radii, settings).difference(&expected), None, "serial");
    let keyed = Outputs { keys: true, ties: true, ..settings.outputs };
    for ranks in ranks {
        let parts = split_evenly(mesh, ranks);
        check(mesh, &parts, &dress, radii, settings, sharings.clone());
        let settings = Settings { outputs: keyed, ..settings.clone() };
        check(mesh, &parts, &dress, radii, &settings, sharings.clone());
    }
}

#[test]
fn every_number_of_ranks() {
    let (mesh, half) = doubled("builtin:gyroid@1k", u8::MAX);
    let bases = [LIMIT - half, LIMIT - 1, LIMIT, 7 * LIMIT - half, (1 << 50) - half];
    for (number, base) in bases.into_iter().enumerate() {
        let dress = |scene: &mut Scene| number_from(scene, &[[base; 2]]);
        let ranks = if number == 0 { vec![1, 2, 3, 4, 5, 6, 7, 8] } else { vec![3] };
        for pattern in [ONE, SamplePattern::Sparse4] {
            check_wide(&mesh, |_| (), dress, ranks.clone(), &without_numbers(pattern), sharings());
        }
    }
}

#[test]
fn every_division_and_composition() {
    let (mesh, half) = doubled("builtin:gyroid@500", u8::MAX);
    let dress = |scene: &mut Scene| number_from(scene, &[[LIMIT - half; 2]]);
    let divided = Division::ALL
        .into_iter()
        .map(|division| Sharing { division, ..Organisation::SortTwice { group: 3 }.into() });
    let organisations = [Organisation::SortLast, Organisation::SortTwice { group: 2 }];
    let compositions = Composition::ALL.into_iter().chain([Composition::radix_k(3)]);
    let composited = compositions.flat_map(|composition| {
        organisations.map(|organisation| Sharing { composition, ..organisation.into() })
    });
    for pattern in [ONE, SamplePattern::Sparse4] {
        let all = divided.clone().chain(composited.clone());
        check_wide(&mesh, |_| (), dress, [5, 8], &without_numbers(pattern), all);
    }
    let dense = composited.map(|sharing| Sharing { encoding: Encoding::Dense, ..sharing });
    check_wide(&mesh, |_| (), dress, [4, 7], &without_numbers(ONE), dense);
}

#[test]
fn what_is_not_opaque() {
    for (alpha, opacity) in [(100, 1.0), (255, 0.3)] {
        let (mesh, half) = doubled("builtin:soup@150", alpha);
        let clear = |scene: &mut Scene| scene.instances[0].surface.opacity = opacity;
        let dress = |scene: &mut Scene| {
            clear(scene);
            number_from(scene, &[[LIMIT - half; 2]]);
        };
        for pattern in [ONE, SamplePattern::Sparse4] {
            check_wide(&mesh, clear, dress, [2, 5], &without_numbers(pattern), sharings());
            // Many rounds, and slices of layers of one depth.
            let little = Settings { layer_memory: 1, ..without_numbers(pattern) };
            check_wide(&mesh, clear, dress, [3], &little, sharings());
        }
        let sampling = Sampling { filter: Filter::Tent, ..Sampling::of(SamplePattern::Sparse4) };
        let blurred = Settings { sampling, ..without_numbers(ONE) };
        check_wide(&mesh, clear, dress, [3], &blurred, sharings());
    }
}

/// The second instance has the lower numbers, of which the lower halves are above those of the first.
#[test]
fn instances_in_any_order_of_numbers() {
    let (mesh, _) = doubled("builtin:gyroid@500", u8::MAX);
    let swapped = |scene: &mut Scene| {
        coincident(scene);
        scene.instances.swap(0, 1);
    };
    for bases in [[[LIMIT; 2], [100_000; 2]], [[3 * LIMIT + 5; 2], [2 * LIMIT - 1; 2]]] {
        let dress = |scene: &mut Scene| {
            coincident(scene);
            number_from(scene, &bases);
        };
        for pattern in [ONE, SamplePattern::Sparse4] {
            check_wide(&mesh, swapped, dress, [1, 4, 5], &without_numbers(pattern), sharings());
        }
    }
}

/// Ids are numbers of faces, and there may be fewer of these than of triangles.
#[test]
fn ids_are_drawn_where_they_fit() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let faces = faces_of(&whole(&mesh, |_| ()).instances[0].mesh);
    let fitting = u64::from(NO_PRIMITIVE) - faces;
    let draw_from = |base: [u64; 2], sharing: Sharing| {
        let dress = move |scene: &mut Scene| number_from(scene, &[base]);
        let camera = camera(&whole(&mesh, dress).bounds(), 2.0);
        let settings = Settings { outputs: Outputs { ids: true, ..Outputs::NONE }, ..settings(ONE) };
        draw(&split_evenly(&mesh, 3), dress, &camera, &settings, sharing).map(|(frame, _)| frame.planes.ids)
    };
    for sharing in sharings() {
        let of_zero = draw_from([0; 2], sharing).expect("ids");
        for base in [[LIMIT + 9, 0], [LIMIT - 9, fitting]] {
            let ids = draw_from(base, sharing).expect("ids");
            let moved = of_zero.iter().map(|&id| if id == NO_PRIMITIVE { id } else { id + base[1] as u32 });
            assert!(ids.iter().copied().eq(moved), "{sharing:?}");
        }
        match draw_from([0, fitting + 1], sharing) {
            Err(ParallelError::Render(error)) => {
                assert_eq!(error, RenderError::Ids { faces: LIMIT });
                let text = error.to_string();
                assert!(text.contains("4294967296 faces") && text.contains("--output-ids"), "{text}");
            }
            other => panic!("{sharing:?}: {:?}", other.map(|_| ())),
        }
    }
}

/// What ranks keep from frame to frame has the numbers of its sender's part, and is gathered anew when numbers begin to need more
/// than 32 bits.
#[test]
fn clusters_are_kept() {
    use tercio_parallel::between_processes::draw_frame;
    use tercio_parallel::comm::threads;
    use tercio_parallel::organisation::{Rank, Task};

    let (mesh, half) = doubled("builtin:gyroid@500", u8::MAX);
    let settings = without_numbers(ONE);
    let parts = split(&mesh, &[0, 100, 100, half as usize + 5]);
    let bases = [0, 0, LIMIT - half, LIMIT - half, 2 * LIMIT - 3, 0];
    let place = camera(&whole(&mesh, |_| ()).bounds(), 2.0);
    let expected = serial(&mesh, |_| (), 2.0, &settings);
    for organisation in ALL {
        let frames = threads::run(parts.len(), |comm| {
            let mut scene = crate::in_parts(comm, &parts, |_| ())?;
            let mut own = Rank::new();
            let draw_from = |base: &u64| -> Result<_, ParallelError> {
                number_from(&mut scene, &[[*base; 2]]);
                let task =
                    Task { sharing: organisation.into(), scene: &scene, camera: &place, settings: &settings };
                let mut frame = Frame::default();
                let report = draw_frame(&mut own, comm, &task, &mut frame)?;
                Ok(report.map(|report| (frame, report)))
            };
            bases.iter().map(draw_from).collect::<Result<Vec<_>, _>>()
        });
        let frames = frames.expect("pictures").swap_remove(0);
        for (number, (frame, report)) in frames.into_iter().flatten().enumerate() {
            assert_eq!(frame.difference(&expected), None, "{organisation}, frame {number}");
            let sent: u64 = report.ranks.iter().filter_map(|rank| rank.clusters_sent).sum();
            let kept: u64 = report.ranks.iter().filter_map(|rank| rank.clusters_kept).sum();
            if organisation != Organisation::SortLast {
                // The second frame with the same numbers.
                let is_same = [1, 3].contains(&number);
                assert_eq!((sent == 0, kept > 0), (is_same, is_same), "{organisation}, frame {number}");
            }
        }
    }
}

/// An instance that several share is in memory once, whatever its numbers.
#[test]
fn instances_share_their_mesh() {
    let (mesh, half) = doubled("builtin:soup@150", u8::MAX);
    let dress = |scene: &mut Scene| {
        let first = scene.instances[0].clone();
        scene.instances.extend((0..3).map(|_| Instance { mesh: Arc::clone(&first.mesh), ..first.clone() }));
        number_from(scene, &[0, LIMIT - half, LIMIT, 9 * LIMIT].map(|base| [base; 2]));
    };
    check_wide(&mesh, |_| (), dress, [4], &without_numbers(ONE), sharings());
}
