//! `--watch`: draws again whenever a model changes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, SystemTime};

use anyhow::Result;

use super::Render;
use super::models::Models;
use crate::output::UsageError;
use crate::{messages, scene_file};

/// Time between looks at the files.
const PAUSE: Duration = Duration::from_millis(200);

/// When a file was written last, and its length; `None` while it is not there.
type Stamp = Option<(SystemTime, u64)>;

impl Render {
    /// Draws, and again whenever a model's file changes, until the program is interrupted. Errors are printed, and the next change
    /// is waited for.
    pub(super) fn watch(&self) -> Result<ExitCode> {
        let mpi = crate::mpi::processes().is_some_and(|processes| processes > 1);
        if mpi || self.members().any(|member| member.model.is_standard_input()) {
            let text = "--watch needs one process, and models in files";
            return Err(UsageError(text.into()).into());
        }
        let mut render = self.clone();
        let mut is_first = true;
        loop {
            // A scene file is read again. The models of one that is wrong are those of the last one.
            let again = scene_file::render(&self.origin.arguments);
            if let Ok(Some(again)) = &again {
                render = again.clone();
            }
            let drawn = render.stamps();
            match again.and_then(|_| render.run_once()) {
                Err(error) if is_first && error.is::<UsageError>() => return Err(error),
                Err(error) => messages::error(&error),
                Ok(_) => {}
            }
            is_first = false;
            if !self.running.quiet {
                messages::note("waiting for a change of the model; Ctrl+C ends");
            }
            let mut before = drawn.clone();
            loop {
                thread::sleep(PAUSE);
                let now = render.stamps();
                // A file that is still being written changes from look to look.
                if now != drawn && now == before && now.iter().all(Option::is_some) {
                    break;
                }
                before = now;
            }
        }
    }

    fn stamps(&self) -> Vec<Stamp> {
        let models = match self.models() {
            Ok(Models::Batch(models)) => models,
            Ok(Models::Steps(steps)) => steps.into_iter().map(|step| step.model).collect(),
            _ => vec![self.model.model.clone()],
        };
        let stamp = |path: &Path| {
            let metadata = fs::metadata(path).ok()?;
            Some((metadata.modified().ok()?, metadata.len()))
        };
        let others = self.others.iter().map(|other| &other.model.model);
        // Models that are made do not change.
        let is_file = |path: &&Path| !path.to_string_lossy().starts_with("builtin:");
        let all = models.iter().chain(others).map(PathBuf::as_path).chain(self.origin.scene_file());
        all.filter(is_file).map(stamp).collect()
    }
}
