//! The experiments: one per published figure or table, each with its data, its plot and its verdict.
//!
//! An [`Experiment`] is a name, the place in the document and a function that computes its [`Findings`]: tables, plots,
//! remarks, and a [`Verdict`] that is derived from a comparison of numbers. To add one, write a function in the module
//! of its document and list it there; [`all`] chains the modules. [`reproduce`] runs experiments on all cores and
//! writes them; [`report`] joins them to one page.

mod comparison;
pub mod eldridge;
mod facts;
mod files;
mod hidden;
pub mod hybris;
pub mod mcmanus;
pub mod ortega;
mod others;
pub mod parks;
mod plot;
pub mod report;
mod simulated;
mod sweep;
mod table;
mod unstated;
mod verdict;

use std::path::Path;

use serde::Serialize;
use tercio_mesh::loops::prelude::*;

pub use comparison::Comparison;
pub use facts::Facts;
pub use files::WriteError;
pub use hidden::Fit;
pub use plot::{Axis, Categories, Mark, Plot, Role, Scale, Series};
pub use table::{Cell, Column, Table};
pub use verdict::Verdict;

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

/// The five documents, and what others have published since.
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
    /// Scalings of compositing systems, from abstracts and a figure: no document of ours.
    Others,
}

impl Document {
    /// All of them, in order.
    pub const ALL: [Self; 6] =
        [Self::Eldridge, Self::Hybris, Self::Parks, Self::McManus, Self::Ortega, Self::Others];

    /// The number that the project uses for it, or a word.
    pub fn number(self) -> &'static str {
        match self {
            Self::Eldridge => "000",
            Self::Hybris => "001",
            Self::Parks => "002",
            Self::McManus => "003",
            Self::Ortega => "004",
            Self::Others => "others",
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
            Self::Others => {
                "Scalings that others published, predicted by the formulas of --organisation auto and 'tercio lab advise': T. Peterka \
                 and others, SC09; W. Kendall and others, EGPGV 2010; K. Moreland and others, SC11; W. Usher and others, EuroVis 2019; \
                 A. Stompel and others, PVG 2003. We have their abstracts and one figure, not the papers."
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

/// How many of them have which verdict, in words.
pub fn summary(outcomes: &[Outcome]) -> String {
    verdict::summary(outcomes.iter().map(|outcome| outcome.findings.as_ref().ok().map(|f| &f.verdict)))
}

/// The experiments of each module, in the order of the documents.
const MODULES: &[&[Experiment]] = &[
    eldridge::communication::EXPERIMENTS,
    eldridge::composition::EXPERIMENTS,
    eldridge::accounting::EXPERIMENTS,
    simulated::ring::EXPERIMENTS,
    hybris::overlap::EXPERIMENTS,
    hybris::counted::EXPERIMENTS,
    hybris::performance::EXPERIMENTS,
    hybris::sorting::EXPERIMENTS,
    hybris::heap::EXPERIMENTS,
    hybris::engines::EXPERIMENTS,
    hybris::culling::EXPERIMENTS,
    hybris::parallel::EXPERIMENTS,
    hybris::sampling::EXPERIMENTS,
    parks::costs::EXPERIMENTS,
    parks::tables::EXPERIMENTS,
    simulated::parks::EXPERIMENTS,
    simulated::sections::EXPERIMENTS,
    simulated::objects::EXPERIMENTS,
    mcmanus::overlap::EXPERIMENTS,
    mcmanus::sizing::EXPERIMENTS,
    simulated::mcmanus::EXPERIMENTS,
    ortega::speed::EXPERIMENTS,
    ortega::time_model::EXPERIMENTS,
    simulated::ortega::EXPERIMENTS,
    others::radix_k::EXPERIMENTS,
    others::megapixels::EXPERIMENTS,
    others::frames::EXPERIMENTS,
];

/// Numbers that contradict print and are in no experiment's verdict, and why.
const WITHOUT_EXPERIMENT: [(&str, &str); 3] = [
    ("E3.14-C", "a sign in an equation of geometry; no figure, table or printed number follows from it"),
    ("EA-fig2", "figure A-2 is reproduced with its map corrected, which is what contradicts print"),
    ("M-14", "an equation beside the document's tables; no figure, table or printed number follows from it"),
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
mod tests;
