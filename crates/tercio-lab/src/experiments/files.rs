//! Writes the findings of experiments.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::json;
use tercio::image::{Destination, OutputFile};

use super::{Experiment, Findings};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A plot could not be drawn.
    #[error("{0}")]
    Plot(String),
}

/// Writes `text` atomically: the whole file or nothing.
pub(super) fn write(path: &Path, text: &str) -> Result<(), WriteError> {
    let io = |source| WriteError::Io { path: path.into(), source };
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(io)?;
    }
    let mut file = OutputFile::create(&Destination::File(path.into())).map_err(io)?;
    file.write_all(text.as_bytes()).and_then(|()| file.commit()).map_err(io)
}

/// Writes tables, plots and the verdict into the experiment's folder under `directory`.
pub(super) fn write_findings(
    experiment: &Experiment,
    findings: &Findings,
    directory: &Path,
) -> Result<(), WriteError> {
    let folder = directory.join(experiment.id);
    for table in &findings.tables {
        write(&folder.join(format!("{}.csv", table.name)), &table.to_csv())?;
    }
    for plot in &findings.plots {
        write(&folder.join(format!("{}.svg", plot.name)), &plot.to_svg().map_err(WriteError::Plot)?)?;
    }
    let verdict = json!({
        "id": experiment.id,
        "document": experiment.document.number(),
        "place": experiment.place,
        "title": experiment.title,
        "verdict": findings.verdict.name(),
        "text": findings.verdict.text(),
        "remarks": findings.remarks,
        "tables": findings.tables.iter().map(|t| format!("{}.csv", t.name)).collect::<Vec<_>>(),
        "plots": findings.plots.iter().map(|p| format!("{}.svg", p.name)).collect::<Vec<_>>(),
    });
    write(&folder.join("verdict.json"), &format!("{verdict:#}\n"))
}
