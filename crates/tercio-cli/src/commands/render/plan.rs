//! From the options to what is written, before anything is read.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use anyhow::Result;
use tercio::image::Destination;
use tercio::image::film::Film;

use super::models::Models;
use super::{Job, Render};
use crate::args::ranks::Drawers;
use crate::args::series::{Motion, OutputFormat};
use crate::args::{ModelArgs, values};
use crate::mpi;
use crate::named_files::NamedFiles;
use crate::output::{Plan, UsageError};
use crate::series::film::{FOR_FFMPEG, FilmPlan};
use crate::series::pattern::{self, Names};

/// The outputs, and all files that the command line names.
pub(super) struct Writing {
    /// What is drawn; the files of the first picture; the film and the statistics.
    pub plan: Plan,
    /// The files of every picture.
    pub pictures: Vec<Plan>,
    /// What placeholders stand for in each of them.
    pub names: Vec<Names>,
    pub film: Option<FilmPlan>,
    pub files: Arc<NamedFiles>,
    pub allow_empty: bool,
    /// Whether there are several pictures, or one in the form of several.
    pub is_series: bool,
}

impl Writing {
    /// Checks that the film can be written.
    ///
    /// # Errors
    /// Those of [`FilmPlan::check`].
    pub fn check_film(&self) -> Result<()> {
        self.film.as_ref().map_or(Ok(()), FilmPlan::check)
    }
}

impl Render {
    /// What is to be done, for one model or for the steps of a series.
    ///
    /// # Errors
    /// [`UsageError`] for options that contradict each other.
    pub(super) fn job(&self, steps: &[ModelArgs]) -> Result<Job> {
        let motion = self.series.motion(&self.camera)?;
        if !steps.is_empty() && matches!(motion, Motion::Turntable(_) | Motion::Path(..)) {
            let text = "a series of models has one camera: leave out --turntable and --camera-path, or name one model";
            return Err(UsageError(text.into()).into());
        }
        let mut writing = self.plan_writing(&motion, steps).map_err(UsageError)?;
        let plan = &mut writing.plan;
        self.stereo.check(&self.camera, &self.drawing, plan).map_err(UsageError)?;
        let has_picture = plan.picture.is_some() || plan.drawing.is_some() || plan.film.is_some();
        let changes_picture = self.effects.are_given()
            || self.environment.is_given()
            || self.members().any(|member| member.data.is_given())
            || self.annotation.is_given();
        if !has_picture && changes_picture {
            let what = "--exposure, --tone, --ao, --edl, --environment, --color-by and annotation change the picture only";
            return Err(UsageError(format!("{what}, which is not written: add -o")).into());
        }
        if plan.drawing.is_none() {
            plan.outputs = plan.outputs.with(self.effects.needed()).with(self.annotation.needed());
        }
        self.check_vector(plan).map_err(UsageError)?;
        self.warn_of_samples(plan);
        self.warn_of_bands(plan);
        self.check_options()?;
        for member in &self.others {
            let named = |UsageError(text)| UsageError(format!("{}: {text}", member.model.name()));
            member.check_options().map_err(named)?;
        }
        if self.ranks.parts() && !(self.others.is_empty() && self.placements.is_empty()) {
            let text = "--parts draws one model, of which each process has a part: several models are drawn without it";
            return Err(UsageError(text.into()).into());
        }
        let mut settings = self.drawing.settings(&self.tuning, &self.sampling, writing.plan.outputs);
        if let Some(limit) = self.running.memory_limit() {
            settings.layer_memory = settings.layer_memory.min((limit / 4) as usize);
        }
        settings.texture_filter = self.textures.filter();
        settings.tone = self.effects.tone();
        settings.check().map_err(|e| UsageError(e.to_string()))?;
        let processes = mpi::processes();
        let drawers = self.ranks.drawers(processes)?;
        self.ranks.check_samples(self.sampling.sampling().pattern.count())?;
        if self.series.resume && processes.is_some_and(|p| p > 1) {
            let text = "--resume is not possible with several processes of mpirun: they would have to agree on what is there";
            return Err(UsageError(text.into()).into());
        }
        if writing.plan.drawing.is_some() && drawers != Drawers::Alone {
            return Err(UsageError(
                "an SVG or PDF is drawn by one process, without --ranks and mpirun".into(),
            )
            .into());
        }
        Ok(Job { writing, motion, settings, drawers })
    }

    /// Do the options go together, as far as that is known before a model is read? An added model alone need not.
    pub(crate) fn can_start(&self) -> bool {
        let starts = |render: &Self, steps: &[ModelArgs]| render.job(steps).is_ok();
        match self.models() {
            Ok(Models::One(model)) => starts(&self.with_model(&model), &[]),
            Ok(Models::Steps(steps)) => starts(&self.with_model(&steps[0]), &steps),
            Ok(Models::Batch(models)) => {
                let model = ModelArgs { model: models[0].clone(), ..self.model.clone() };
                starts(&self.with_model(&model), &[])
            }
            Err(_) => false,
        }
    }

    /// Finds options that have no effect.
    ///
    /// # Errors
    /// [`UsageError`].
    pub(crate) fn check_options(&self) -> Result<(), UsageError> {
        let checks = [
            self.camera.check(),
            self.drawing.check(&self.effects, &self.environment),
            self.strokes.check(self.ranks.parts()),
            self.textures.check(),
            self.sampling.check(),
            self.environment.check(),
        ];
        checks.into_iter().collect::<Result<(), _>>().map_err(|e| UsageError(e.into()))?;
        self.data.check()
    }

    fn plan_writing(&self, motion: &Motion, steps: &[ModelArgs]) -> Result<Writing, String> {
        let (views, is_series) = (motion.count(), motion.is_series() || !steps.is_empty());
        let count = views * steps.len().max(1);
        let model = |number: usize| steps.get(number / views).unwrap_or(&self.model);
        let names = |number: usize| Names {
            frame: is_series.then_some(number),
            view: match motion {
                Motion::Views(views) => values::name(&views[number % views.len()]),
                _ => self.camera.views().first().and_then(values::name),
            },
            step: match steps {
                [] => self.model.moment.map(|moment| moment.number),
                _ => Some(number / views),
            },
            name: Some(pattern::name_of(&model(number).model)),
            time: model(number).time(),
        };
        let in_one = is_series && !self.writing.is_numbered();
        let planned = |number: usize| -> Result<Plan, String> {
            self.writing.named(&names(number), true)?.plan(&self.drawing, &self.stereo, in_one)
        };
        let plan = planned(0)?;
        let format = plan.film.as_ref().map(|(_, format)| *format);
        self.series.check(is_series, format)?;
        let film = match &plan.film {
            None => None,
            Some(_) if !is_series => {
                return Err(
                    "a film needs several pictures: give --turntable N, --camera-path FILE or several models"
                        .into(),
                );
            }
            Some((destination, format)) => {
                let (width, height) = self.stereo.picture_size(self.drawing.size)?;
                let film = Film {
                    format: match format {
                        OutputFormat::Film(format) => *format,
                        _ => FOR_FFMPEG,
                    },
                    width,
                    height,
                    pictures: count as u32,
                    rate: self.series.rate(),
                    plays: self.series.plays(),
                    is_translucent: self.drawing.is_transparent(),
                };
                let film = FilmPlan { destination: destination.clone(), format: *format, film };
                film.film.check()?;
                Some(film)
            }
        };
        let mut pictures = vec![Plan { stats: None, film: None, ..plan.clone() }];
        for number in 1..count {
            let other = Plan { stats: None, film: None, ..planned(number)? };
            if number == 1
                && let Some((option, file)) =
                    pictures[0].files().zip(other.files()).find_map(|(a, b)| (a == b).then_some(a))
            {
                let name = crate::output::name(file);
                let example = "such as frame_{:04}.png";
                let films = if format.is_none() && option == "--output" {
                    ", or be a film (.gif, .webp, .apng, .mp4, or - with --format y4m)"
                } else {
                    ""
                };
                return Err(format!(
                    "{option} {name}: {count} pictures need a number in their name, {example}{films}"
                ));
            }
            pictures.push(other);
        }
        let allow_empty = self.writing.allow_empty;
        let names: Vec<Names> = (0..count).map(names).collect();
        let check = |names: &Names| {
            self.annotation.check_texts(names)?;
            self.others.iter().try_for_each(|other| other.annotation.check_texts(&other.names_in(names)))
        };
        names.iter().try_for_each(check)?;
        Ok(Writing { plan, pictures, names, film, files: Arc::default(), allow_empty, is_series })
    }

    /// All files of a job, added to `files`.
    pub(super) fn named_files(&self, job: &Job, files: NamedFiles) -> NamedFiles {
        let Plan { film, stats, .. } = &job.writing.plan;
        let files = film.iter().fold(files, |files, (destination, _)| files.writes("--output", destination));
        let files = stats.iter().fold(files, |files, destination| files.writes("--stats", destination));
        let files = job.writing.pictures.iter().fold(files, |files, plan| plan.named_files(files));
        self.read_files(self.ranks.named_files(files))
    }

    /// Records the files that these options name.
    pub(super) fn record_files(&self) {
        self.read_files(NamedFiles::default());
    }

    /// The files that are read, added to `files`.
    fn read_files(&self, files: NamedFiles) -> NamedFiles {
        let files = files.recording(&self.files_read);
        let files = self.files_of_model().iter().fold(files, |files, m| files.reads_model(m));
        let files = self.others.iter().fold(files, |files, m| files.reads_model(&m.model.model));
        let files = self.members().fold(files, |files, member| member.data.named_files(files));
        let files = self.origin.named_files(files);
        self.series.named_files(self.environment.named_files(files))
    }

    /// When a file that these options name was changed last, and of a series one of the models of its `steps`.
    pub(super) fn newest_input(&self, steps: &[ModelArgs]) -> Option<SystemTime> {
        let files = self.read_files(NamedFiles::default());
        let files = steps.iter().fold(files, |files, step| files.reads_model(&step.model));
        files.newest_input()
    }

    /// The scene file that is written, added to `files`.
    pub(super) fn saved_files(&self, files: NamedFiles) -> NamedFiles {
        let saved = self.scene.save_scene.as_deref().map(Destination::from_path);
        saved.iter().fold(files, |files, saved| files.writes("--save-scene", saved))
    }

    /// The files of the model: of all ranks, if each has its own.
    fn files_of_model(&self) -> Vec<PathBuf> {
        let model = &self.model.model;
        if !self.ranks.parts() {
            return vec![model.clone()];
        }
        let ranks = 0..mpi::processes().unwrap_or(1);
        let mut files: Vec<PathBuf> = ranks.map(|rank| tercio::parts::file_of_rank(model, rank)).collect();
        files.dedup();
        files
    }
}
