//! A series of models: the steps of a simulation, drawn with one camera.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use tercio::scene::framing::Outline;

use super::alone::{Artist, done};
use super::series::Running;
use super::{Done, Job, Render, Writing};
use crate::args::data::{RangeOver, Survey};
use crate::args::ranks::Drawers;
use crate::args::{ModelArgs, ProgressMode};
use crate::messages::warning;
use crate::named_files::NamedFiles;
use crate::output::UsageError;
use crate::progress::Display;
use crate::{ending, mpi, report};

/// What the pictures of a series of models have in common.
#[derive(Default)]
pub(super) struct OfSeries {
    /// What their colours depend on, if they shall mean the same in all pictures.
    pub colors: Option<Survey>,
    /// What the camera frames.
    outline: Option<Arc<Outline>>,
}

impl Render {
    /// Draws the models one after the other, with one camera.
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
        let mut files = models[1..].iter().fold(files, |files, model| files.reads_model(model));
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
        let of_series = self.survey(job, steps, &display)?;
        self.begin_pictures(job, &display);
        let mut running = Running::new(self, steps, job, &display)?;
        let mut artist = Artist::new(job.drawers, self.ranks.now().map(|_| Default::default()));
        // The stages of loading are not shown: pictures are counted.
        let silent = Display::new(ProgressMode::Never);
        let (mut first, mut loads) = (None, Vec::new());
        for (number, model) in steps.iter().enumerate() {
            let mut step = self.with_model(model).of_series(&of_series);
            if number > 0 {
                step.data = step.data.behind_the_first();
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

    /// What the pictures of all steps have in common: the models are read for that, if they can be read twice.
    ///
    /// # Errors
    /// The data of a model; they are needed of one that can be read only once. What else is wrong is reported when it is drawn.
    pub(super) fn survey(&self, job: &Job, steps: &[ModelArgs], display: &Display) -> Result<OfSeries> {
        let count = |is_all: bool| if is_all { steps.len() } else { 1 };
        let with_data = self.data.range_over().filter(|over| *over != RangeOver::Each);
        let with_data = with_data.map_or(0, |over| count(over == RangeOver::All));
        self.survey_data_of(with_data, job, steps, display)
    }

    /// [`Render::survey`], where the colours depend on the first `with_data` steps.
    ///
    /// # Errors
    /// As there.
    pub(super) fn survey_data_of(
        &self,
        with_data: usize,
        job: &Job,
        steps: &[ModelArgs],
        display: &Display,
    ) -> Result<OfSeries> {
        let frames_all = steps.len() > 1 && self.series.frames_all() && self.camera.frames_model();
        let mut framed = if frames_all { steps.len() } else { 0 };
        let once = |steps: &[ModelArgs]| steps.iter().find(|s| !s.can_be_read_again()).map(ModelArgs::name);
        if let Some(name) = once(&steps[..with_data]) {
            let text = format!(
                "{name} can be read only once, and the colours of a series depend on the data of all models: give --range LOW,HIGH or --range-over each, or name files"
            );
            return Err(UsageError(text).into());
        }
        if let Some(name) = once(&steps[..framed]) {
            if !self.running.quiet {
                warning(&format!(
                    "{name} can be read only once: the first model is framed, not all of the series"
                ));
            }
            framed = 0;
        }
        if with_data.max(framed) == 0 {
            return Ok(OfSeries::default());
        }
        let what =
            if with_data == 0 { "finding the size of all steps" } else { "finding the range of all steps" };
        display.progress.begin(what, with_data.max(framed) as u64);
        let silent = Display::new(ProgressMode::Never);
        let (mut colors, mut outline) = (Survey::default(), Outline::default());
        for (number, model) in steps.iter().enumerate().take(with_data.max(framed)) {
            ending::name_model(model.name());
            let step = Self { is_measured: true, others: Vec::new(), ..self.with_model(model) };
            let loaded = step.load(job, &silent, None::<&mut mpi::Comm>);
            display.progress.advance(1);
            let loaded = match loaded {
                Ok(loaded) => loaded,
                Err(error) if number < with_data => return Err(error),
                Err(_) => continue,
            };
            if let Some(own) = loaded.outline.as_ref().filter(|_| number < framed) {
                outline.add_outline(own);
            }
            if number < with_data {
                let (of_model, instance) = (&loaded.models[0], &loaded.scene.instances[0]);
                let up = self.camera.for_format(&of_model.report.read.format).front().up;
                let survey = self.data.survey(instance, &of_model.drawable.file, up);
                colors = colors.and(survey.with_context(|| model.name())?);
            }
        }
        let outline = (framed > 0).then(|| Arc::new(outline));
        Ok(OfSeries { colors: (with_data > 0).then_some(colors), outline })
    }

    /// These options for a model of a series.
    #[must_use]
    pub(super) fn of_series(mut self, series: &OfSeries) -> Self {
        if let Some(colors) = &series.colors {
            self.data = self.data.of_series(colors);
        }
        self.outline.clone_from(&series.outline);
        self
    }
}
