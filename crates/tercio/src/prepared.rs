//! Prepared models: loaded, repaired and split into clusters once, and stored in a file that is mapped and drawn
//! immediately.

use std::io::{self, Write};
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadOptions, prepared};
use tercio_mesh::strokes::Strokes;
use tercio_mesh::{Place, ReadError};

use crate::{LoadError, LoadOptions, LoadReport, LoadTimes, Loaded};

/// Where a prepared model came from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Origin {
    /// The program that prepared it.
    pub program: String,
    /// The model that it was made from, by the name given then.
    pub model: String,
    /// Bytes of the prepared file.
    #[serde(skip)]
    pub file_bytes: u64,
    /// Bytes of it that are mapped and not copied: they do not count as memory taken.
    #[serde(skip)]
    pub mapped_bytes: u64,
}

/// Information about the file, stored in it.
#[derive(Serialize, Deserialize)]
struct About {
    origin: Origin,
    report: LoadReport,
}

impl Loaded {
    /// Writes the model as a file that [`load`](crate::load) maps and that is drawn without reading, repairing and
    /// partitioning again. `model` names the source; a model that was prepared already keeps its origin.
    ///
    /// ```
    /// let model = tercio::load("builtin:sphere@1k")?;
    /// let file = tempfile::NamedTempFile::new()?;
    /// model.write_prepared("builtin:sphere@1k", &mut &file)?;
    /// let again = tercio::load(&file)?;
    /// assert_eq!(again.mesh.clusters(), model.mesh.clusters());
    /// assert_eq!(again.report.prepared.map(|origin| origin.model).as_deref(), Some("builtin:sphere@1k"));
    /// # Ok::<(), tercio::Error>(())
    /// ```
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write_prepared(&self, model: &str, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
        let here = || Origin {
            program: concat!("tercio ", env!("CARGO_PKG_VERSION")).into(),
            model: model.into(),
            ..Origin::default()
        };
        let origin = self.report.prepared.clone().unwrap_or_else(here);
        // The same model makes the same file: times and the paths of textures depend on the run, so they are left
        // out.
        let mut report = LoadReport { times: LoadTimes::default(), ..self.report.clone() };
        report.read.companions.clear();
        let about = serde_json::to_vec(&About { origin, report })?;
        prepared::write(&self.mesh, &about, out)
    }
}

/// Loads a prepared model.
pub(crate) fn load(input: &Input, options: &LoadOptions, start: Instant) -> Result<Loaded, LoadError> {
    let read = ReadOptions {
        memory_limit: options.memory_limit,
        progress: options.progress,
        ..ReadOptions::default()
    };
    loaded(input, prepared::read(input, &read)?, start)
}

/// A prepared model, or a part of it, that was read since `start`.
pub(crate) fn loaded(
    input: &Input,
    prepared: prepared::Prepared,
    start: Instant,
) -> Result<Loaded, LoadError> {
    let prepared::Prepared { mesh, about } = prepared;
    let About { mut origin, mut report } =
        serde_json::from_slice(&about).map_err(|error| ReadError::Malformed {
            file: input.name.clone(),
            place: Place::File,
            expected: "what the program that prepared the model says about it".into(),
            found: error.to_string(),
        })?;
    origin.file_bytes = input.file_bytes;
    origin.mapped_bytes = mesh.mapped_bytes() as u64;
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    report.times = LoadTimes { read: milliseconds, total: milliseconds, ..LoadTimes::default() };
    report.prepared = Some(origin);
    report.mesh.bounds = mesh.bounds;
    report.mesh.bytes = mesh.memory_bytes() as u64;
    Ok(Loaded { mesh: Arc::new(mesh), caps: None, whole: None, strokes: Strokes::default(), report })
}

/// The error for a use that needs the mesh of a prepared model.
pub(crate) fn no_mesh(file: &str) -> LoadError {
    let (file, place) = (file.to_owned(), Place::File);
    let what =
        "this use of a prepared model, which is cut into clusters (name the model that it was made from)";
    ReadError::Unsupported { file, place, what: what.into() }.into()
}
