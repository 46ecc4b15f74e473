//! The experiments: one per published figure or table, each with its data, its plot and its verdict.
//!
//! An [`Experiment`] is a name, the place in the document and a function that computes its [`Findings`]: tables, plots,
//! remarks, and a [`Verdict`] that is derived from a comparison of numbers. To add one, write a function in the module
//! of its document and list it there; [`all`] chains the modules. [`reproduce`] runs experiments on all cores and
//! writes them; [`report`] joins them to one page.

pub mod eldridge;
mod facts;
mod files;
pub mod hybris;
pub mod mcmanus;
pub mod ortega;
pub mod parks;
mod plot;
pub mod report;
mod simulated;
mod sweep;
mod table;
mod verdict;

use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

pub use facts::Facts;
pub use files::WriteError;
pub use plot::{Axis, Categories, Mark, Plot, Role, Scale, Series};
pub use table::{Cell, Column, Table};
pub use verdict::{Comparison, Verdict};

/// A published figure or table that can be reproduced.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Its name, which is also its folder: `eldridge-fig-5-5`.
    pub id: &'static str,
    /// The document.
    pub document: Document,
    /// The figure or table as numbered in the document: `figure 5-5`.
    pub place: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Computes it. Deterministic.
    pub run: fn() -> Result<Findings, ExperimentError>,
}

/// Why an experiment could not be run.
pub type ExperimentError = Box<dyn std::error::Error + Send + Sync>;

/// The five documents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Document {
    /// 000.
    Eldridge,
    /// 001.
    Hybris,
    /// 002.
    Parks,
    /// 003.
    McManus,
    /// 004.
    Ortega,
}

impl Document {
    /// All of them, in order.
    pub const ALL: [Self; 5] = [Self::Eldridge, Self::Hybris, Self::Parks, Self::McManus, Self::Ortega];

    /// The number that the project uses for it.
    pub fn number(self) -> &'static str {
        match self {
            Self::Eldridge => "000",
            Self::Hybris => "001",
            Self::Parks => "002",
            Self::McManus => "003",
            Self::Ortega => "004",
        }
    }

    /// Author, title, year.
    pub fn reference(self) -> &'static str {
        match self {
            Self::Eldridge => "M. W. Eldridge, SIMD Column-Parallel Polygon Rendering, MIT, 1995",
            Self::Hybris => {
                "H. Holten-Lund, Design for Scalability in 3D Computer Graphics Architectures, DTU, 2001"
            }
            Self::Parks => {
                "J. K. Parks, A Comparison of Two Multiprocessor Graphics Machine Designs, UNC, 1982"
            }
            Self::McManus => {
                "D. McManus, C. Beckmann, Optimal Static 2-Dimensional Screen Subdivision for Parallel Rasterization \
                 Architectures"
            }
            Self::Ortega => {
                "F. A. Ortega, C. D. Hansen, Fast Data Parallel Polygon Rendering, Supercomputing 1993"
            }
        }
    }
}

/// What an experiment found.
#[derive(Clone, Debug)]
pub struct Findings {
    /// The data; at least one table.
    pub tables: Vec<Table>,
    /// The plots of the data.
    pub plots: Vec<Plot>,
    /// Paragraphs for the reader: what is shown, which scene replaces a lost one, what to look at.
    pub remarks: Vec<String>,
    /// The comparison with what was published.
    pub verdict: Verdict,
}

/// An experiment with its findings.
#[derive(Debug)]
pub struct Outcome {
    /// The experiment.
    pub experiment: Experiment,
    /// What it found.
    pub findings: Result<Findings, ExperimentError>,
}

/// The experiments of each module, in the order of the documents.
const MODULES: &[&[Experiment]] = &[
    eldridge::communication::EXPERIMENTS,
    eldridge::composition::EXPERIMENTS,
    eldridge::accounting::EXPERIMENTS,
    simulated::ring::EXPERIMENTS,
    hybris::overlap::EXPERIMENTS,
    hybris::performance::EXPERIMENTS,
    hybris::sorting::EXPERIMENTS,
    hybris::heap::EXPERIMENTS,
    hybris::engines::EXPERIMENTS,
    parks::costs::EXPERIMENTS,
    parks::tables::EXPERIMENTS,
    simulated::parks::EXPERIMENTS,
    mcmanus::overlap::EXPERIMENTS,
    mcmanus::sizing::EXPERIMENTS,
    simulated::mcmanus::EXPERIMENTS,
    ortega::speed::EXPERIMENTS,
    simulated::ortega::EXPERIMENTS,
];

/// All experiments, in the order of the documents.
pub fn all() -> impl Iterator<Item = Experiment> {
    MODULES.iter().flat_map(|module| module.iter().copied())
}

/// Runs `experiments` on the cores of the current pool and writes each into its folder under `directory`: one CSV file
/// per table, an SVG and a PDF file per plot, and `verdict.json`. `finished` is called after each, in any order.
///
/// The outcomes are in the order of `experiments`; a failing experiment does not stop the others.
///
/// # Errors
/// A file that cannot be written.
pub fn reproduce(
    experiments: &[Experiment],
    directory: impl AsRef<Path>,
    finished: impl Fn(&Outcome) + Sync,
) -> Result<Vec<Outcome>, WriteError> {
    let directory = directory.as_ref();
    experiments
        .par_iter()
        .map(|&experiment| {
            let outcome = Outcome { experiment, findings: (experiment.run)() };
            if let Ok(findings) = &outcome.findings {
                files::write_findings(&experiment, findings, directory)?;
            }
            finished(&outcome);
            Ok(outcome)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::published;

    #[test]
    fn every_experiment_runs_and_none_is_contradicted() {
        let directory = tempfile::tempdir().unwrap();
        let experiments: Vec<_> = all().collect();
        let ids: BTreeSet<_> = experiments.iter().map(|e| e.id).collect();
        assert_eq!(ids.len(), experiments.len(), "names are folders");
        let outcomes = reproduce(&experiments, directory.path(), |_| {}).unwrap();
        let mut colliding = Vec::new();
        for outcome in &outcomes {
            let id = outcome.experiment.id;
            let findings = outcome.findings.as_ref().unwrap_or_else(|e| panic!("{id}: {e}"));
            let contradicted = matches!(findings.verdict, Verdict::Contradicted { .. });
            assert!(!contradicted, "{id}: {}", findings.verdict.text());
            assert!(findings.tables.iter().all(|t| !t.rows.is_empty()), "{id} has an empty table");
            for plot in &findings.plots {
                let file = |extension| directory.path().join(id).join(format!("{}.{extension}", plot.name));
                assert!(file("svg").is_file() && file("pdf").is_file());
                let collisions = plot.collisions().into_iter().map(|c| format!("{id}/{}: {c}", plot.name));
                colliding.extend(collisions);
            }
        }
        assert!(colliding.is_empty(), "{colliding:#?}");
        report::write(&outcomes, &published::check_all().unwrap(), directory.path()).unwrap();
        let page = std::fs::read_to_string(directory.path().join("index.html")).unwrap();
        let markdown = std::fs::read_to_string(directory.path().join("report.md")).unwrap();
        assert!(ids.iter().all(|id| page.contains(id) && markdown.contains(id)));
    }

    #[test]
    fn what_is_found_is_the_same_from_run_to_run_on_any_number_of_threads() {
        let [one, four] = [1, 4].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
        for experiment in all() {
            let run = || format!("{:?}", (experiment.run)().map_err(|e| e.to_string()));
            assert_eq!(one.install(run), four.install(run), "{}", experiment.id);
        }
    }
}
