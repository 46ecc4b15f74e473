//! Ranks that communicate only by messages: picture and counts are those of ranks in one process.

use std::sync::Arc;

use glam::DVec3;
use tercio_mesh::builtin;
use tercio_mesh::cluster::{PartitionOptions, partition};
use tercio_parallel::between_processes::{draw_frame, gather_trace};
use tercio_parallel::comm::{CommError, Communicator as _, Kind, Traffic, threads};
use tercio_parallel::organisation::{Rank, Task, tile_edge};
use tercio_parallel::report::RankStages;
use tercio_parallel::trace::{Span, Step, now};
use tercio_parallel::{
    Composition, Division, FrameReport, Matter, Organisation, ParallelError, Ranks, Sharing, in_process,
};
use tercio_raster::stats::StageTimes;
use tercio_raster::{Cull, Frame, Settings, SimdLevel};
use tercio_scene::{Background, Camera, Projection, Scene, SurfaceEdges};

/// A scene and a camera, made anew as in every process.
fn made() -> (Scene, Camera) {
    let mesh = builtin::make("builtin:teapot@5k").expect("a model");
    let scene = Scene::from_mesh(Arc::new(partition(mesh, &PartitionOptions::default())));
    let bounds = scene.bounds();
    let eye = bounds.center() + DVec3::new(0.3, 0.4, 0.9) * bounds.radius() * 2.5;
    let projection = Projection::Perspective { fov_y: 0.8 };
    let camera =
        Camera { eye, target: bounds.center(), up: DVec3::Y, projection, near: None, shift: [0.0; 2] };
    (scene, camera)
}

/// The parts of a report that do not change from run to run.
fn counts(mut report: FrameReport) -> FrameReport {
    report.milliseconds = 0.0;
    for rank in &mut report.ranks {
        rank.stages = RankStages::default();
        rank.frame.milliseconds = StageTimes::default();
        // Each draws in the pool that it is called in.
        rank.frame.threads = 0;
        // Threads of one process wait for each other, processes agree and report.
        let is_control = |kind| matches!(kind, Kind::Agreement | Kind::Barrier | Kind::Report);
        rank.partners.retain(|with| !is_control(with.kind));
    }
    report
}

#[test]
fn picture_and_counts_are_those_of_ranks_in_one_process() {
    for organisation in [
        Organisation::SortFirst,
        Organisation::SortMiddle,
        Organisation::SortLast,
        Organisation::SortTwice { group: 2 },
    ] {
        for count in [1, 2, 3, 7] {
            // So few regions that the last ranks own none.
            let settings = Settings { tile_size: Some(64), ..Settings::one_sample(150, 100) };
            let results = threads::run(count, |comm| {
                let (scene, camera) = made();
                let task = Task {
                    sharing: organisation.into(),
                    scene: &scene,
                    camera: &camera,
                    settings: &settings,
                };
                let (mut own, mut frame) = (Rank::new(), Frame::default());
                let report = draw_frame(&mut own, comm, &task, &mut frame)?;
                Ok(report.map(|report| (frame, report)))
            });
            let mut results = results.expect("a picture").into_iter();
            let (frame, report) = results.next().flatten().expect("rank 0 has the picture");
            assert!(results.all(|r| r.is_none()), "others have a report");
            let (scene, camera) = made();
            let ranks = Ranks { count, threads: 1, sharing: organisation.into() };
            let (expected, expected_report) =
                in_process::draw(ranks, &scene, &camera, &settings).expect("a picture");
            assert!(frame.planes.color == expected.planes.color, "{organisation:?}, {count} ranks");
            assert_eq!(frame.stats.backend, expected.stats.backend);
            assert_eq!(counts(report), counts(expected_report), "{organisation:?}, {count} ranks");
        }
    }
}

/// What one rank has sent another one is what that has received, of every kind; and it is what the ranks count in all.
#[test]
fn partners_count_the_same_messages() {
    const RANKS: usize = 5;
    let settings = Settings { tile_size: Some(16), ..Settings::new(150, 100) };
    for organisation in
        [Organisation::SortMiddle, Organisation::SortLast, Organisation::SortTwice { group: 2 }]
    {
        let drawn = |tells: bool| {
            let mut reports = threads::run(RANKS, |comm| {
                let (mut scene, camera) = made();
                scene.instances[0].surface.opacity = 0.5;
                let sharing = organisation.into();
                let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
                let mut own = Rank::new();
                own.tell_partners(tells);
                draw_frame(&mut own, comm, &task, &mut Frame::default())
            });
            reports.as_mut().expect("a picture").remove(0).expect("rank 0 has the report")
        };
        assert!(drawn(false).ranks.iter().all(|rank| rank.partners.is_empty()));
        let report = drawn(true);
        let with = |rank: usize, partner: usize, kind: Kind| {
            let found =
                report.ranks[rank].partners.iter().find(|of| (of.partner, of.kind) == (partner, kind));
            found.map(|of| of.traffic).unwrap_or_default()
        };
        for kind in Kind::ALL {
            for (rank, partner) in (0..RANKS).flat_map(|rank| (0..RANKS).map(move |other| (rank, other))) {
                assert_eq!(with(rank, partner, kind), with(partner, rank, kind).reversed(), "{kind:?}");
            }
        }
        let is_control = |kind: Kind| matches!(kind, Kind::Agreement | Kind::Barrier | Kind::Report);
        for rank in &report.ranks {
            let of_frame = rank.partners.iter().filter(|of| !is_control(of.kind));
            assert_eq!(of_frame.fold(Traffic::default(), |sum, of| sum.plus(of.traffic)), rank.traffic);
        }
        let kinds: Vec<Kind> = report.by_kind().into_iter().map(|of| of.0).collect();
        for (kind, is_sent) in [
            (Kind::Agreement, true),
            (Kind::Touched, organisation.composites(RANKS)),
            (Kind::Bins, organisation.group(RANKS) > 1),
            (Kind::Round, organisation.composites(RANKS)),
            (Kind::Pixels, false),
            (Kind::Fragments, organisation.composites(RANKS)),
            (Kind::Finished, true),
            (Kind::Report, true),
        ] {
            assert_eq!(kinds.contains(&kind), is_sent, "{organisation:?}, {kind:?}");
        }
        let agreement = |rank: usize| with(rank, 0, Kind::Agreement);
        // A child tells its parent once, and is told once.
        assert_eq!((agreement(1).sent_messages, agreement(1).taken_messages), (1, 1));
    }
}

/// Each rank does one thing at a time, and what it does in a frame is in the frame.
#[test]
fn what_ranks_do_when_is_recorded_on_request() {
    let settings = Settings { tile_size: Some(16), ..Settings::one_sample(150, 100) };
    let begin = now();
    let trace = threads::run(4, |comm| {
        let (scene, camera) = made();
        let sharing = Organisation::SortTwice { group: 2 }.into();
        let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
        let mut own = Rank::new();
        // Nothing is recorded of the first frame.
        draw_frame(&mut own, comm, &task, &mut Frame::default())?;
        own.record();
        own.record_step(Step::Load, 0, Span { begin, end: begin + 1 });
        for _ in 0..2 {
            draw_frame(&mut own, comm, &task, &mut Frame::default())?;
        }
        gather_trace(&mut own, comm)
    });
    let mut trace = trace.expect("pictures").into_iter();
    let ranks = trace.next().flatten().expect("rank 0 has the trace").ranks;
    assert!(trace.all(|other| other.is_none()) && ranks.len() == 4);
    for (rank, timeline) in ranks.into_iter().enumerate() {
        let mut events = timeline.events;
        events.sort_by_key(|event| event.span.begin);
        assert_eq!((events[0].step, events[0].frame), (Step::Load, 0));
        for pair in events.windows(2) {
            assert!(pair[0].span.end <= pair[1].span.begin, "rank {rank}: {pair:?}");
            assert!(pair[0].frame <= pair[1].frame, "rank {rank}: {pair:?}");
        }
        assert!(events.iter().all(|event| (begin..=now()).contains(&event.span.end)));
        for frame in [2, 3] {
            let steps: Vec<Step> = events.iter().filter(|e| e.frame == frame).map(|e| e.step).collect();
            assert_eq!((steps.first(), steps.last()), (Some(&Step::Agree), Some(&Step::Report)));
            for step in
                [Step::FrontEnd, Step::Redistribute, Step::Draw, Step::Composite, Step::Collect, Step::Wait]
            {
                assert!(steps.contains(&step), "rank {rank}, frame {frame}: {step:?} is not in {steps:?}");
            }
        }
    }
    // In one process there is nothing to agree on or to report.
    let (scene, camera) = made();
    let ranks = Ranks { count: 2, threads: 1, sharing: Organisation::SortFirst.into() };
    let (frame, report, trace) =
        in_process::Crew::default().record(ranks, &scene, &camera, &settings).expect("a picture");
    let (expected, not_recorded) = in_process::draw(ranks, &scene, &camera, &settings).expect("a picture");
    assert!(frame.planes.color == expected.planes.color);
    assert_eq!(counts(report), counts(not_recorded));
    let has = |rank: usize, step: Step| trace.ranks[rank].events.iter().any(|event| event.step == step);
    assert!((0..2).all(|rank| has(rank, Step::FrontEnd) && has(rank, Step::Draw) && has(rank, Step::Wait)));
    assert!(!has(0, Step::Agree) && !has(1, Step::Report));
}

/// A rank's own task.
struct Own {
    sharing: Sharing,
    scene: Scene,
    camera: Camera,
    settings: Settings,
}

/// What rank 0 reports if the last of three ranks changes its task.
fn reported(change: impl Fn(&mut Own) + Sync) -> Option<Matter> {
    let results = threads::run(3, |comm| {
        let (scene, camera) = made();
        let settings = Settings::new(60, 40);
        let mut own = Own { sharing: Organisation::SortLast.into(), scene, camera, settings };
        if comm.rank() == 2 {
            change(&mut own);
        }
        let Own { sharing, scene, camera, settings } = &own;
        let task = Task { sharing: *sharing, scene, camera, settings };
        draw_frame(&mut Rank::new(), comm, &task, &mut Frame::default())
    });
    match results {
        Ok(_) => None,
        Err(ParallelError::Differs { rank: 2, what }) => Some(what),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn ranks_that_would_draw_different_frames_end_with_an_error() {
    let other_mesh = |own: &mut Own| {
        // One vertex is elsewhere.
        let mut mesh = builtin::make("builtin:teapot@5k").expect("a model");
        mesh.positions[77][1] += 1e-3;
        own.scene.instances[0].mesh = Arc::new(partition(mesh, &PartitionOptions::default()));
    };
    assert_eq!(reported(other_mesh), Some(Matter::Models));
    assert_eq!(reported(|own| own.scene.instances.clear()), Some(Matter::Models));
    assert_eq!(reported(|own| own.scene.instances[0].surface.specular = 0.3), Some(Matter::Scene));
    assert_eq!(
        reported(|own| own.scene.instances[0].world_from_object.translation.x = 1e-9),
        Some(Matter::Scene)
    );
    assert_eq!(reported(|own| own.scene.background = Background::Solid([0.5; 4])), Some(Matter::Scene));
    let shows = |band: u32| {
        move |own: &mut Own| {
            let map = tercio_scene::ColorMap::named("viridis").expect("a known map");
            let mut colors = tercio_scene::DataColors::new("x", map, [0.0, 1.0]);
            // Two of the three ranks draw without data.
            colors.bands = Some(band);
            let source = tercio_scene::DataSource::Face;
            let data = tercio_scene::SurfaceData::Mapped { source, colors: Arc::new(colors) };
            own.scene.instances[0].data = Some(Arc::new(data));
        }
    };
    assert_eq!(reported(shows(3)), Some(Matter::Scene));
    assert_eq!(reported(|own| _ = own.scene.lights.pop()), Some(Matter::Scene));
    let edges = |of: fn(usize) -> Option<Vec<u8>>| {
        reported(move |own| {
            let instance = &mut own.scene.instances[0];
            let sides = of(instance.mesh.triangle_count());
            instance.edges = Some(Arc::new(SurfaceEdges::new([255, 0, 0], 1.0, sides)));
        })
    };
    assert_eq!(edges(|_| None), Some(Matter::Scene));
    assert_eq!(edges(|triangles| Some(vec![5; triangles])), Some(Matter::Scene));
    assert_eq!(reported(|own| own.camera.eye.x += 1e-9), Some(Matter::Camera));
    assert_eq!(reported(|own| own.settings.width += 1), Some(Matter::Size));
    assert_eq!(reported(|own| own.settings.cull = Cull::Back), Some(Matter::Settings));
    assert_eq!(reported(|own| own.settings.tile_size = Some(8)), Some(Matter::Settings));
    assert_eq!(reported(|own| own.settings.outputs.depth = true), Some(Matter::Settings));
    let sharing = |change: fn(&mut Sharing)| reported(move |own| change(&mut own.sharing));
    assert_eq!(sharing(|own| own.organisation = Organisation::SortFirst), Some(Matter::Organisation));
    assert_eq!(sharing(|own| own.division = Division::Rows), Some(Matter::Organisation));
    assert_eq!(sharing(|own| own.composition = Composition::radix_k(3)), Some(Matter::Organisation));
    // What may differ from machine to machine.
    assert_eq!(reported(|own| own.settings.simd = Some(SimdLevel::available()[0])), None);
    assert_eq!(reported(|own| own.settings.layer_memory = 1), None);
    assert_eq!(reported(|_| ()), None);
}

/// Ranks that share the picture choose smaller tiles than one of them would, unless the settings choose the size.
#[test]
fn ranks_with_tiles_of_different_sizes_end_with_an_error() {
    const RANKS: usize = 6;
    let drawn = |chosen: Option<u32>| {
        threads::run(RANKS, |comm| {
            let (scene, camera) = made();
            let tile_size = chosen.filter(|_| comm.rank() > 0);
            let settings = Settings { tile_size, ..Settings::one_sample(800, 600) };
            let sharing = Organisation::SortFirst.into();
            let task = Task { sharing, scene: &scene, camera: &camera, settings: &settings };
            draw_frame(&mut Rank::new(), comm, &task, &mut Frame::default())
        })
    };
    let (scene, _) = made();
    let settings = Settings::one_sample(800, 600);
    let edge = tile_edge(&scene, &settings, Organisation::SortFirst, RANKS);
    assert_eq!((settings.tile_edge(), edge), (64, 32));
    assert_eq!(tile_edge(&scene, &settings, Organisation::SortLast, RANKS), 64);
    assert!(drawn(Some(edge)).is_ok(), "the same tiles");
    let error = drawn(Some(64)).err();
    assert!(matches!(error, Some(ParallelError::Differs { rank: 1, what: Matter::Settings })), "{error:?}");
}

/// Without a comparison of their tasks, ranks notice by the first message that theirs differ.
#[test]
fn a_message_of_another_frame_is_an_error() {
    const ORGANISATIONS: [Organisation; 4] = [
        Organisation::SortFirst,
        Organisation::SortMiddle,
        Organisation::SortLast,
        Organisation::SortTwice { group: 2 },
    ];
    let (scene, camera) = made();
    let settings = Settings { tile_size: Some(16), ..Settings::one_sample(150, 100) };
    let other = Camera { near: Some(1e-3), ..camera };
    let drawn = |organisation: Organisation, camera_of_2: &Camera, ahead: bool| {
        threads::run(3, |comm| {
            let own_camera = if comm.rank() == 2 { camera_of_2 } else { &camera };
            let sharing = organisation.into();
            let task = Task { sharing, scene: &scene, camera: own_camera, settings: &settings };
            let mut own = Rank::new();
            if ahead && comm.rank() == 2 {
                // This rank counts one frame more than the others.
                let mut alone = threads::ThreadComm::for_ranks(1).remove(0);
                own.draw_into(&mut alone, &task, &mut Frame::default())?;
            }
            own.draw_into(comm, &task, &mut Frame::default())
        })
    };
    for organisation in ORGANISATIONS {
        assert!(drawn(organisation, &camera, false).is_ok());
        for (camera, ahead, says) in [(&other, false, "of another task"), (&camera, true, "of frame ")] {
            let error = drawn(organisation, camera, ahead).expect_err("rank 2 draws something else");
            let ParallelError::Comm(CommError::Unexpected { found, .. }) = error else { panic!("{error}") };
            assert!(found.contains(says), "{organisation:?}: {found}");
        }
    }
}
