//! A series of models: the steps of a simulation, drawn with one camera.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, bail};

use super::alone::{Artist, done};
use super::series::Running;
use super::{Done, Job, Render, Writing};
use crate::args::ProgressMode;
use crate::args::ranks::Drawers;
use crate::named_files::NamedFiles;
use crate::output::UsageError;
use crate::progress::Display;
use crate::{ending, mpi, report};

impl Render {
    /// Draws the models one after the other. All have the camera of the first one.
    pub(super) fn run_steps(&self, models: &[PathBuf]) -> Result<ExitCode> {
        let start = Instant::now();
        let first = self.with_model(&models[0]);
        let job = first.job(Some(models.len()))?;
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
        let files = models[1..].iter().fold(files, |files, model| files.reads_model(model));
        files.check()?;
        files.check_places()?;
        let job = Job { writing: Writing { files: Arc::new(files), ..job.writing }, ..job };
        job.writing.check_film()?;
        ending::name_model(first.model.name());
        let pool = self.running.pool()?;
        pool.install(|| self.check_companions(&job.writing.files, models))?;
        let (done, loads) = pool.install(|| first.draw_steps(&job, models))?;
        first.print_views(&done);
        first.finish_steps(&job, &done, Some(loads), pool.current_num_threads(), start)?;
        Ok(ExitCode::SUCCESS)
    }

    fn draw_steps(&self, job: &Job, models: &[PathBuf]) -> Result<(Done, Vec<serde_json::Value>)> {
        let display = Display::new(self.running.progress_mode());
        self.begin_pictures(job, &display);
        let mut running = Running::new(self, job, &display)?;
        let mut artist = Artist::new(job.drawers, self.ranks.now().map(|_| Default::default()));
        // The stages of loading are not shown: pictures are counted.
        let silent = Display::new(ProgressMode::Never);
        let (mut first, mut loads) = (None, Vec::new());
        for (number, model) in models.iter().enumerate() {
            let step = self.with_model(model);
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
}
