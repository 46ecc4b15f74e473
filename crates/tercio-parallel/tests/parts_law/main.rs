//! Ranks that hold parts of a model draw the bytes that one renderer draws of the whole.

mod kept;
mod model;
mod refused;
mod wide;

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use tercio_mesh::{ClusteredMesh, FileMaterial, Mesh};
use tercio_parallel::between_processes::draw_frame;
use tercio_parallel::comm::{Communicator, threads};
use tercio_parallel::organisation::{Rank, Task};
use tercio_parallel::{Composition, Division, FrameReport, Organisation, ParallelError, Sharing, parts};
use tercio_raster::{Frame, Outputs, Renderer, SamplePattern, Sampling, Settings, ShadowArea, ShadowMaps};
use tercio_scene::{
    Camera, ColorMap, DataColors, DataSource, Framing, InstanceMaterials, Light, Material, Projection, Scene,
    SurfaceData,
};

use model::{camera, in_parts, model, split, split_evenly, twice, whole};

const ALL: [Organisation; 5] = [
    Organisation::SortFirst,
    Organisation::SortMiddle,
    Organisation::SortLast,
    Organisation::SortTwice { group: 2 },
    Organisation::SortTwice { group: 3 },
];

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
        let (mut own, mut frame) = (Rank::new(), Frame::default());
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

/// Numbers of faces as data, without the plane of ids.
#[test]
fn numbers_of_faces_as_data() {
    let mesh = model("builtin:teapot@500", u8::MAX);
    let map = ColorMap::named("turbo").expect("a known map");
    let colors = Arc::new(DataColors::new("face", map, [0.0, 260.0]));
    let dress = |scene: &mut Scene| {
        let data = SurfaceData::Mapped { source: DataSource::Face, colors: Arc::clone(&colors) };
        scene.instances[0].data = Some(Arc::new(data));
    };
    for (ranks, pattern) in [(2, ONE), (5, SamplePattern::Sparse4)] {
        let outputs = Outputs { ids: false, ..Outputs::ALL };
        let settings = Settings { outputs, ..settings(pattern) };
        check(&mesh, &split_evenly(&mesh, ranks), dress, 2.0, &settings, sharings());
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
            Composition::ALL.into_iter().chain([Composition::radix_k(3)]).flat_map(|composition| {
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
    let far = camera(&scene.bounds(), 2.6);
    // So near that the map of the directional light has only what is seen.
    let near = Camera { projection: Projection::Perspective { fov_y: 0.1 }, ..far };
    for (camera, area) in [(far, ShadowArea::Scene), (near, ShadowArea::Picture)] {
        shadows_for(mesh, dress, &scene, (&camera, area));
    }
}

fn shadows_for(
    mesh: &Mesh,
    dress: impl Fn(&mut Scene) + Copy + Sync,
    scene: &Scene,
    view: (&Camera, ShadowArea),
) {
    let (&camera, area) = view;
    let settings = settings(SamplePattern::Sparse4);
    let maps = Arc::new(ShadowMaps::draw(scene, &camera, &settings, (64, area)).expect("maps"));
    let with = |maps: &Arc<ShadowMaps>| Settings { shadows: Some(maps.clone()), ..settings.clone() };
    let expected = Renderer::new().render(scene, &camera, &with(&maps)).expect("a picture");
    let bright = Renderer::new().render(scene, &camera, &settings).expect("a picture");
    assert_ne!(expected.planes.color, bright.planes.color, "there are shadows");
    for (ranks, organisation) in [1, 2, 5].into_iter().flat_map(|ranks| ALL.map(|o| (ranks, o))) {
        let parts = split_evenly(mesh, ranks);
        let frames = threads::run(ranks, |comm| {
            let scene = in_parts(comm, &parts, dress)?;
            let found = Arc::new(parts::shadow_maps(comm, &scene, &camera, &settings, (64, area))?);
            assert!(found == maps, "the maps of rank {} of {ranks}", comm.rank());
            let settings = with(&found);
            let sharing = organisation.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            let mut frame = Frame::default();
            draw_frame(&mut Rank::new(), comm, &task, &mut frame)?;
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
        check(&mesh, &parts, dress, radii, &settings, [Sharing { division, composition, ..organisation.into() }]);
    }
}
