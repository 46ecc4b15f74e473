//! Many models with outputs of their own.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread;
use std::time::Instant;
use std::{fmt, fs};

use anyhow::{Context, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};
use tercio::parallel::placement;

use super::{Job, Render, Writing};
use crate::args::ProgressMode;
use crate::args::data::{RangeOver, Survey};
use crate::args::ranks::Drawers;
use crate::named_files::NamedFiles;
use crate::output::UsageError;
use crate::progress::Display;
use crate::report::counted;
use crate::series::pattern::{self, Names};
use crate::{ending, messages};

/// Files of fewer bytes are drawn side by side, a thread each; compressed ones count four times.
const SMALL: u64 = 8 << 20;
/// What a small model takes in memory, for each byte of its file.
const BYTES_PER_BYTE: u64 = 40;

/// A model of a batch, and what is to be done with it.
pub(super) struct Item {
    pub render: Render,
    pub job: Job,
    /// Bytes of its file, if it is small.
    pub small: Option<u64>,
}

impl Render {
    /// Draws all models, each for itself. One that cannot be drawn does not stop the others.
    pub(super) fn run_batch(&self, models: &[PathBuf]) -> Result<ExitCode> {
        let start = Instant::now();
        if self.ranks.trace().is_some() {
            return Err(UsageError("--trace records one model: name one".into()).into());
        }
        let (mut items, mut without_time) = (Vec::new(), Vec::new());
        for model in models {
            match self.item(model) {
                Ok(item) => items.push(item),
                Err(error) if error.is::<NoTime>() => without_time.push(error),
                Err(error) => return Err(error),
            }
        }
        if let (true, Some(error)) = (items.is_empty(), without_time.first()) {
            return Err(UsageError(error.to_string()).into());
        }
        let named = |files, item: &Item| item.render.named_files(&item.job, files);
        let mut files = self.saved_files(items.iter().fold(NamedFiles::default(), named));
        files.check()?;
        files.make_folders()?;
        files.check_places()?;
        items[0].job.writing.check_film()?;
        let files = Arc::new(files);
        let with_files = |item: Item| {
            let writing = Writing { files: Arc::clone(&files), ..item.job.writing };
            Item { job: Job { writing, ..item.job }, ..item }
        };
        let mut items: Vec<Item> = items.into_iter().map(with_files).collect();
        ending::name_model(format!("one of {} models", items.len()));
        let pool = self.running.pool()?;
        pool.install(|| self.check_companions(&files, models))?;
        let display = Display::new(self.running.progress_mode());
        pool.install(|| share_colors(&mut items, &display))?;
        display.pictures(items.len() as u64);
        without_time.iter().for_each(messages::error);
        let failed = AtomicUsize::new(without_time.len());
        let draw = |item: &Item, threads: usize| {
            if let Err(error) = item.draw(threads) {
                messages::error(&error);
                failed.fetch_add(1, Relaxed);
            }
            display.progress.advance(1);
        };
        // The large ones first, with all threads.
        items.iter().filter(|item| item.small.is_none()).for_each(|item| {
            pool.install(|| draw(item, pool.current_num_threads()));
        });
        let small: Vec<&Item> = items.iter().filter(|item| item.small.is_some()).collect();
        side_by_side(&small, self.workers(&small, pool.current_num_threads()), |item| draw(item, 1))?;
        drop(display);
        let failed = failed.into_inner();
        if !self.running.quiet {
            let (all, seconds) = (models.len(), start.elapsed().as_secs_f64());
            let of_failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
            let drawn = counted((all - failed) as u64, "model");
            messages::note(&format!("{drawn} of {all} drawn{of_failed}, in {seconds:.1} s"));
        }
        Ok(if failed > 0 { ExitCode::from(1) } else { ExitCode::SUCCESS })
    }

    fn item(&self, model: &Path) -> Result<Item> {
        let own = self.origin.for_model(model)?;
        let options = own.as_ref().unwrap_or(self);
        let mut render = options.with_model(&options.at_chosen_time(model)?);
        render.files_read = self.files_read.clone();
        if render.shows_time() && render.model.time().is_none() {
            return Err(NoTime(render.model.name()).into());
        }
        let names = Names { name: Some(pattern::name_of(model)), ..Names::default() };
        render.writing = render.writing.named(&names, false).map_err(UsageError)?;
        Item::new(render)
    }

    /// How many small models may be in memory at a time.
    pub(super) fn workers(&self, small: &[&Item], threads: usize) -> usize {
        let Some(largest) = small.iter().filter_map(|item| item.small).max() else { return 1 };
        let frame = small.iter().map(|i| i.render.frame_bytes(&i.job.writing.plan, i.job.drawers)).max();
        let one = largest * BYTES_PER_BYTE + frame.unwrap_or(0).saturating_mul(4);
        let most = self.running.memory_limit().map_or(u64::MAX, |limit| limit / 2 / one.max(1));
        threads.min(most as usize).min(small.len()).max(1)
    }
}

impl Item {
    /// One model with its options.
    ///
    /// # Errors
    /// [`UsageError`]: wrong options, or a model that is not one of many.
    pub(super) fn new(render: Render) -> Result<Self> {
        let job = render.job(&[])?;
        let model = &render.model.model;
        if matches!(job.drawers, Drawers::Mpi(_)) {
            let text = "the processes of mpirun draw one model together: name one";
            return Err(UsageError(text.into()).into());
        }
        if render.members().any(|member| member.model.is_standard_input()) {
            return Err(UsageError("standard input is one model: name it alone".into()).into());
        }
        let length = fs::metadata(model).ok().filter(|m| m.is_file()).map(|m| m.len());
        let is_packed = model.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"));
        let length = length.map(|length| if is_packed { length.saturating_mul(4) } else { length });
        let small = length.filter(|&length| length < SMALL && job.drawers == Drawers::Alone);
        Ok(Item { render, job, small })
    }

    fn draw(&self, threads: usize) -> Result<()> {
        let start = Instant::now();
        let silent = Display::new(ProgressMode::Never);
        let done = self.render.draw(&self.job, &silent)?;
        self.render.print_summary(&done);
        self.render.finish(&self.job, &done, threads, start)
    }
}

/// A model that has no time, which its output's name or a text is to show: others of the batch may have one.
#[derive(Debug)]
struct NoTime(String);

impl fmt::Display for NoTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.0, pattern::NO_TIME)
    }
}

impl std::error::Error for NoTime {}

/// Gives models that are coloured alike one range, if that is asked for: they are read for that, one after the other.
///
/// # Errors
/// [`UsageError`]: one that can be read only once. What else is wrong with a model is reported when it is drawn.
fn share_colors(items: &mut [Item], display: &Display) -> Result<()> {
    // The configuration may say something else of each model.
    let mut shared: HashMap<String, (Option<Survey>, Unread)> = HashMap::new();
    let key = |item: &Item| format!("{:?}", item.render.data);
    for item in &*items {
        let Some(over) = item.render.data.range_over_batch() else { continue };
        let (known, unread) = shared.entry(key(item)).or_default();
        if over == RangeOver::First && known.is_some() {
            continue;
        }
        let model = std::slice::from_ref(&item.render.model);
        match item.render.survey_data_of(1, &item.job, model, display) {
            Ok(own) => {
                unread.warn(over, &item.render);
                let all = known.take().unwrap_or_default();
                *known = Some(own.colors.into_iter().fold(all, Survey::and));
            }
            Err(error) if error.is::<UsageError>() => return Err(error),
            Err(_) => unread.add(&item.render),
        }
    }
    for item in items {
        if let Some((Some(colors), _)) = shared.get(&key(item)) {
            item.render.data = item.render.data.of_series(colors);
        }
    }
    Ok(())
}

/// Models before the first one whose range can be known: they cannot be read.
#[derive(Default)]
pub(super) struct Unread(Vec<String>);

impl Unread {
    /// Adds a model.
    pub fn add(&mut self, render: &Render) {
        self.0.push(render.model.name());
    }

    /// Warns that the range of the first model is that of a later one.
    pub fn warn(&mut self, over: RangeOver, render: &Render) {
        let before = std::mem::take(&mut self.0);
        if over == RangeOver::First && !before.is_empty() && !render.running.quiet {
            let (before, model) = (before.join(", "), render.model.name());
            messages::warning(&format!(
                "--range-over first: the range is that of {model}, as {before} cannot be read"
            ));
        }
    }
}

/// Works on all items, on so many threads, each of which is a pool of its own: parallel work inside of an item runs on its thread,
/// and no thread that waits begins another item.
pub(super) fn side_by_side<T: Sync>(items: &[T], workers: usize, work: impl Fn(&T) + Sync) -> Result<()> {
    let next = AtomicUsize::new(0);
    let first = placement::current();
    let of_worker = |number: usize| -> Result<()> {
        placement::move_to(first + number);
        let pool: ThreadPool = ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread()
            .build()
            .context("cannot start a thread")?;
        pool.install(|| {
            while let Some(item) = items.get(next.fetch_add(1, Relaxed)) {
                work(item);
            }
        });
        Ok(())
    };
    thread::scope(|scope| {
        let started: Vec<_> =
            (0..workers).map(|n| thread::Builder::new().spawn_scoped(scope, move || of_worker(n))).collect();
        // Those that could be started do the work of the others.
        let mut result = Ok(());
        let mut any = false;
        for worker in started {
            match worker.map(|worker| worker.join()) {
                Ok(Ok(Ok(()))) => any = true,
                Ok(Ok(Err(error))) => result = Err(error),
                Ok(Err(panic)) => std::panic::resume_unwind(panic),
                Err(error) => result = Err(error).context("cannot start a thread"),
            }
        }
        if any { Ok(()) } else { result }
    })
}
