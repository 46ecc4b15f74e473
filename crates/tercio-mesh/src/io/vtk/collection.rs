//! Several files as one model: the pieces of parallel programs, blocks, and series of times.
//!
//! Files are looked for beside the one that names them. Those that are not found are named in a warning; it is an
//! error if none is found. Of a series of times the first one is read.

use std::path::{Path, PathBuf};

use super::dataset::Job;
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
    let mut names = Vec::new();
    collect(&document.root, found, &mut names);
    let Some(base) = job.input.base.clone() else {
        let what = "a collection of files without a folder, where they would be looked for,";
        return Err(job.unsupported(Place::File, what));
    };
    companions::note(&mut found.companions, &base, names.iter());
    let mut parts = Vec::new();
    job.begin("reading files", names.len() as u64);
    for name in &names {
        let path = base.join(companions::relative(name));
        parts.extend(one(job, &path, name, found)?);
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

/// The names of files in a collection.
fn collect(root: &Element, found: &mut Found, names: &mut Vec<String>) {
    if root.attribute("type") == Some("Collection") {
        let sets: Vec<&Element> = root.children.iter().flat_map(|c| c.children_named("DataSet")).collect();
        let time = |set: &Element| {
            set.attribute("timestep").and_then(|t| t.trim().parse::<f64>().ok()).unwrap_or(0.0)
        };
        let mut times: Vec<f64> = sets.iter().map(|set| time(set)).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        if let [first, _, ..] = times[..] {
            let warning = format!("holds {} times, of which the first is read, {first}", times.len());
            found.warnings.push(warning);
        }
        let of_first = sets.into_iter().filter(|set| times.first() == Some(&time(set)));
        names.extend(of_first.filter_map(|set| set.attribute("file")).map(str::to_owned));
        return;
    }
    for child in &root.children {
        let attribute = if child.name == "Piece" { "Source" } else { "file" };
        if matches!(child.name.as_str(), "Piece" | "DataSet") {
            names.extend(child.attribute(attribute).filter(|name| !name.is_empty()).map(str::to_owned));
        }
        collect(child, found, names);
    }
}

/// Reads the parts of one file of a collection.
fn one(job: &Job, path: &Path, name: &str, found: &mut Found) -> Result<Vec<Part>, ReadError> {
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
    let inner = Job::new(&input, &options);
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
