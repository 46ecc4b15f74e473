//! Several files as one model: the pieces of parallel programs, blocks, and series of times.
//!
//! Files are looked for beside the one that names them. Those that are not found are named in a warning; it is an
//! error if none is found. Of a series of times one is read, the first if none is chosen.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::dataset::Job;
use super::extents::Extents;
use super::part::Part;
use super::xml::tree::{Document, Element};
use super::{looks_like_legacy, looks_like_xml, xml};
use crate::ReadError;
use crate::error::{Place, counted};
use crate::io::{ReadOptions, companions, input};

/// Deepest nesting of collections, and most files of a model.
const DEEPEST: usize = 8;
const MOST_FILES: usize = 1 << 16;

/// Names in a warning.
const MOST_NAMES: usize = 8;

/// What was found beside the parts.
#[derive(Default)]
pub struct Found {
    pub companions: Vec<PathBuf>,
    pub warnings: Vec<String>,
    missing: Vec<String>,
    missing_count: usize,
    /// Files that are being read.
    open: Vec<PathBuf>,
    files: usize,
    /// Bytes of the parts that were read.
    held: u64,
}

/// Reads the parts of all files of a collection.
///
/// # Errors
/// Any [`ReadError`] of a file that is found, and if none is.
pub fn parts(job: &Job, document: &Document, found: &mut Found) -> Result<Vec<Part>, ReadError> {
    let (mut names, mut others) = (Vec::new(), Vec::new());
    collect(job, &document.root, found, &mut names, &mut others)?;
    let Some(base) = job.input.base.clone() else {
        let what = "a collection of files without a folder, where they would be looked for,";
        return Err(job.unsupported(Place::File, what));
    };
    // Those of other times, too: no output may replace what is drawn later.
    companions::note(&mut found.companions, &base, names.iter().chain(&others));
    let mut parts = Vec::new();
    job.begin("reading files", names.len() as u64);
    let path = |name: &str| base.join(companions::relative(name));
    // A face towards a piece that is missing is outside.
    let there = xml::extents(document).into_iter().filter(|(name, _)| path(name).exists());
    let extents: Arc<Extents> = Arc::new(there.map(|(_, extent)| extent).collect());
    for name in &names {
        parts.extend(one(job, &path(name), (name, &extents), found)?);
        job.advance(1);
    }
    Ok(parts)
}

impl Found {
    /// Warns of files that were not found, or fails if there are no parts.
    ///
    /// # Errors
    /// None of the files was found.
    pub fn settle(&mut self, job: &Job, parts: &[Part]) -> Result<(), ReadError> {
        if self.missing_count == 0 {
            return Ok(());
        }
        let names = self.missing.join(", ");
        let dots = if self.missing_count > self.missing.len() { ", …" } else { "" };
        let files = counted(self.missing_count as u64, "file");
        if parts.is_empty() {
            return Err(job.malformed(
                Place::File,
                format!("its files beside it ({names}{dots})"),
                "none of them",
            ));
        }
        self.warnings.push(format!("{files} of the model not found: {names}{dots}"));
        Ok(())
    }
}

/// The names of files in a collection: those of the chosen time, and those of others.
fn collect(
    job: &Job,
    root: &Element,
    found: &mut Found,
    names: &mut Vec<String>,
    others: &mut Vec<String>,
) -> Result<(), ReadError> {
    if is_timed(root) {
        let times = times(root);
        let chosen = times.get(job.options.step.unwrap_or(0)).copied();
        match (job.options.step, &times[..]) {
            (Some(step), _) if chosen.is_none() => {
                let found = format!("{} times", times.len());
                return Err(job.malformed(Place::File, format!("a time of number {step}"), found));
            }
            (None, [first, _, ..]) => {
                let warning = format!("holds {} times, of which the first is read, {first}", times.len());
                found.warnings.push(warning);
            }
            _ => {}
        }
        for set in sets(root) {
            let list = if Some(time(set)) == chosen { &mut *names } else { &mut *others };
            list.extend(set.attribute("file").map(str::to_owned));
        }
        return Ok(());
    }
    for child in &root.children {
        let attribute = if child.name == "Piece" { "Source" } else { "file" };
        if matches!(child.name.as_str(), "Piece" | "DataSet") {
            names.extend(child.attribute(attribute).filter(|name| !name.is_empty()).map(str::to_owned));
        }
        collect(job, child, found, names, others)?;
    }
    Ok(())
}

fn is_timed(root: &Element) -> bool {
    root.attribute("type") == Some("Collection")
}

fn sets(root: &Element) -> impl Iterator<Item = &Element> {
    root.children.iter().flat_map(|child| child.children_named("DataSet"))
}

fn time(set: &Element) -> f64 {
    let time = set.attribute("timestep").and_then(|t| t.trim().parse().ok());
    time.filter(|t: &f64| t.is_finite()).unwrap_or(0.0)
}

/// The times of a collection, each once, in ascending order.
pub fn times(root: &Element) -> Vec<f64> {
    if !is_timed(root) {
        return Vec::new();
    }
    // 0 and -0 are the same time.
    let mut times: Vec<f64> = sets(root).map(|set| time(set) + 0.0).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// Reads the parts of one file of a collection.
fn one(
    job: &Job,
    path: &Path,
    (name, extents): (&str, &Arc<Extents>),
    found: &mut Found,
) -> Result<Vec<Part>, ReadError> {
    let whole = || path.canonicalize().unwrap_or_else(|_| path.into());
    found.files += 1;
    if found.files > MOST_FILES || found.open.len() >= DEEPEST || found.open.contains(&whole()) {
        let what = if found.files > MOST_FILES {
            format!("a model of more than {MOST_FILES} files")
        } else {
            format!("a collection inside itself or more than {DEEPEST} deep ({name})")
        };
        return Err(job.unsupported(Place::File, what));
    }
    let options = ReadOptions {
        memory_limit: job.options.memory_limit.map(|limit| limit.saturating_sub(found.held)),
        progress: None,
        // Chosen in the outer one.
        step: None,
        ..*job.options
    };
    let input = match input::open(path, &options) {
        Err(ReadError::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            found.missing_count += 1;
            if found.missing.len() < MOST_NAMES {
                found.missing.push(name.chars().take(200).collect());
            }
            return Ok(Vec::new());
        }
        other => other?,
    };
    if found.companions.len() >= companions::MOST {
        // Every file that is read must be known: no output may replace it.
        found.companions.push(path.to_path_buf());
    }
    let mut inner = Job::new(&input, &options);
    inner.extents = Arc::clone(extents);
    let before = found.held;
    found.open.push(whole());
    let parts = if looks_like_legacy(input.bytes()) {
        super::legacy::part(&inner)?.into_iter().collect()
    } else if looks_like_xml(input.bytes()) {
        let document = xml::tree::parse(&inner)?;
        match xml::kind(&inner, &document)? {
            xml::Kind::Data(_) => xml::parts(&inner, &document)?,
            xml::Kind::Collection(_) => parts(&inner, &document, found)?,
        }
    } else {
        return Err(inner.unsupported(Place::File, "a file of a collection that is none of VTK"));
    };
    found.open.pop();
    // Those of a collection in it have added their own.
    found.held = before + parts.iter().map(Part::bytes).sum::<u64>();
    let warnings = inner.into_warnings().into_iter().map(|warning| format!("{name}: {warning}"));
    found.warnings.extend(warnings.take(MOST_NAMES));
    Ok(parts)
}
