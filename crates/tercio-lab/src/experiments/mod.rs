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
mod verdict;

use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;

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

    /// What each experiment is found to be: a change of any is seen here.
    const VERDICTS: &[(&str, &str)] = &[
        ("eldridge-table-4-2", "contradicted in part"),
        ("eldridge-fig-4-3", "contradicted in part"),
        ("eldridge-fig-5-4", "reproduced after correction"),
        ("eldridge-fig-5-5-analytic", "restated"),
        ("eldridge-fig-5-6-analytic", "reproduced after correction"),
        ("eldridge-fig-6-3", "restated"),
        ("eldridge-fig-6-4", "restated"),
        ("eldridge-fig-6-5", "contradicted in part"),
        ("eldridge-chapter-8", "contradicted in part"),
        ("eldridge-table-8-1", "contradicted in part"),
        ("eldridge-fig-4-1", "qualitative"),
        ("eldridge-fig-4-2", "qualitative"),
        ("eldridge-fig-4-3-pixels", "qualitative"),
        ("eldridge-fig-5-3", "qualitative"),
        ("eldridge-fig-5-5", "qualitative"),
        ("eldridge-fig-5-6", "contradicted"),
        ("eldridge-fig-5-7", "qualitative"),
        ("eldridge-fig-5-8", "contradicted"),
        ("eldridge-fig-5-9", "contradicted in part"),
        ("eldridge-fig-6-6", "contradicted in part"),
        ("eldridge-fig-6-7", "qualitative"),
        ("eldridge-chapter-7", "contradicted in part"),
        ("eldridge-fig-7-1", "contradicted"),
        ("eldridge-fig-a-2", "reproduced after correction"),
        ("eldridge-fig-a-6", "reproduced"),
        ("eldridge-fig-a-7", "qualitative"),
        ("hybris-fig-2-15", "restated"),
        ("hybris-fig-2-16", "restated"),
        ("hybris-fig-2-14", "qualitative"),
        ("hybris-fig-2-15-counted", "reproduced"),
        ("hybris-fig-3-18", "restated"),
        ("hybris-sec-2-1-2", "contradicted in part"),
        ("hybris-sec-4-5-2", "contradicted in part"),
        ("hybris-fig-4-11", "restated"),
        ("hybris-fig-4-12", "restated"),
        ("hybris-eq-4-7", "reproduced after correction"),
        ("hybris-sec-2-3-classes", "qualitative"),
        ("hybris-sec-2-4-measured", "qualitative"),
        ("hybris-sec-4-4-pages", "qualitative"),
        ("hybris-sec-3-6-fifos", "qualitative"),
        ("hybris-sec-4-6-asic", "qualitative"),
        ("hybris-sec-4-5-1-bus", "by construction"),
        ("hybris-fig-4-12-simulated", "contradicted"),
        ("hybris-sec-3-2-4-culling", "qualitative"),
        ("hybris-fig-3-23", "qualitative"),
        ("hybris-fig-3-26", "qualitative"),
        ("hybris-fig-3-25", "qualitative"),
        ("parks-table-2-2", "restated"),
        ("parks-fig-14", "contradicted"),
        ("parks-app-c", "reproduced after correction"),
        ("parks-fig-15-25", "qualitative"),
        ("parks-fig-28", "restated"),
        ("parks-fig-29", "restated"),
        ("parks-fig-31", "qualitative"),
        ("parks-app-c-scene", "contradicted"),
        ("parks-fig-15-scene", "by construction"),
        ("parks-fig-13", "qualitative"),
        ("parks-fig-27", "qualitative"),
        ("parks-fig-22-25-scenes", "qualitative"),
        ("mcmanus-table-1", "restated"),
        ("mcmanus-fig-5", "reproduced after correction"),
        ("mcmanus-fig-6", "restated"),
        ("mcmanus-table-2", "restated"),
        ("mcmanus-fig-2", "qualitative"),
        ("mcmanus-fig-3", "restated"),
        ("mcmanus-fig-4", "restated"),
        ("mcmanus-fig-7", "restated"),
        ("mcmanus-table-3", "restated"),
        ("mcmanus-table-1-scenes", "qualitative"),
        ("mcmanus-fig-3-scenes", "qualitative"),
        ("mcmanus-table-3-scenes", "qualitative"),
        ("ortega-tables", "contradicted in part"),
        ("ortega-fig-3", "qualitative"),
        ("ortega-fig-4", "qualitative"),
        ("ortega-time-model", "qualitative"),
        ("ortega-fig-3-steps", "contradicted"),
        ("ortega-fig-4-steps", "contradicted"),
        ("others-radix-k", "contradicted"),
        ("others-64-megapixels", "qualitative"),
        ("others-framebuffer", "no verdict"),
        ("others-slic", "no verdict"),
    ];

    #[test]
    fn every_experiment_runs_and_has_the_verdict_that_is_known() {
        let directory = tempfile::tempdir().unwrap();
        let experiments: Vec<_> = all().collect();
        let ids: BTreeSet<_> = experiments.iter().map(|e| e.id).collect();
        assert_eq!(ids.len(), experiments.len(), "names are folders");
        let outcomes = reproduce(&experiments, directory.path(), |_| {}).unwrap();
        let mut colliding = Vec::new();
        for outcome in &outcomes {
            let id = outcome.experiment.id;
            let findings = outcome.findings.as_ref().unwrap_or_else(|e| panic!("{id}: {e}"));
            assert!(findings.tables.iter().all(|t| !t.rows.is_empty()), "{id} has an empty table");
            for plot in &findings.plots {
                let on_zero = plot.x.categories.is_none() || plot.y.scale == Scale::Linear;
                assert!(on_zero, "{id}/{}: bars stand on zero, which no logarithmic axis has", plot.name);
                let file = |extension| directory.path().join(id).join(format!("{}.{extension}", plot.name));
                assert!(file("svg").is_file() && file("pdf").is_file());
                let collisions = plot.collisions().into_iter().map(|c| format!("{id}/{}: {c}", plot.name));
                colliding.extend(collisions);
            }
        }
        let found: Vec<_> = outcomes
            .iter()
            .map(|o| (o.experiment.id, o.findings.as_ref().map_or("failed", |f| f.verdict.name())))
            .collect();
        if found != VERDICTS {
            let text =
                |o: &Outcome| o.findings.as_ref().map_or_else(ToString::to_string, |f| f.verdict.text());
            let lines = outcomes.iter().zip(&found).filter(|(_, f)| !VERDICTS.contains(f));
            let lines: Vec<_> = lines.map(|(o, f)| format!("{f:?}, // {}", text(o))).collect();
            panic!("verdicts that are not in the list:\n{}", lines.join("\n"));
        }
        assert!(colliding.is_empty(), "{colliding:#?}");
        report::write(&outcomes, &published::check_all().unwrap(), directory.path()).unwrap();
        let page = std::fs::read_to_string(directory.path().join("index.html")).unwrap();
        let markdown = std::fs::read_to_string(directory.path().join("report.md")).unwrap();
        assert!(ids.iter().all(|id| page.contains(id) && markdown.contains(id)));
        assert!(page.contains(&summary(&outcomes)) && markdown.contains(&summary(&outcomes)));
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
