//! Sessions of several ranks against one process that loads a file with all their triangles.

use std::time::Duration;

use tercio::glam::{DAffine3, DVec3};
use tercio::mesh::arrays::{Arrays, Positions};
use tercio::parallel::comm::threads::{self, ThreadComm};
use tercio::parallel::{Communicator as _, PartsError};
use tercio::scene::Background;
use tercio::{
    Camera, Error, LoadError, ParallelError, Renderer, Scene, Session, SessionError, Settings, load,
};

/// Vertices along the edges of the sheet.
const EDGE: usize = 41;

/// A rank's strip of a sheet with a wave in it, and a crest that is sharper than the crease angle.
struct Strip {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    colors: Vec<[u8; 4]>,
}

impl Strip {
    /// The rows of cells of a rank; the vertices between two ranks are in both strips.
    fn new(rank: usize, ranks: usize, phase: f64) -> Self {
        let cells = EDGE - 1;
        let (first, last) = (rank * cells / ranks, (rank + 1) * cells / ranks);
        let (mut positions, mut triangles, mut colors) = (Vec::new(), Vec::new(), Vec::new());
        for y in first..=last {
            for x in 0..EDGE {
                let [u, v] = [x, y].map(|k| k as f64 / cells as f64);
                let height = 0.2 * (9.0 * u + phase).sin() * (7.0 * v).cos() + (v - 0.5).abs();
                positions.push([5e5 + u, -3e5 + v, height]);
                colors.push([(255.0 * u) as u8, (255.0 * v) as u8, 90, 255]);
            }
        }
        let width = EDGE as u32;
        for y in 0..(last - first) as u32 {
            for x in 0..width - 1 {
                let a = y * width + x;
                triangles.extend([[a, a + 1, a + width + 1], [a, a + width + 1, a + width]]);
            }
        }
        Self { positions, triangles, colors }
    }

    /// Without vertices.
    fn empty() -> Self {
        Self { positions: Vec::new(), triangles: Vec::new(), colors: Vec::new() }
    }

    fn arrays(&self) -> Arrays<'_> {
        let arrays = Arrays::new(Positions::F64(&self.positions), &self.triangles);
        Arrays { vertex_colors: Some(&self.colors), ..arrays }
    }
}

/// A binary PLY file with the strips.
fn ply(strips: &[Strip]) -> Vec<u8> {
    let count = |of: fn(&Strip) -> usize| strips.iter().map(of).sum::<usize>();
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        count(|s| s.positions.len()),
        count(|s| s.triangles.len())
    )
    .into_bytes();
    for strip in strips {
        for (position, color) in strip.positions.iter().zip(&strip.colors) {
            out.extend(position.iter().flat_map(|c| c.to_le_bytes()));
            out.extend(&color[..3]);
        }
    }
    let mut first = 0;
    for strip in strips {
        for triangle in &strip.triangles {
            out.push(3);
            out.extend(triangle.iter().flat_map(|v| (v + first).to_le_bytes()));
        }
        first += strip.positions.len() as u32;
    }
    out
}

/// The picture of a scene with the strips as one model, and the camera that frames it.
fn of_file(strips: &[Strip], place: DAffine3, settings: &Settings) -> (Vec<[u8; 4]>, Camera) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("strips.ply");
    std::fs::write(&path, ply(strips)).expect("room for a file");
    let mut scene = Scene::from_mesh(load(&path).expect("a model").mesh);
    scene.instances[0].world_from_object = place;
    let camera = settings.framing().camera_for_scene(&scene);
    let frame = Renderer::new().render(&scene, &camera, settings).expect("a picture");
    (frame.planes.color, camera)
}

#[test]
fn ranks_draw_what_one_process_loads_from_a_file() {
    let settings = Settings::new(150, 110);
    let turned = DAffine3::from_axis_angle(DVec3::X, -1.0);
    for ranks in [1, 2, 3, 5] {
        // With three ranks and more, the second one has nothing.
        let strip = |rank: usize, phase: f64| match (rank, ranks) {
            (_, ..3) => Strip::new(rank, ranks, phase),
            (1, _) => Strip::empty(),
            _ => Strip::new(rank.saturating_sub(1), ranks - 1, phase),
        };
        let steps = [(0.0, DAffine3::IDENTITY), (1.0, DAffine3::IDENTITY), (1.0, turned)];
        let pictures = threads::run(ranks, |comm| {
            let (rank, mut pictures) = (comm.rank(), Vec::new());
            let mut session = Session::new(std::mem::replace(comm, ThreadComm::alone()));
            let part = session.add(&strip(rank, 0.0).arrays()).expect("a part");
            for (phase, place) in steps {
                session.update(part, &strip(rank, phase).arrays()).expect("the same part");
                *session.transform_mut(part).expect("the part") = place;
                let camera = session.camera(&settings.framing()).expect("a camera");
                let frame = session.render(&camera, &settings).expect("a picture");
                assert_eq!(frame.is_some(), rank == 0);
                pictures.extend(frame.map(|frame| (frame.planes.color.clone(), camera)));
            }
            assert!(session.spent() > Duration::ZERO);
            assert_eq!(
                session.report().map_or(0, |report| report.ranks.len()),
                if rank == 0 { ranks } else { 0 }
            );
            *comm = session.into_comm();
            Ok(pictures)
        });
        let mut pictures = pictures.expect("ranks");
        for ((phase, place), (picture, camera)) in steps.into_iter().zip(pictures.remove(0)) {
            let strips: Vec<Strip> = (0..ranks).map(|rank| strip(rank, phase)).collect();
            let (expected, framed) = of_file(&strips, place, &settings);
            assert_eq!(camera, framed, "{ranks} ranks");
            assert!(picture == expected, "{ranks} ranks, phase {phase}, {place:?}");
        }
    }
}

#[test]
fn what_is_shown_is_gone_after_its_picture_and_parts_stay() {
    let settings = Settings::new(60, 50);
    let strip = Strip::new(0, 1, 0.0);
    let mut session = Session::alone();
    let part = session.add(&strip.arrays()).expect("a part");
    let camera = session.camera(&settings.framing()).expect("a camera");
    let draw = |session: &mut Session<_>| {
        let frame = session.render(&camera, &settings).expect("a picture").expect("rank 0");
        frame.planes.color.clone()
    };
    let alone = draw(&mut session);
    let lifted: Vec<_> = strip.positions.iter().map(|p| [p[0], p[1], p[2] + 0.3]).collect();
    session.show(&Arrays::new(Positions::F64(&lifted), &strip.triangles)).expect("a part for once");
    // A part that comes later stays, and what is shown does not move into its place.
    let second = session.add(&Strip::new(0, 1, 2.0).arrays()).expect("another part");
    let three = draw(&mut session);
    let two = draw(&mut session);
    session.remove(second).expect("the part");
    assert!(three != two && two != alone);
    assert!(draw(&mut session) == alone);
    session.remove(part).expect("the part");
    let gone = session.update(second, &strip.arrays()).expect_err("it was removed");
    assert_eq!(gone.to_string(), "there is no part 1");
    assert!(matches!(session.remove(part), Err(Error::Session(SessionError::NoPart(id))) if id == part));
    let empty = draw(&mut session);
    assert!(empty != alone, "nothing is left");
    // The same as drawn again.
    session.add(&strip.arrays()).expect("a part");
    assert!(draw(&mut session) == alone);
}

#[test]
fn wrong_arrays_of_one_rank_are_an_error_of_all_and_change_nothing() {
    let settings = Settings::new(40, 30);
    let drawn = threads::run(3, |comm| {
        let rank = comm.rank();
        let mut session = Session::new(std::mem::replace(comm, ThreadComm::alone()));
        let strip = Strip::new(rank, 3, 0.0);
        let part = session.add(&strip.arrays()).expect("a part");
        let outside = [[0, 1, 9999]];
        let wrong =
            Arrays { triangles: if rank == 1 { &outside } else { &strip.triangles }, ..strip.arrays() };
        let error = session.update(part, &wrong).expect_err("a wrong corner");
        match rank {
            1 => assert!(matches!(error, Error::Load(LoadError::Arrays(_))), "{error}"),
            _ => assert!(
                matches!(error, Error::Parallel(ParallelError::Parts(PartsError::Failed { rank: 1 }))),
                "{error}"
            ),
        }
        let colorless =
            Arrays { vertex_colors: if rank == 2 { None } else { Some(&strip.colors) }, ..strip.arrays() };
        let error = session.update(part, &colorless).expect_err("only some have colours");
        assert!(
            matches!(error, Error::Parallel(ParallelError::Parts(PartsError::Differs { rank: 2, .. }))),
            "{error}"
        );
        let camera = session.camera(&settings.framing()).expect("a camera");
        let picture =
            session.render(&camera, &settings).expect("a picture").map(|frame| frame.planes.color.clone());
        *comm = session.into_comm();
        Ok(picture)
    });
    let strips: Vec<Strip> = (0..3).map(|rank| Strip::new(rank, 3, 0.0)).collect();
    let (expected, _) = of_file(&strips, DAffine3::IDENTITY, &settings);
    assert!(drawn.expect("ranks").remove(0) == Some(expected));
}

#[test]
fn ranks_that_set_different_things_fail_and_do_not_wait() {
    let settings = Settings::new(40, 30);
    let errors = threads::run(3, |comm| {
        let rank = comm.rank();
        let mut session = Session::new(std::mem::replace(comm, ThreadComm::alone()));
        session.add(&Strip::new(rank, 3, 0.0).arrays()).expect("a part");
        let camera = session.camera(&settings.framing()).expect("a camera");
        if rank == 2 {
            *session.background_mut() = Background::Solid([1.0; 4]);
        }
        let first = session.render(&camera, &settings).expect_err("another background").to_string();
        let then = session.render(&camera, &settings).expect_err("the session failed").to_string();
        assert_eq!(then, format!("the session failed before: {first}"));
        Ok(first)
    });
    let errors = errors.expect("ranks");
    assert!(errors[0].starts_with("rank 2 would draw a scene with other places"), "{}", errors[0]);
    assert!(errors[1..].iter().all(|error| error.ends_with("is gone")), "{errors:?}");
}

#[test]
fn ranks_that_call_different_functions_get_an_error() {
    for ranks in [2, 3, 6] {
        let errors = threads::run(ranks, |comm| {
            let (rank, last) = (comm.rank(), comm.size() - 1);
            let mut session = Session::new(std::mem::replace(comm, ThreadComm::alone()));
            let strip = Strip::new(rank, comm.size().max(1), 0.0);
            let part = session.add(&strip.arrays()).expect("a part");
            let error = if rank == last {
                session.remove(part).expect("the part");
                session.update(part, &strip.arrays()).expect_err("it was removed")
            } else {
                session.update(part, &strip.arrays()).expect_err("the last rank does not have it")
            };
            session.camera(&Settings::new(8, 8).framing()).expect_err("the session failed");
            Ok(error.to_string())
        });
        for error in errors.expect("ranks") {
            let expected = format!(
                "rank {} called update of part 0, which it does not have, and rank 0 update of part 0: \
                 collective functions are called by all ranks, in the same order",
                ranks - 1
            );
            assert_eq!(error, expected);
        }
    }
}
