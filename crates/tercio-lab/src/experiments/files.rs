//! Writes the findings of experiments.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::json;
use tercio::image::{Destination, OutputFile};
use tercio::vector::VectorFormat;

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
}

/// Writes `content` atomically: the whole file or nothing.
pub(super) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let io = |source| WriteError::Io { path: path.into(), source };
    if let Some(parent) = path.parent() {
        fs::create_dir_all(parent).map_err(io)?;
    }
    let mut file = OutputFile::create(&Destination::File(path.into())).map_err(io)?;
    file.write_all(content.as_ref()).and_then(|()| file.commit()).map_err(io)
}

/// Writes tables, plots and the verdict into the experiment's folder under `directory`.
pub(super) fn write_findings(
    experiment: &Experiment,
    findings: &Findings,
    directory: &Path,
) -> Result<(), WriteError> {
    let folder = directory.join(experiment.id);
    for table in &findings.tables {
        write(&folder.join(format!("{}.csv", table.name)), table.to_csv())?;
    }
    let mut plots = Vec::new();
    for plot in &findings.plots {
        for format in VectorFormat::ALL {
            let file = format!("{}.{}", plot.name, format.name());
            write(&folder.join(&file), plot.to_file(format))?;
            plots.push(file);
        }
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
        "plots": plots,
    });
    write(&folder.join("verdict.json"), format!("{verdict:#}\n"))
}
