//! What the models on the command line are: one, a batch, or the steps of a series, which may be the times of a collection.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use anyhow::Result;
use tercio::mesh::io::{ReadOptions, input, vtk};

use super::Render;
use crate::args::{ModelArgs, Moment};
use crate::output::UsageError;
use crate::tips;

/// The models of a run.
pub(super) enum Models {
    /// One model.
    One(ModelArgs),
    /// Many, each with outputs of its own.
    Batch(Vec<PathBuf>),
    /// Many, drawn one after the other with one camera into one series.
    Steps(Vec<ModelArgs>),
}

impl Render {
    /// The models, in the order of the command line; those of a pattern with * in natural order.
    ///
    /// # Errors
    /// Models that need names of their own; a collection of times that cannot be read.
    pub(super) fn models(&self) -> Result<Models> {
        self.writing.check_names().map_err(UsageError)?;
        let mut models = self.listed()?;
        let is_batch = self.writing.has_placeholder("name");
        let of_steps = self.writing.has_placeholder("step") || self.writing.has_placeholder("time");
        let is_series = of_steps || self.writing.has_placeholder("") || self.writing.is_film();
        if models.len() == 1 && models[0] == self.model.model {
            let shows_all = of_steps || (is_series && !self.series.moves_camera());
            if shows_all && !self.series.chooses_time() {
                let steps = self.steps_of(&models[0])?;
                if steps.len() > 1 {
                    return Ok(Models::Steps(steps));
                }
            }
            return self.at_chosen_time(&models[0]).map(Models::One);
        }
        if is_batch {
            return Ok(Models::Batch(models));
        }
        if is_series {
            // Shells sort step_10 before step_9.
            models.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
            let steps = models.iter().map(|model| self.steps_of(model)).collect::<Result<Vec<_>>>()?;
            return Ok(Models::Steps(steps.concat()));
        }
        let second = models.get(1).unwrap_or(&models[0]).display();
        let count = models.len();
        let text = tips::surplus_model(&models).unwrap_or_else(|| {
            format!("{count} models (the second is {second}) need names of their own: {{name}} in the output stands for that of the model, as in {{name}}.png; with {{frame}} or a film they are the steps of a series, with --together one picture")
        });
        Err(UsageError(text).into())
    }

    /// All models of the command line, those of patterns one by one.
    ///
    /// # Errors
    /// A pattern that no file matches.
    pub(super) fn listed(&self) -> Result<Vec<PathBuf>, UsageError> {
        let mut models = Vec::new();
        for path in std::iter::once(&self.model.model).chain(&self.more) {
            match expanded(path)? {
                Some(found) => models.extend(found),
                None => models.push(path.clone()),
            }
        }
        Ok(models)
    }

    /// The model, at the time that is chosen, if one is.
    ///
    /// # Errors
    /// A [`UsageError`] if the model does not have that; a collection of times that cannot be read.
    pub(super) fn at_chosen_time(&self, model: &Path) -> Result<ModelArgs> {
        let mut moment = None;
        if self.series.chooses_time() {
            moment = self.series.chosen(model, &self.times(model)?).map_err(UsageError)?;
        }
        let time = if moment.is_none() { self.own_time(model) } else { None };
        Ok(ModelArgs { model: model.into(), moment, time })
    }

    /// The times of a model, in order, each as a model; or the model itself, if it has no times or one is chosen.
    pub(super) fn steps_of(&self, model: &Path) -> Result<Vec<ModelArgs>> {
        if self.series.chooses_time() {
            return Ok(vec![self.at_chosen_time(model)?]);
        }
        let times = self.times(model)?;
        if times.is_empty() {
            return Ok(vec![ModelArgs { time: self.own_time(model), ..ModelArgs::of(model) }]);
        }
        let moment =
            |(number, time)| ModelArgs { moment: Some(Moment { number, time }), ..ModelArgs::of(model) };
        Ok(times.into_iter().enumerate().map(moment).collect())
    }

    /// The times of a collection; none of other files.
    fn times(&self, model: &Path) -> Result<Vec<f64>> {
        let is_collection = model.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pvd"));
        if !is_collection {
            return Ok(Vec::new());
        }
        let options = ReadOptions { memory_limit: self.running.memory_limit(), ..ReadOptions::default() };
        Ok(vtk::times(&input::open(model, &options)?, &options)?)
    }

    /// The time that a file of VTK has, if the name of an output or a text shows it.
    fn own_time(&self, model: &Path) -> Option<f64> {
        if self.shows_time() { self.time_of_file(model) } else { None }
    }

    /// Whether the name of an output or a text shows the time of the model.
    pub(super) fn shows_time(&self) -> bool {
        self.writing.has_placeholder("time") || self.annotation.has_placeholder("time")
    }

    /// As [`time_of_file`], with the memory that there is.
    pub(super) fn time_of_file(&self, model: &Path) -> Option<f64> {
        time_of_file(model, self.running.memory_limit())
    }

    /// These options for another model.
    pub(super) fn with_model(&self, model: &ModelArgs) -> Self {
        let mut other = self.clone();
        other.model = model.clone();
        other.more = Vec::new();
        other
    }
}

/// The time that a file has if it is one of VTK; NaN if it cannot be read, which is an error when it is drawn.
pub fn time_of_file(model: &Path, memory_limit: Option<u64>) -> Option<f64> {
    let name = model.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let ending = name.strip_suffix(".gz").unwrap_or(&name).rsplit('.').next().unwrap_or_default();
    if !matches!(ending, "vtk" | "vtp" | "vtu" | "vti" | "vts" | "vtr") {
        return None;
    }
    let options = ReadOptions { memory_limit, ..ReadOptions::default() };
    let time = input::open(model, &options).and_then(|input| vtk::time(&input, &options));
    time.unwrap_or(Some(f64::NAN))
}

/// The files that match a pattern with `*` or `?` in its last part, in natural order; `None` for the name of a file. Most shells
/// have done that already.
pub fn expanded(path: &Path) -> Result<Option<Vec<PathBuf>>, UsageError> {
    let pattern = path.file_name().and_then(|name| name.to_str()).filter(|name| name.contains(['*', '?']));
    let Some(pattern) = pattern.filter(|_| !path.exists()) else { return Ok(None) };
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = folder.read_dir().map_err(|e| UsageError(format!("{}: {e}", folder.display())))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let is_hidden = |name: &str| name.starts_with('.') && !pattern.starts_with('.');
    let mut names: Vec<String> = names.filter(|name| matches(pattern, name) && !is_hidden(name)).collect();
    if names.is_empty() {
        return Err(UsageError(format!("{}: there is no such file", path.display())));
    }
    names.sort_by(|a, b| natural(a, b));
    Ok(Some(names.iter().map(|name| path.with_file_name(name)).collect()))
}

/// Whether a name matches a pattern, in which `*` stands for anything and `?` for one character.
pub fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n, mut star) = (0, 0, None);
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] => (p, n) = (p + 1, n + 1),
            _ => match star {
                // The last star takes one character more.
                Some((at, from)) => {
                    star = Some((at, from + 1));
                    (p, n) = (at + 1, from + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

/// The order of names in which step_9 is before step_10: digits are compared as numbers.
pub(super) fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let digits = |s: &str| s.len() - s.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (of_a, of_b) = (digits(a), digits(b));
        if of_a > 0 && of_b > 0 {
            let (number_a, number_b) = (a[..of_a].trim_start_matches('0'), b[..of_b].trim_start_matches('0'));
            // Without zeros before it, the longer number is the larger one.
            let order =
                number_a.len().cmp(&number_b.len()).then(number_a.cmp(number_b)).then(of_a.cmp(&of_b));
            if order != Ordering::Equal {
                return order;
            }
            (a, b) = (&a[of_a..], &b[of_b..]);
            continue;
        }
        let (mut chars_a, mut chars_b) = (a.chars(), b.chars());
        match (chars_a.next(), chars_b.next()) {
            (Some(x), Some(y)) if x == y => (a, b) = (chars_a.as_str(), chars_b.as_str()),
            (x, y) => return x.cmp(&y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_are_numbers() {
        let mut names =
            ["s10.ply", "s9.ply", "s009.ply", "t1", "s", "s9b", "s9.obj", "s90000000000000000000000"];
        names.sort_by(|a, b| natural(a, b));
        let sorted =
            ["s", "s9.obj", "s9.ply", "s9b", "s009.ply", "s10.ply", "s90000000000000000000000", "t1"];
        assert_eq!(names, sorted);
    }

    #[test]
    fn stars_and_question_marks_match() {
        let good = [("*.stl", "a.stl"), ("a*b*c", "aXbYbZc"), ("?.x", "é.x"), ("*", ""), ("a**", "a")];
        assert!(good.iter().all(|(pattern, name)| matches(pattern, name)));
        let bad = [("*.stl", "a.stlx"), ("a*b", "ac"), ("?", ""), ("a", "ab"), ("", "a")];
        assert!(bad.iter().all(|(pattern, name)| !matches(pattern, name)));
    }
}
