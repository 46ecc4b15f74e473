//! `--watch`: draws again whenever a model changes, or another file that its picture is made of.

use std::collections::BTreeMap;
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

/// Looks after which a file that is not there is gone.
const GONE: u32 = 10;

/// By how much times of files may be too early.
const CLOCK: Duration = Duration::from_secs(1);

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
                render = Self { files_read: render.files_read, ..again.clone() };
            }
            // Files that are named are known now; those that models name, after these were read.
            render.record_files();
            let (before, begin) = (render.stamps(), SystemTime::now());
            match again.and_then(|_| render.run_once()) {
                Err(error) if is_first && error.is::<UsageError>() => return Err(error),
                Err(error) => messages::error(&error),
                Ok(_) => {}
            }
            is_first = false;
            if !self.running.quiet {
                messages::note("waiting for a change; Ctrl+C ends");
            }
            // Which other files a model names is known now. All may have changed while it was drawn.
            let mut drawn = render.stamps();
            for stamp in drawn.values_mut() {
                *stamp = stamp
                    .filter(|(written, _)| written.checked_add(CLOCK).is_some_and(|written| written < begin));
            }
            drawn.extend(before);
            let (mut last, mut same) = (drawn.clone(), 0);
            loop {
                thread::sleep(PAUSE);
                let now = render.stamps();
                same = if now == last { same + 1 } else { 0 };
                // A file that is still being written changes from look to look. One that is being replaced is not there for a while.
                let is_gone = |(path, stamp): (&PathBuf, &Stamp)| {
                    stamp.is_none() && drawn.get(path).is_some_and(Option::is_some)
                };
                let wait = if now.iter().any(is_gone) { GONE } else { 1 };
                if now != drawn && same >= wait {
                    break;
                }
                last = now;
            }
        }
    }

    /// The files that the pictures are drawn from.
    fn stamps(&self) -> BTreeMap<PathBuf, Stamp> {
        let models = match self.models() {
            Ok(Models::Batch(models)) => models,
            Ok(Models::Steps(steps)) => steps.into_iter().map(|step| step.model).collect(),
            _ => vec![self.model.model.clone()],
        };
        let mut files = self.files_read.paths();
        // Of patterns and series there may be new ones.
        files.extend(models);
        // Models that are made do not change.
        files.retain(|path| !path.to_string_lossy().starts_with("builtin:"));
        let stamp = |path: &Path| {
            let metadata = fs::metadata(path).ok()?;
            Some((metadata.modified().ok()?, metadata.len()))
        };
        files
            .into_iter()
            .map(|path| {
                let stamp = stamp(&path);
                (path, stamp)
            })
            .collect()
    }
}
