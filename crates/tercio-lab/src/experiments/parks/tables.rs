//! The scenes' tables (figures 15 to 25) and the figures that follow from them (28 to 31).

use crate::experiments::facts::Facts;
use crate::experiments::{
    Axis, Cell, Comparison, Document, Experiment, ExperimentError, Findings, Plot, Series, Table,
};
use crate::models::parks::costs;
use crate::units::{Cycles, Seconds};

pub(crate) const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        id: "parks-fig-15-25",
        document: Document::Parks,
        place: "figures 15 to 25",
        title: "Memory cycles of each scene on six machines",
        run: scene_tables,
    },
    Experiment {
        id: "parks-fig-28",
        document: Document::Parks,
        place: "figure 28",
        title: "Time of 16 processors, splitter and interlace, in seconds",
        run: seconds,
    },
    Experiment {
        id: "parks-fig-29",
        document: Document::Parks,
        place: "figures 29 and 30",
        title: "16 processors against one, and the change between similar scenes",
        run: relative,
    },
    Experiment {
        id: "parks-fig-31",
        document: Document::Parks,
        place: "figure 31",
        title: "Time along the approach to the runway",
        run: approach,
    },
];

const FIGURES: std::ops::RangeInclusive<u32> = 15..=25;
const MACHINES: [&str; 6] =
    ["uniprocessor", "interlace 4", "splitter 4", "interlace 16", "splitter 16", "hybrid 16"];
/// Columns of a table.
const UNI: usize = 0;
const INTERLACE_16: usize = 3;
const SPLITTER_16: usize = 4;
/// Pairs of scenes that differ only a little.
const SIMILAR: [(u32, u32); 5] = [(16, 17), (18, 19), (20, 21), (22, 23), (24, 25)];
/// Memory cycle time that the document assumes (4.4).
const CYCLE: Seconds = Seconds::new(300e-9);

/// A figure's cells in millions of cycles; NaN where illegible.
fn cells(facts: &Facts, figure: u32) -> Result<Vec<f64>, ExperimentError> {
    facts.cells(&format!("P-fig{figure}"))
}

/// The values of one column in several figures.
fn column(
    facts: &Facts,
    figures: impl Iterator<Item = u32>,
    machine: usize,
) -> Result<Vec<(f64, f64)>, ExperimentError> {
    figures.map(|figure| Ok((f64::from(figure), cells(facts, figure)?[machine]))).collect()
}

fn scene_tables() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new("scenes", &[("figure", "")]);
    table.columns.extend(Table::new("", &MACHINES.map(|m| (m, "Mcycle"))).columns);
    for figure in FIGURES {
        let row = cells(&facts, figure)?.into_iter().map(Cell::from);
        table.push_row(std::iter::once(Cell::from(f64::from(figure))).chain(row).collect());
    }
    let mut plot = Plot::new(
        "scenes",
        "Slowest processor of each machine",
        Axis::categories("figure", *FIGURES.start(), FIGURES.map(|f| f.to_string())),
        Axis::linear("million memory cycles"),
    );
    for (machine, name) in MACHINES.into_iter().enumerate() {
        plot = plot.with(Series::line_points(name, column(&facts, FIGURES, machine)?).published());
    }
    let why = "All scenes but that of figure 15 are lost, and the tables are hand-lettered and damaged: they are read \
               with the fewest mistaken characters that the cost model allows, and cells that several readings fit stay \
               open. Figure 15 is computed from the counts of appendix C.";
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec![
            "With 4 processors the splitter wins in figures 24 and 25 only, the cargo bay, whose complexity is spread \
             evenly."
                .into(),
        ],
        verdict: Comparison::of_published(&["P-fig#", "P-2cases"])?.qualitative(why),
    })
}

fn seconds() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new("seconds", &[("figure", ""), ("interlace 16", "s"), ("splitter 16", "s")]);
    let time = |millions: f64| costs::time(Cycles::new(millions * 1e6), CYCLE).get();
    let (mut interlace, mut splitter) = (Vec::new(), Vec::new());
    for figure in *FIGURES.start() + 1..=*FIGURES.end() {
        let row = cells(&facts, figure)?;
        let (i, s) = (time(row[INTERLACE_16]), time(row[SPLITTER_16]));
        table.push([f64::from(figure).into(), i.into(), s.into()]);
        interlace.push((f64::from(figure), i));
        splitter.push((f64::from(figure), s));
    }
    let plot = Plot::new(
        "seconds",
        "16 processors with 300 ns a cycle",
        Axis::categories("figure", 16, (16..=25).map(|f| f.to_string())),
        Axis::linear("seconds"),
    )
    .with(Series::line_points("interlace", interlace).published())
    .with(Series::line_points("splitter", splitter).published());
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: vec!["The drawing is lost; it follows from the tables under figures 16 to 25.".into()],
        verdict: Comparison::of_published(&["P-300ns-#-*"])?.verdict(),
    })
}

fn relative() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table = Table::new(
        "relative",
        &[("figure", ""), ("interlace 16 over one", ""), ("splitter 16 over one", "")],
    );
    let (mut interlace, mut splitter) = (Vec::new(), Vec::new());
    for figure in FIGURES {
        let row = cells(&facts, figure)?;
        let (i, s) = (row[INTERLACE_16] / row[UNI], row[SPLITTER_16] / row[UNI]);
        table.push([f64::from(figure).into(), i.into(), s.into()]);
        interlace.push((f64::from(figure), 100.0 * i));
        splitter.push((f64::from(figure), 100.0 * s));
    }
    let mut changes = Table::new(
        "changes",
        &[("from", ""), ("to", ""), ("uniprocessor", "%"), ("interlace 16", "%"), ("splitter 16", "%")],
    );
    for (from, to) in SIMILAR {
        let (before, after) = (cells(&facts, from)?, cells(&facts, to)?);
        let change = |machine: usize| 100.0 * (after[machine] / before[machine] - 1.0);
        changes.push([
            f64::from(from).into(),
            f64::from(to).into(),
            change(UNI).into(),
            change(INTERLACE_16).into(),
            change(SPLITTER_16).into(),
        ]);
    }
    let plot = Plot::new(
        "relative",
        "16 processors over the uniprocessor",
        Axis::categories("figure", *FIGURES.start(), FIGURES.map(|f| f.to_string())),
        Axis::linear("percent of the uniprocessor's time"),
    )
    .with(Series::line_points("interlace", interlace).published())
    .with(Series::line_points("splitter", splitter).published());
    Ok(Findings {
        tables: vec![table, changes],
        plots: vec![plot],
        remarks: vec![
            "A small change of the scene changes the splitter's time by up to 68 %, the interlace's hardly."
                .into(),
        ],
        verdict: Comparison::of_published(&["P-68", "P-4pc", "P-16pc", "P-28pc", "P-4.5"])?.verdict(),
    })
}

fn approach() -> Result<Findings, ExperimentError> {
    let facts = Facts::load()?;
    let mut table =
        Table::new("approach", &[("figure", ""), ("interlace 16", "Mcycle"), ("splitter 16", "Mcycle")]);
    for figure in 16..=21 {
        let row = cells(&facts, figure)?;
        table.push([f64::from(figure).into(), row[INTERLACE_16].into(), row[SPLITTER_16].into()]);
    }
    let plot = Plot::new(
        "approach",
        "Approach to the runway, 16 processors",
        Axis::categories("figure", 16, (16..=21).map(|f| f.to_string())),
        Axis::linear("million memory cycles"),
    )
    .with(Series::line_points("interlace", column(&facts, 16..=21, INTERLACE_16)?).published())
    .with(Series::line_points("splitter", column(&facts, 16..=21, SPLITTER_16)?).published());
    let mut comparison = Comparison::new();
    // The trend that the text describes: between similar scenes the splitter changes more than the interlace.
    for (from, to) in SIMILAR.into_iter().filter(|s| s.1 <= 21) {
        let (before, after) = (cells(&facts, from)?, cells(&facts, to)?);
        let change = |machine: usize| (after[machine] / before[machine] - 1.0).abs();
        if change(INTERLACE_16).is_finite() {
            let steadier = change(INTERLACE_16) < change(SPLITTER_16);
            comparison.claim(format!("interlace steadier from {from} to {to}"), steadier);
        }
    }
    Ok(Findings {
        tables: vec![table],
        plots: vec![plot],
        remarks: Vec::new(),
        verdict: comparison.qualitative("The drawing is lost; the times are those of figures 16 to 21."),
    })
}
