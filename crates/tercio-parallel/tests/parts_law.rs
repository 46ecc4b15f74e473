//! Ranks that hold parts of a model draw the bytes that one renderer draws of the whole.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_mesh::{Aabb, ClusteredMesh, FileMaterial, Mesh, builtin, normals};
use tercio_parallel::between_processes::draw_frame;
use tercio_parallel::comm::threads::{self, ThreadComm};
use tercio_parallel::comm::{CommError, Communicator, Traffic};
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{
    Composition, Division, FrameReport, Organisation, ParallelError, PartsError, Ranks, Sharing, in_process,
    parts,
};
use tercio_raster::{Frame, Outputs, Renderer, SamplePattern, Sampling, Settings, ShadowMaps};
use tercio_scene::{Camera, Framing, Instance, InstanceMaterials, Light, Material, Projection, Scene, Share};

const ALL: [Organisation; 5] = [
    Organisation::SortFirst,
    Organisation::SortMiddle,
    Organisation::SortLast,
    Organisation::SortTwice { group: 2 },
    Organisation::SortTwice { group: 3 },
];

/// A model with normals, colours, and two triangles in most faces; some of the colours are not opaque if `alpha` is below 255.
fn model(name: &str, alpha: u8) -> Mesh {
    let mut mesh = builtin::make(name).expect("a model");
    normals::make_normals(&mut mesh, None);
    let shade = |k: usize| (k * 37 % 256) as u8;
    let vertices = mesh.positions.len();
    mesh.vertex_colors = Some((0..vertices).map(|k| [shade(k), shade(k / 7), 90, u8::MAX]).collect());
    let triangles = mesh.triangles.len();
    if alpha < u8::MAX {
        // Only at the end: most parts have none.
        let of = |k: usize| if k * 5 > triangles * 4 { alpha } else { u8::MAX };
        mesh.face_colors = Some((0..triangles).map(|k| [shade(k), 200, shade(k / 3), of(k)]).collect());
    }
    // A few faces have no triangles.
    mesh.face_of_triangle = Some((0..triangles as u32).map(|t| t / 2 + t / 100).collect());
    mesh
}

/// A range of a model's triangles, with the vertices that they use in the order of the model, and the number of faces up to the
/// first one of the triangles behind.
fn part(mesh: &Mesh, range: Range<usize>) -> (ClusteredMesh, u64) {
    let first_face = |at: usize| match &mesh.face_of_triangle {
        Some(faces) => faces.get(at).or(faces.last()).map_or(0, |&face| face + u32::from(at >= faces.len())),
        None => at as u32,
    };
    let mut used: Vec<u32> = mesh.triangles[range.clone()].as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let new = |old: u32| used.binary_search(&old).expect("a vertex in use") as u32;
    fn pick<T: Copy>(used: &[u32], values: &Option<Vec<T>>) -> Option<Vec<T>> {
        values.as_ref().map(|values| used.iter().map(|&v| values[v as usize]).collect())
    }
    fn cut<T: Copy>(range: &Range<usize>, values: &Option<Vec<T>>) -> Option<Vec<T>> {
        values.as_ref().map(|values| values[range.clone()].to_vec())
    }
    let begin = first_face(range.start);
    let own = Mesh {
        origin: mesh.origin,
        exponent: mesh.exponent,
        positions: used.iter().map(|&v| mesh.positions[v as usize]).collect(),
        triangles: mesh.triangles[range.clone()].iter().map(|t| t.map(new)).collect(),
        normals: pick(&used, &mesh.normals),
        vertex_colors: pick(&used, &mesh.vertex_colors),
        face_colors: cut(&range, &mesh.face_colors),
        texcoords: pick(&used, &mesh.texcoords),
        attributes: Vec::new(),
        materials: mesh.materials.clone(),
        triangle_materials: cut(&range, &mesh.triangle_materials),
        face_of_triangle: cut(&range, &mesh.face_of_triangle)
            .map(|faces| faces.into_iter().map(|face| face - begin).collect()),
    };
    let faces = u64::from(first_face(range.end) - begin);
    (partition(own, &PartitionOptions { max_triangles: 32, ..PartitionOptions::default() }), faces)
}

/// The parts between these cuts, which need not be in order.
fn split(mesh: &Mesh, cuts: &[usize]) -> Vec<(ClusteredMesh, u64)> {
    let mut cuts = cuts.to_vec();
    cuts.extend([0, mesh.triangles.len()]);
    cuts.sort_unstable();
    cuts.windows(2).map(|pair| part(mesh, pair[0]..pair[1])).collect()
}

/// About equal parts.
fn split_evenly(mesh: &Mesh, ranks: usize) -> Vec<(ClusteredMesh, u64)> {
    let cuts: Vec<usize> = (1..ranks).map(|k| mesh.triangles.len() * k / ranks).collect();
    split(mesh, &cuts)
}

fn whole(mesh: &Mesh, dress: impl Fn(&mut Scene)) -> Scene {
    let mut scene = Scene::from_mesh(partition(mesh.clone(), &PartitionOptions::default()));
    dress(&mut scene);
    scene
}

/// A rank's scene of its part.
fn in_parts(
    comm: &mut ThreadComm,
    parts: &[(ClusteredMesh, u64)],
    dress: impl Fn(&mut Scene),
) -> Result<Scene, ParallelError> {
    let (mut mesh, faces) = parts[comm.rank()].clone();
    let share = parts::number(comm, &mut mesh, faces)?;
    let mut scene = Scene::from_mesh(mesh);
    scene.instances[0].share = Some(share);
    dress(&mut scene);
    parts::share_materials(comm, &mut scene)?;
    Ok(scene)
}

/// Adds a second instance, rotated, mirrored, smaller, in the middle of the first.
fn twice(scene: &mut Scene) {
    let place = scene.bounds().center();
    let (scale, turn) = (DVec3::new(0.5, -0.4, 0.6), DQuat::from_rotation_y(1.0));
    let turned = DAffine3::from_scale_rotation_translation(scale, turn, place * 0.7);
    let second = Instance { world_from_object: turned, ..scene.instances[0].clone() };
    scene.instances.push(second);
}

/// A camera at this many radii from the centre; below 1 the near plane cuts the model.
fn camera(bounds: &Aabb, radii: f64) -> Camera {
    let eye = bounds.center() + DVec3::new(0.3, 0.4, 0.9).normalize() * bounds.radius() * radii;
    let target = bounds.center() + DVec3::X * 1e-3;
    let projection = Projection::Perspective { fov_y: 0.8 };
    Camera { eye, target, up: DVec3::Y, projection, near: None, shift: [0.0; 2] }
}

/// Draws parts with as many ranks.
fn draw(
    parts: &[(ClusteredMesh, u64)],
    dress: impl Fn(&mut Scene) + Sync,
    camera: &Camera,
    settings: &Settings,
    sharing: Sharing,
) -> Result<(Frame, FrameReport), ParallelError> {
    let results = threads::run(parts.len(), |comm| {
        let scene = in_parts(comm, parts, &dress)?;
        let task = Task { sharing, scene: &scene, camera, settings };
        let (mut own, mut frame) = (Rank::new(1)?, Frame::default());
        let report = draw_frame(&mut own, comm, &task, &mut frame)?;
        Ok(report.map(|report| (frame, report)))
    })?;
    Ok(results.into_iter().flatten().next().expect("rank 0 has the picture"))
}

/// Draws the whole with one renderer, and parts with ranks, and expects the same bytes.
#[track_caller]
fn check(
    mesh: &Mesh,
    parts: &[(ClusteredMesh, u64)],
    dress: impl Fn(&mut Scene) + Sync,
    radii: f64,
    settings: &Settings,
    sharings: impl IntoIterator<Item = Sharing>,
) {
    let scene = whole(mesh, &dress);
    let camera = camera(&scene.bounds(), radii);
    let expected = Renderer::new().render(&scene, &camera, settings).expect("a picture");
    let visible = expected.stats.backend.pixels_visible;
    for sharing in sharings {
        let what = format!("{} ranks, {sharing:?}, {:?}", parts.len(), settings.sampling.pattern);
        let (found, report) = draw(parts, &dress, &camera, settings, sharing).expect("a picture");
        if let Some(difference) = found.difference(&expected) {
            panic!("{what}: {difference}");
        }
        assert_eq!(report.pixels_visible(), visible, "{what}");
        // Every cluster is tested by the rank that has it.
        let clusters: usize = parts.iter().map(|(part, _)| part.clusters().len()).sum();
        let instances = scene.instances.len();
        assert_eq!(report.ranks.iter().map(|rank| rank.clusters).sum::<u64>(), (clusters * instances) as u64);
        assert_eq!(report.stats().frontend.clusters_in, (clusters * instances) as u64, "{what}");
    }
}

fn sharings() -> impl Iterator<Item = Sharing> + Clone {
    ALL.into_iter().map(Sharing::from)
}

fn settings(samples: SamplePattern) -> Settings {
    let sampling = Sampling::of(samples);
    Settings { outputs: Outputs::ALL, tile_size: Some(16), sampling, ..Settings::new(67, 49) }
}

const ONE: SamplePattern = SamplePattern::ALL[0];

#[test]
fn every_number_of_ranks() {
    let mesh = model("builtin:teapot@2k", u8::MAX);
    for ranks in 1..=9 {
        let parts = split_evenly(&mesh, ranks);
        check(&mesh, &parts, twice, 2.6, &settings(ONE), sharings());
        check(&mesh, &parts, twice, 0.5, &settings(SamplePattern::Sparse4), sharings());
    }
}

/// Without ids, the numbers of faces are not sent.
#[test]
fn every_division_and_composition() {
    let mesh = model("builtin:gyroid@2k", u8::MAX);
    for (ranks, pattern) in [(2, ONE), (5, ONE), (5, SamplePattern::Sparse4), (8, ONE)] {
        let parts = split_evenly(&mesh, ranks);
        let settings = Settings { outputs: Outputs::default(), ..settings(pattern) };
        let divided = Division::ALL.into_iter().flat_map(|division| {
            [Organisation::SortFirst, Organisation::SortTwice { group: 3 }]
                .map(|organisation| Sharing { division, ..organisation.into() })
        });
        let composited =
            Composition::ALL.into_iter().chain([Composition::RadixK(3)]).flat_map(|composition| {
                [Organisation::SortLast, Organisation::SortTwice { group: 2 }]
                    .map(|organisation| Sharing { composition, ..organisation.into() })
            });
        check(&mesh, &parts, twice, 2.0, &settings, divided.chain(composited));
    }
}

#[test]
fn what_is_not_opaque() {
    let clear = |scene: &mut Scene| {
        twice(scene);
        scene.instances[1].surface.opacity = 0.3;
    };
    for (mesh, ranks) in [(model("builtin:soup@600", u8::MAX), 3), (model("builtin:soup@600", 100), 5)] {
        let parts = split_evenly(&mesh, ranks);
        for pattern in [ONE, SamplePattern::Sparse4] {
            check(&mesh, &parts, clear, 1.5, &settings(pattern), sharings());
            check(&mesh, &parts, |_| (), 1.5, &settings(pattern), sharings());
            // Many rounds.
            let little = Settings { layer_memory: 1, ..settings(pattern) };
            check(&mesh, &parts, twice, 0.5, &little, sharings());
        }
    }
}

/// Materials of the scene, of which one is not opaque; only the last part has triangles with it.
#[test]
fn materials() {
    let mut mesh = model("builtin:gyroid@2k", u8::MAX);
    let triangles = mesh.triangles.len();
    mesh.vertex_colors = None;
    mesh.materials =
        ["a", "b", "c"].map(|name| FileMaterial { name: name.into(), ..FileMaterial::default() }).to_vec();
    mesh.triangle_materials =
        Some((0..triangles).map(|k| if k * 10 > triangles * 9 { 2 } else { k as u32 / 50 % 2 }).collect());
    let dress = |scene: &mut Scene| {
        let colors = [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.2, 0.3, 0.9]];
        scene.materials =
            colors.map(|base_color| Material { base_color, roughness: 0.4, ..Material::default() }).to_vec();
        scene.materials[2].opacity = 0.4;
        let mesh = scene.instances[0].mesh.clone();
        scene.instances[0].materials = Some(InstanceMaterials::new(&mesh, vec![0, 1, 2], scene));
        twice(scene);
        scene.instances[1].materials = None;
    };
    for (ranks, pattern) in [(1, ONE), (4, ONE), (5, SamplePattern::Sparse4)] {
        check(&mesh, &split_evenly(&mesh, ranks), dress, 2.0, &settings(pattern), sharings());
    }
}

#[test]
fn parts_of_any_size() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let all = mesh.triangles.len();
    // Empty parts, everything in one, and faces whose triangles are in two parts.
    for cuts in [vec![0, 0], vec![0, all], vec![all, all, all], vec![1, 7, 7, all - 1], vec![3, 5]] {
        check(&mesh, &split(&mesh, &cuts), twice, 2.6, &settings(ONE), sharings());
    }
    let mut four = model("builtin:teapot@500", 120);
    (four.triangles, four.face_of_triangle) = (four.triangles[..4].to_vec(), None);
    four.face_colors.as_mut().expect("colours").truncate(4);
    check(&four, &split(&four, &[1, 1, 2, 3, 3, 4, 4, 4]), twice, 2.0, &settings(ONE), sharings());
    // Nothing at all.
    let empty = Mesh { triangles: Vec::new(), face_colors: Some(Vec::new()), ..four };
    check(&empty, &split(&empty, &[0, 0]), |_| (), 2.0, &settings(ONE), sharings());
}

#[test]
fn shadows() {
    // What is invisible casts none.
    for alpha in [u8::MAX, 100, 0] {
        shadows_of(&model("builtin:gyroid@2k", alpha));
    }
}

fn shadows_of(mesh: &Mesh) {
    let dress = |scene: &mut Scene| {
        twice(scene);
        let center = scene.bounds().center();
        let position = center + DVec3::new(0.5, 3.0, 0.5) * scene.bounds().radius();
        scene.lights = Light::sunlit_studio();
        let space = tercio_scene::LightSpace::World;
        scene.lights.push(Light::Point { position, color: [0.3; 3], space });
    };
    let scene = whole(mesh, dress);
    let camera = camera(&scene.bounds(), 2.6);
    let settings = settings(SamplePattern::Sparse4);
    let maps = Arc::new(ShadowMaps::draw(&scene, &camera, &settings, 64).expect("maps"));
    let with = |maps: &Arc<ShadowMaps>| Settings { shadows: Some(maps.clone()), ..settings.clone() };
    let expected = Renderer::new().render(&scene, &camera, &with(&maps)).expect("a picture");
    let bright = Renderer::new().render(&scene, &camera, &settings).expect("a picture");
    assert_ne!(expected.planes.color, bright.planes.color, "there are shadows");
    for (ranks, organisation) in [1, 2, 5].into_iter().flat_map(|ranks| ALL.map(|o| (ranks, o))) {
        let parts = split_evenly(mesh, ranks);
        let frames = threads::run(ranks, |comm| {
            let scene = in_parts(comm, &parts, dress)?;
            let found = Arc::new(parts::shadow_maps(comm, &scene, &camera, &settings, 64)?);
            assert!(found == maps, "the maps of rank {} of {ranks}", comm.rank());
            let settings = with(&found);
            let sharing = organisation.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            let mut frame = Frame::default();
            draw_frame(&mut Rank::new(1)?, comm, &task, &mut frame)?;
            Ok(frame)
        });
        assert_eq!(frames.expect("pictures")[0].difference(&expected), None, "{ranks} ranks, {organisation}");
    }
}

#[test]
fn the_camera_frames_the_whole() {
    let framings = [
        Framing::new(4, 3),
        Framing { fov_y: None, azimuth: 77.0, elevation: -31.0, ..Framing::new(3, 5) },
        Framing { fov_y: Some(70.0), azimuth: -100.0, roll: 20.0, ..Framing::new(16, 9) },
    ];
    let mesh = model("builtin:teapot@2k", u8::MAX);
    let nothing = Mesh { triangles: Vec::new(), face_of_triangle: None, ..mesh.clone() };
    let mut point = Mesh { triangles: vec![[0; 3]; 2], face_of_triangle: None, ..mesh.clone() };
    point.positions.truncate(1);
    for (mesh, dress) in
        [(&mesh, twice as fn(&mut Scene)), (&mesh, |_| ()), (&nothing, |_| ()), (&point, |_| ())]
    {
        let scene = whole(mesh, dress);
        for (ranks, framing) in [1, 2, 3, 8].into_iter().flat_map(|ranks| framings.map(|f| (ranks, f))) {
            let parts = split_evenly(mesh, ranks);
            let found = threads::run(ranks, |comm| {
                let scene = in_parts(comm, &parts, dress)?;
                parts::camera_for_scene(comm, &framing, &scene)
            });
            assert_eq!(found.expect("cameras"), vec![framing.camera_for_scene(&scene); ranks]);
        }
    }
}

/// The error of ranks with these parts.
fn error_of(parts: &[(ClusteredMesh, u64)]) -> ParallelError {
    let numbered = threads::run(parts.len(), |comm| {
        let (mut mesh, faces) = parts[comm.rank()].clone();
        parts::number(comm, &mut mesh, faces)
    });
    numbered.expect_err("no parts of one model")
}

#[test]
fn parts_of_different_models_are_refused() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let change = |change: fn(&mut Mesh)| {
        let mut changed = mesh.clone();
        change(&mut changed);
        let (own, other) = (split_evenly(&mesh, 3), split_evenly(&changed, 3));
        let parts = [own[0].clone(), own[1].clone(), other[2].clone()];
        error_of(&parts).to_string()
    };
    assert!(change(|mesh| mesh.origin.x += 1.0).contains("rank 2 has a part of a model with another origin"));
    assert!(change(|mesh| mesh.exponent += 1).contains("another unit"));
    assert!(change(|mesh| mesh.normals = None).contains("other normals"));
    assert!(change(|mesh| mesh.materials.push(FileMaterial::default())).contains("other materials"));
    let mut many = split_evenly(&mesh, 2);
    many[1].1 = u64::from(u32::MAX);
    assert!(matches!(error_of(&many), ParallelError::Parts(PartsError::TooLarge { .. })));
}

#[test]
fn parts_that_do_not_make_a_model_are_refused() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let parts = split_evenly(&mesh, 2);
    let camera = camera(&whole(&mesh, |_| ()).bounds(), 2.0);
    let settings = settings(ONE);
    let error = |change: fn(usize, &mut Scene)| {
        let drawn = threads::run(2, |comm| {
            let mut scene = in_parts(comm, &parts, twice)?;
            change(comm.rank(), &mut scene);
            let sharing = Organisation::SortLast.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            Rank::new(1)?.draw_into(comm, &task, &mut Frame::default())
        });
        match drawn.expect_err("no model") {
            ParallelError::Parts(error) => error,
            error => panic!("{error}"),
        }
    };
    assert_eq!(error(|_, scene| scene.instances[1].share = None), PartsError::Whole { instance: 1 });
    let late = |rank: usize, scene: &mut Scene| {
        let share = &mut scene.instances[1].share;
        *share = share.map(|share| Share { first_triangle: share.first_triangle + rank as u64, ..share });
    };
    assert!(matches!(error(late), PartsError::Share { instance: 1, rank: 1, .. }));
    let translucent =
        |rank: usize, scene: &mut Scene| scene.instances[0].surface.opacity -= rank as f32 * 0.5;
    assert_eq!(error(translucent), PartsError::Translucency { instance: 0, rank: 1 });

    // One part on all ranks of a process, or alone.
    let scenes = threads::run(2, |comm| in_parts(comm, &parts, |_| ())).expect("scenes");
    for (rank, count) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
        let ranks = Ranks { count, threads: 1, sharing: Organisation::SortLast.into() };
        let drawn = in_process::draw(ranks, &scenes[rank], &camera, &settings);
        assert!(matches!(drawn, Err(ParallelError::Parts(PartsError::Share { .. }))), "{rank} of {count}");
    }
}

/// Changes the messages between ranks 1 and 2.
struct Damaging<'a, F> {
    comm: &'a mut ThreadComm,
    damage: F,
}

impl<F: Fn(&mut Vec<u8>)> Communicator for Damaging<'_, F> {
    fn rank(&self) -> usize {
        self.comm.rank()
    }
    fn size(&self) -> usize {
        self.comm.size()
    }
    fn send(&mut self, to: usize, mut message: Vec<u8>) -> Result<(), CommError> {
        // Clusters are by far the longest messages.
        if self.rank() == 1 && to == 2 && message.len() > 1000 {
            (self.damage)(&mut message);
        }
        self.comm.send(to, message)
    }
    fn receive(&mut self, from: usize) -> Result<Vec<u8>, CommError> {
        self.comm.receive(from)
    }
    fn traffic(&self) -> Traffic {
        self.comm.traffic()
    }
    fn signal(&mut self, to: usize) -> Result<(), CommError> {
        self.comm.signal(to)
    }
    fn await_signal(&mut self, from: usize) -> Result<(), CommError> {
        self.comm.await_signal(from)
    }
}

#[test]
fn damaged_messages_are_errors() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let parts = split_evenly(&mesh, 3);
    let camera = camera(&whole(&mesh, |_| ()).bounds(), 2.0);
    let settings = settings(ONE);
    let draw = |damage: &(dyn Fn(&mut Vec<u8>) + Sync)| {
        threads::run(3, |comm| {
            let scene = in_parts(comm, &parts, |_| ())?;
            let sharing = Organisation::SortMiddle.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            let comm = &mut Damaging { comm, damage };
            Rank::new(1)?.draw_into(comm, &task, &mut Frame::default())
        })
    };
    let length = std::sync::atomic::AtomicUsize::new(0);
    let note = |message: &mut Vec<u8>| length.store(message.len(), std::sync::atomic::Ordering::SeqCst);
    draw(&note).expect("a picture");
    let length = length.into_inner();
    assert!(length > 1000, "clusters are sent");
    let mut errors = 0;
    for at in (0..length).step_by(length / 60) {
        let shorter = draw(&|message: &mut Vec<u8>| message.truncate(at)).expect_err("a shorter message");
        let other = draw(&|message: &mut Vec<u8>| message[at] ^= 0xff);
        for error in [Some(shorter), other.err()].into_iter().flatten() {
            errors += 1;
            let is_expected = matches!(
                error,
                ParallelError::Clusters { from: 1, .. }
                    | ParallelError::Comm(CommError::Transport { rank: 1, .. })
            );
            assert!(is_expected, "byte {at}: {error}");
        }
    }
    assert!(errors > 70, "{errors}");
    let longer = draw(&|message: &mut Vec<u8>| message.push(0)).expect_err("a longer message");
    assert!(longer.to_string().contains("not clusters of 1 instances"), "{longer}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_parts(
        name in prop::sample::select(vec!["builtin:teapot@1k", "builtin:soup@300", "builtin:gyroid@1k"]),
        cuts in prop::collection::vec(0.0..1.0, 0..8),
        alpha in prop::sample::select(vec![255u8, 60]),
        opacity in prop::sample::select(vec![1.0f32, 0.3]),
        pattern in prop::sample::select(SamplePattern::ALL.to_vec()),
        (organisation, group) in (0usize..4, 1usize..5),
        division in prop::sample::select(Division::ALL.to_vec()),
        composition in prop::sample::select(Composition::ALL.to_vec()),
        (radii, second, tile) in (0.3..3.0, any::<bool>(), prop::sample::select(vec![None, Some(8), Some(64)])),
        ids in any::<bool>(),
    ) {
        let mesh = model(name, alpha);
        let cuts: Vec<usize> = cuts.iter().map(|c| (c * mesh.triangles.len() as f64) as usize).collect();
        let parts = split(&mesh, &cuts);
        let organisation = [
            Organisation::SortFirst,
            Organisation::SortMiddle,
            Organisation::SortLast,
            Organisation::SortTwice { group },
        ][organisation];
        let settings =
            Settings { tile_size: tile, outputs: Outputs { ids, ..Outputs::ALL }, ..settings(pattern) };
        let dress = |scene: &mut Scene| {
            if second {
                twice(scene);
            }
            scene.instances[0].surface.opacity = opacity;
        };
        check(&mesh, &parts, dress, radii, &settings, [Sharing { organisation, division, composition }]);
    }
}
