//! Scenes on which renderers are known to be slow: tercio may be slower than llvmpipe on none of them.

use anyhow::Result;

use super::Effort;
use super::programs::{Program, Programs, THREADS};
use super::report::{Bar, Report, digits};
use super::run::{Run, Task, median_ms, ratio, versions};
use crate::models::{Index, Model, PLANE_EDGE};

/// A scene.
pub struct Scene {
    title: &'static str,
    pub file: &'static str,
    size: u32,
    camera: Place,
    /// Upper bound on the views of a turn, for scenes in which a view takes long.
    most_frames: u32,
    /// Further arguments of `tercio bench`.
    arguments: &'static [&'static str],
    /// Lower limit of the frame time of llvmpipe, divided by tercio's.
    of_llvmpipe: f64,
}

/// Position of the camera.
#[derive(Clone, Copy)]
enum Place {
    /// It moves round the model.
    Walking,
    /// In front of the middle of a planar scene, which fills the picture.
    BeforePlane,
    /// In the middle of the model.
    Inside,
    /// So far away that the model's longest edge is this many pixels of a picture of 1024.
    Away(f64),
}

/// Vertical angle of view of fixed cameras, degrees.
const FOV: f64 = 40.0;

const SCENE: Scene = Scene {
    title: "",
    file: "",
    size: 1024,
    camera: Place::BeforePlane,
    most_frames: 36,
    arguments: &[],
    of_llvmpipe: 1.0,
};

pub const SCENES: [Scene; 11] = [
    Scene {
        title: "100 layers over the whole picture, back to front",
        file: "layers-back-to-front.ply",
        ..SCENE
    },
    Scene {
        title: "100 layers over the whole picture, front to back",
        file: "layers-front-to-back.ply",
        ..SCENE
    },
    Scene { title: "10,000 slivers from border to border", file: "slivers.ply", ..SCENE },
    Scene {
        title: "dragon, triangles in random order in the file",
        file: "dragon-shuffled.ply",
        camera: Place::Walking,
        ..SCENE
    },
    // 32 x 32 tiles of 64 pixels.
    Scene {
        title: "one triangle a tile, 2048x2048",
        file: "one-a-tile.ply",
        size: 2048,
        arguments: &["--tile-size", "64"],
        of_llvmpipe: 2.0,
        ..SCENE
    },
    Scene {
        title: "dragon, 16384x16384",
        file: "dragon.ply",
        size: 16384,
        camera: Place::Walking,
        most_frames: 2,
        ..SCENE
    },
    Scene {
        title: "dragon on 20 pixels",
        file: "dragon.ply",
        camera: Place::Away(7.1),
        most_frames: 12,
        ..SCENE
    },
    Scene {
        title: "dragon in one tile, 64x64",
        file: "dragon.ply",
        size: 64,
        camera: Place::Walking,
        most_frames: 12,
        arguments: &["--tile-size", "64"],
        ..SCENE
    },
    Scene {
        title: "bunny seen from inside",
        file: "bunny.ply",
        camera: Place::Inside,
        of_llvmpipe: 2.0,
        ..SCENE
    },
    Scene {
        title: "gyroid seen from inside",
        file: "gyroid.ply",
        camera: Place::Inside,
        most_frames: 6,
        ..SCENE
    },
    Scene {
        title: "1,000 copies of a mesh of 972 triangles",
        file: "sphere.ply",
        camera: Place::Walking,
        arguments: &["--copies", "1000"],
        ..SCENE
    },
];

const PROGRAMS: [Program; 3] = [
    Program::Tercio { threads: THREADS, cull_back: false },
    Program::Tercio { threads: 1, cull_back: false },
    Program::Llvmpipe { cull_back: false },
];

impl Scene {
    fn task(&self, model: &Model, effort: Effort) -> Task {
        let mut arguments: Vec<_> = self.arguments.iter().map(ToString::to_string).collect();
        arguments.extend(self.camera.arguments(model));
        Task {
            title: self.title.into(),
            model: model.path.clone(),
            size: (self.size, self.size),
            frames: effort.frames.min(self.most_frames),
            samples: 1,
            opacity: 1.0,
            arguments,
        }
    }
}

impl Place {
    fn arguments(self, model: &Model) -> Vec<String> {
        let tangent = (FOV.to_radians() * 0.5).tan();
        let [x, y, z] = model.center;
        let (eye, target) = match self {
            Self::Walking => return Vec::new(),
            Self::BeforePlane => ([0.0, 0.0, f64::from(PLANE_EDGE) * 0.5 / tangent], [0.0; 3]),
            Self::Inside => (model.center, [x, y, z - model.extent]),
            Self::Away(pixels) => ([x, y, z + model.extent * 1024.0 / pixels * 0.5 / tangent], model.center),
        };
        let vector = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}");
        ["--eye", &vector(eye), "--target", &vector(target), "--fov", &FOV.to_string()]
            .map(String::from)
            .into()
    }
}

/// Measures and reports.
///
/// # Errors
/// A program fails.
pub fn measure(programs: &Programs, models: &Index, effort: Effort, report: &mut Report) -> Result<()> {
    let here = programs.available(&PROGRAMS);
    let introduction = format!(
        "Milliseconds a frame, {THREADS} threads, nothing culled, medians of {} turns; 1024x1024 unless the scene says \
         otherwise.",
        effort.rounds
    );
    let columns =
        ["scene", "pixels covered", "tercio", "tercio, 1 thread", "llvmpipe", "llvmpipe / tercio", "bar", ""];
    report.table("No cliffs", &introduction, &columns);
    let mut rival_versions = String::new();
    for scene in &SCENES {
        let Some(model) = models.get(scene.file) else { continue };
        let task = scene.task(model, effort);
        let mut runs: Vec<Vec<Run>> = vec![Vec::new(); here.len()];
        for round in 0..effort.rounds {
            for (i, run) in programs.take_turns(&here, &task)?.into_iter().enumerate() {
                report.keep("cliffs", scene.title, &here[i].name(), round, &run.kept());
                runs[i].push(run);
            }
        }
        rival_versions = versions(&here, runs.iter().filter_map(|runs| runs.first()));
        let covered = runs[0][0].pixels.first().map_or(0, |(_, pixels)| *pixels).to_string();
        let (ours, alone) = (digits(median_ms(&runs[0])), digits(median_ms(&runs[1])));
        match runs.get(2) {
            Some(llvmpipe) => {
                let (theirs, times) = (digits(median_ms(llvmpipe)), ratio(llvmpipe, &runs[0]));
                let bar = Bar::Least(scene.of_llvmpipe);
                let cells =
                    [&covered, &ours, &alone, &theirs, &digits(times), &bar.to_string(), bar.verdict(times)];
                report.row(&[&[scene.title], &cells.map(|c: &str| c)[..]].concat());
            }
            None => report.row(&[scene.title, &covered, &ours, &alone, "–", "–", "–", "not measured"]),
        }
    }
    report.note(&rival_versions);
    Ok(())
}
