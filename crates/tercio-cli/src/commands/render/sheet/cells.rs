//! What is on a sheet, and what is written below its pictures.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::Result;

use super::Sheet;
use crate::args::ModelArgs;
use crate::args::annotation::shown;
use crate::args::ranks::Drawers;
use crate::args::series::Motion;
use crate::args::writing::WritingArgs;
use crate::commands::render::Render;
use crate::commands::render::batch::Item;
use crate::output::UsageError;
use crate::series::pattern::{self, Names};

/// Why there is nothing to fill in for `{time}`, `{step}` and `{frame}` on a sheet.
const NO_TIME: &str = "{time} is the time of the model in its collection (.pvd; with --turntable or --camera-path, --time or --step choose one), or the number TimeValue or TIME in the field data of a VTK file, and it has none";
const NO_STEP: &str = "{step} is the number of the model's time in its collection (.pvd; with --turntable or --camera-path, --time or --step choose one), and it has none";
const NO_FRAME: &str = "{frame} numbers the pictures of a model, and there is one of it: give --turntable, --camera-path or several --view (in --caption it numbers those of the sheet)";

/// All places of a sheet.
pub(super) struct Cells {
    /// The models that can be drawn, as far as that is known before they are read.
    pub groups: Vec<Group>,
    pub lacking: Vec<Lacking>,
    /// The number of places.
    pub count: usize,
}

/// The pictures of one model: of its views, or of its times.
pub(super) struct Group {
    /// The times, at least one.
    pub steps: Vec<Item>,
    /// The number of its first picture on the sheet.
    pub first: usize,
    pub captions: Vec<String>,
}

/// A model that does not have what captions or texts say of it: its places tell that, as those of a model that cannot be read.
pub(super) struct Lacking {
    model: String,
    /// What `{name}` stands for.
    name: String,
    pub cells: Range<usize>,
    pub caption: String,
    pub reason: &'static str,
}

impl fmt::Display for Lacking {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.model, self.reason)
    }
}

impl Sheet {
    /// The models with what is drawn of each.
    ///
    /// # Errors
    /// Options that make no sheet; no model has what captions or texts say.
    pub(super) fn cells(&self, render: &Render, models: &[PathBuf]) -> Result<Cells> {
        let motion = render.series.motion(&render.camera)?;
        let shows_time = self.says("time");
        let (mut groups, mut lacking, mut first) = (Vec::new(), Vec::new(), 0);
        for model in models {
            let steps = match &motion {
                Motion::Turntable(_) | Motion::Path(..) => vec![render.at_chosen_time(model)?],
                _ => render.steps_of(model)?,
            };
            let with_time = |step: ModelArgs| match shows_time {
                true => ModelArgs { time: render.time_of_file(model), ..step },
                false => step,
            };
            let steps: Vec<ModelArgs> = steps.into_iter().map(with_time).collect();
            if let Some(reason) = steps.iter().find_map(|step| self.lacks(render, step, &motion)) {
                let cells = first..first + steps.len() * motion.count();
                first = cells.end;
                let (name, model) = (pattern::name_of(model), steps[0].name());
                lacking.push(Lacking { model, caption: shown(&name), name, cells, reason });
                continue;
            }
            let of_step = |step: &ModelArgs| {
                let mut of_step = render.with_model(step);
                of_step.writing = of_step.writing.of_cell(motion.is_series());
                Item::new(of_step)
            };
            let steps: Vec<Item> = steps.iter().map(of_step).collect::<Result<_>>()?;
            if matches!(steps[0].job.drawers, Drawers::Mpi(_)) {
                return Err(UsageError("mpirun draws no sheet together: start one process".into()).into());
            }
            let mut captions = Vec::new();
            for Item { job, .. } in &steps {
                for names in &job.writing.names {
                    let names = Names { frame: Some(first + captions.len()), ..names.clone() };
                    let text = self.caption_of(&names, models.len() > 1, steps.len() > 1, &job.motion);
                    captions.push(shown(&text.map_err(UsageError)?));
                }
            }
            let end = first + captions.len();
            groups.push(Group { steps, first, captions });
            first = end;
        }
        if let (true, Some(lacking)) = (groups.is_empty(), lacking.first()) {
            return Err(UsageError(lacking.to_string()).into());
        }
        Ok(Cells { groups, lacking, count: first })
    }

    /// Whether the captions have a placeholder of this name.
    fn says(&self, name: &str) -> bool {
        self.caption.as_ref().is_some_and(|text| pattern::has(Path::new(text), name))
    }

    /// What a model does not have, though captions or texts say it.
    fn lacks(&self, render: &Render, step: &ModelArgs, motion: &Motion) -> Option<&'static str> {
        let is_in_text = |name: &str| render.annotation.has_placeholder(name);
        if step.time().is_none() && (self.says("time") || is_in_text("time")) {
            Some(NO_TIME)
        } else if step.moment.is_none() && (self.says("step") || is_in_text("step")) {
            Some(NO_STEP)
        } else if !motion.is_series() && is_in_text("") {
            Some(NO_FRAME)
        } else {
            None
        }
    }

    /// What is written below a picture.
    fn caption_of(
        &self,
        names: &Names,
        models: bool,
        times: bool,
        motion: &Motion,
    ) -> Result<String, String> {
        // The time of a file that cannot be read is no number: its place has the name.
        let is_read = !names.time.is_some_and(f64::is_nan);
        if let Some(text) = self.caption.as_ref().filter(|_| is_read) {
            return pattern::expand_text(text, names, true);
        }
        let view = match motion {
            Motion::Views(_) => names.view.clone(),
            Motion::Turntable(count) => {
                let number = names.frame.unwrap_or(0) as u32 % count;
                Some(format!("{}°", (f64::from(number) * 3600.0 / f64::from(*count)).round() / 10.0))
            }
            Motion::Path(..) => names.frame.map(|frame| frame.to_string()),
            Motion::Still => None,
        };
        let time =
            names.time.filter(|_| times && is_read).map(|_| pattern::expand_text("t = {time}", names, true));
        let time = time.transpose()?;
        let is_alone = view.is_none() && time.is_none();
        let name = names.name.clone().filter(|_| models || is_alone);
        Ok([name, time, view].into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

/// The outputs of a sheet, whose name is that of one picture: its placeholders stand for what all pictures on it have in common.
///
/// # Errors
/// One sentence, for a placeholder that stands for anything else.
pub(super) fn named(writing: &WritingArgs, cells: &Cells) -> Result<WritingArgs, String> {
    let steps = cells.groups.iter().flat_map(|group| &group.steps);
    let all: Vec<&Names> = steps.flat_map(|step| &step.job.writing.names).collect();
    // Models that lack what captions say have places, too, and a name, if nothing else.
    let lacking = || cells.lacking.iter();
    let names = Names {
        frame: None,
        view: shared(all.iter().map(|names| names.view.as_ref())),
        step: shared(all.iter().map(|names| names.step.as_ref()).chain(lacking().map(|_| None))),
        name: shared(all.iter().map(|names| names.name.as_ref()).chain(lacking().map(|of| Some(&of.name)))),
        // The time of an unreadable file is NaN and does not count: its place shows the error.
        time: shared(
            all.iter()
                .map(|names| names.time.as_ref())
                .filter(|t| t.is_none_or(|t| !t.is_nan()))
                .chain(lacking().map(|_| None)),
        ),
    };
    // Names have been checked: what goes wrong is that something is not known.
    writing.named(&names, true).map_err(|_| {
        "--output: a sheet is one picture, in whose name {name}, {view}, {time} and {step} stand for what all its pictures have in common, and {frame} for nothing: what they differ in is said by --caption".into()
    })
}

/// What all have in common.
fn shared<'a, T: Clone + PartialEq + 'a>(mut all: impl Iterator<Item = Option<&'a T>>) -> Option<T> {
    let first = all.next()??;
    all.all(|other| other == Some(first)).then(|| first.clone())
}
