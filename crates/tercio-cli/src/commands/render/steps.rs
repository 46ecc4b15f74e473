//! A series of models: the steps of a simulation, drawn with one camera.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use tercio::scene::Instance;
use tercio::{LoadOptions, Normals};

use super::alone::{Artist, done};
use super::series::Running;
use super::{Done, Job, Render, Writing};
use crate::args::data::{RangeOver, Survey};
use crate::args::ranks::Drawers;
use crate::args::{ModelArgs, ProgressMode};
use crate::named_files::NamedFiles;
use crate::output::UsageError;
use crate::progress::Display;
use crate::{ending, mpi, report};

impl Render {
    /// Draws the models one after the other. All have the camera of the first one.
    pub(super) fn run_steps(&self, steps: &[ModelArgs]) -> Result<ExitCode> {
        let start = Instant::now();
        let first = self.with_model(&steps[0]);
        let job = first.job(steps)?;
        if matches!(job.drawers, Drawers::Mpi(_)) {
            let text = "the processes of mpirun draw one model together: name one, or use --ranks";
            return Err(UsageError(text.into()).into());
        }
        if self.others.iter().any(|member| member.model.is_standard_input()) {
            let text =
                "standard input is read once: a model that is in every picture of a series is in a file";
            return Err(UsageError(text.into()).into());
        }
        if self.is_in_bands(&job.writing.plan, job.drawers) {
            let text = "pictures that are drawn in bands have one model: choose a smaller --size";
            return Err(UsageError(text.into()).into());
        }
        let files = self.saved_files(first.named_files(&job, NamedFiles::default()));
        let mut models: Vec<PathBuf> = steps.iter().map(|step| step.model.clone()).collect();
        // The times of a collection are one file.
        models.dedup();
        let files = models[1..].iter().fold(files, |files, model| files.reads_model(model));
        files.check()?;
        files.make_folders()?;
        files.check_places()?;
        let job = Job { writing: Writing { files: Arc::new(files), ..job.writing }, ..job };
        job.writing.check_film()?;
        ending::name_model(first.model.name());
        let pool = self.running.pool()?;
        pool.install(|| self.check_companions(&job.writing.files, &models))?;
        let (done, loads) = pool.install(|| first.draw_steps(&job, steps))?;
        first.print_views(&done);
        first.finish_steps(&job, &done, Some(loads), pool.current_num_threads(), start)?;
        Ok(ExitCode::SUCCESS)
    }

    fn draw_steps(&self, job: &Job, steps: &[ModelArgs]) -> Result<(Done, Vec<serde_json::Value>)> {
        let display = Display::new(self.running.progress_mode());
        let survey = self.survey(steps, &display)?;
        self.begin_pictures(job, &display);
        let mut running = Running::new(self, job, &display)?;
        let mut artist = Artist::new(job.drawers, self.ranks.now().map(|_| Default::default()));
        // The stages of loading are not shown: pictures are counted.
        let silent = Display::new(ProgressMode::Never);
        let (mut first, mut loads) = (None, Vec::new());
        for (number, model) in steps.iter().enumerate() {
            let mut step = self.with_model(model);
            if let Some(survey) = &survey {
                step.data = step.data.of_series(survey);
            }
            ending::name_model(step.model.name());
            let mut loaded = step.load(job, &silent, None::<&mut mpi::Comm>)?;
            step.print_warnings(&loaded.reports);
            loads.push(report::load_json(&step.model.name(), &loaded.reports[0].report));
            let views = loaded.cameras.len();
            let (_, cameras) = first.get_or_insert_with(|| (None, loaded.cameras.clone()));
            loaded.cameras.clone_from(cameras);
            let goes_on = running.draw(&step, &mut loaded, number * views, |loaded, camera, frame| {
                step.draw_one(job, loaded, camera, &silent, &mut artist, frame)
            })?;
            if let Some((of_first @ None, _)) = &mut first {
                *of_first = Some(loaded);
            }
            if !goes_on {
                break;
            }
        }
        let Some((Some(loaded), _)) = first else { bail!("there is no model") };
        Ok((done(loaded, running.finish()?, artist.choice, artist.trace), loads))
    }

    /// What the colours of all steps depend on, if they shall mean the same in all pictures: the models are read for that.
    pub(super) fn survey(&self, steps: &[ModelArgs], display: &Display) -> Result<Option<Survey>> {
        let models = match self.data.range_over() {
            None | Some(RangeOver::Each) => return Ok(None),
            Some(RangeOver::First) => &steps[..1],
            Some(RangeOver::All) => steps,
        };
        display.progress.begin("finding the range of all steps", models.len() as u64);
        let mut all = Survey::default();
        for model in models {
            ending::name_model(model.name());
            let options = LoadOptions {
                memory_limit: self.running.memory_limit(),
                normals: self.data.normals(Normals::File, None),
                clip: self.clip.clipping(),
                make: self.data.made(),
                step: model.moment.map(|moment| moment.number),
                ..LoadOptions::default()
            };
            let loaded = options.load(&model.model)?;
            let up = self.camera.for_format(&loaded.report.read.format).front().up;
            let place = self.place.transform();
            let instance = Instance { world_from_object: place, ..Instance::new(loaded.mesh) };
            let survey = self.data.survey(&instance, &loaded.strokes, up);
            all = all.and(survey.with_context(|| model.name())?);
            display.progress.advance(1);
        }
        Ok(Some(all))
    }
}
