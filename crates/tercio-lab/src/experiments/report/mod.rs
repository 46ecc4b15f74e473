//! The report: a site of `index.html` and one page a document, without scripts and without anything from the network, and
//! all of it once more as `report.md`.

mod diagram;
mod equations;
mod expression;
mod html;
mod markdown;

use std::path::Path;

use self::equations::Typeset;
use self::html::Html;
use self::markdown::Markdown;
use super::files::{self, WriteError};
use super::{Document, Outcome, Table, WITHOUT_EXPERIMENT, unstated};
use crate::experiments;
use crate::machines::{self, Machine, NAMES};
use crate::predict::quoted::{self, Quoted, QuotedRow};
use crate::published::{Agreement, Check, summary};

/// Writes `report.md` and the site into `directory`, beside the experiments' folders.
///
/// # Errors
/// A file that cannot be written.
pub fn write(outcomes: &[Outcome], checks: &[Check], directory: impl AsRef<Path>) -> Result<(), WriteError> {
    let directory = directory.as_ref();
    files::write(&directory.join("report.md"), whole(outcomes, checks))?;
    for page in Page::ALL.into_iter().filter(|page| page.has_content(outcomes)) {
        let mut html = Html::default();
        html.head(&page.title());
        let others = Page::ALL.into_iter().filter(|p| p.has_content(outcomes));
        html.links("Pages", &others.map(|p| (p.name(), p.file().to_owned())).collect::<Vec<_>>());
        page.write(outcomes, checks, &mut html);
        files::write(&directory.join(page.file()), html.end())?;
    }
    Ok(())
}

/// The elements of a report; the two output formats differ only in how they write them.
trait Format {
    fn head(&mut self, title: &str);
    fn heading(&mut self, level: usize, text: &str, anchor: Option<&str>);
    fn paragraph(&mut self, text: &str);
    fn labelled(&mut self, label: &str, text: &str);
    fn picture(&mut self, path: &str, title: &str);
    fn links(&mut self, label: &str, links: &[(String, String)]);
    fn table(&mut self, header: &[&str], rows: &[Vec<Text>]);
    fn equation(&mut self, equation: &Typeset);
    /// A drawing as SVG, where it can be shown.
    fn drawing(&mut self, _svg: &str) {}
    /// The data of an experiment, where they can be folded away.
    fn data(&mut self, _table: &Table) {}
    fn end(&mut self) -> String;
}

/// A cell of a table of the report.
struct Text {
    text: String,
    link: Option<String>,
}

impl From<String> for Text {
    fn from(text: String) -> Self {
        Self { text, link: None }
    }
}

/// A page of the site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Page {
    Overview,
    Of(Document),
    Machines,
    Prediction,
    Numbers,
}

impl Page {
    const ALL: [Self; 10] = [
        Self::Overview,
        Self::Of(Document::Eldridge),
        Self::Of(Document::Hybris),
        Self::Of(Document::Parks),
        Self::Of(Document::McManus),
        Self::Of(Document::Ortega),
        Self::Of(Document::Others),
        Self::Machines,
        Self::Prediction,
        Self::Numbers,
    ];

    /// Does it exist? A document without experiments has no page.
    fn has_content(self, outcomes: &[Outcome]) -> bool {
        match self {
            Self::Of(document) => outcomes.iter().any(|o| o.experiment.document == document),
            _ => true,
        }
    }

    fn file(self) -> &'static str {
        match self {
            Self::Overview => "index.html",
            Self::Of(Document::Eldridge) => "eldridge.html",
            Self::Of(Document::Hybris) => "hybris.html",
            Self::Of(Document::Parks) => "parks.html",
            Self::Of(Document::McManus) => "mcmanus.html",
            Self::Of(Document::Ortega) => "ortega.html",
            Self::Of(Document::Others) => "others.html",
            Self::Machines => "machines.html",
            Self::Prediction => "prediction.html",
            Self::Numbers => "numbers.html",
        }
    }

    /// Its name in links.
    fn name(self) -> String {
        match self {
            Self::Overview => "overview".into(),
            Self::Of(Document::Others) => "published scalings".into(),
            Self::Of(document) => {
                format!("{} {document:?}", document.number())
            }
            Self::Machines => "machines".into(),
            Self::Prediction => "predictions".into(),
            Self::Numbers => "published numbers".into(),
        }
    }

    fn title(self) -> String {
        match self {
            Self::Overview => TITLE.into(),
            Self::Of(Document::Others) => "Published scalings, predicted".into(),
            Self::Of(document) => format!("Document {}", document.number()),
            Self::Machines => "Machines".into(),
            Self::Prediction => "The renderer, predicted and measured".into(),
            Self::Numbers => "Published numbers".into(),
        }
    }

    fn write(self, outcomes: &[Outcome], checks: &[Check], to: &mut impl Format) {
        match self {
            Self::Overview => {
                to.paragraph(INTRODUCTION);
                overview(
                    outcomes,
                    checks,
                    &|o| format!("{}#{}", Self::Of(o.experiment.document).file(), o.experiment.id),
                    to,
                );
            }
            Self::Of(of) => document(of, outcomes, to),
            Self::Machines => all_machines(to),
            Self::Prediction => predicted_frames(to),
            Self::Numbers => published_numbers(checks, to),
        }
    }
}

const TITLE: &str = "Published graphics machines, reproduced";
const INTRODUCTION: &str = "Every figure and table of the five documents that follows from a formula or a simulator, \
    reproduced: data, plot, and result of the comparison; and scalings that others published, predicted. \
    Lost scenes are replaced by our own, and marked so.";

const CLASSES: &str = "Reproduced: something other than the document's own formula gives the printed numbers. Restated: the document's own \
    formula does, which shows that it is read as it was meant. By construction: an input was chosen so that they come out. Qualitative: \
    only the shape can be compared, or an input is not stated. Contradicted: something that is printed does not agree; in part, if a \
    printed number does. A print is compared once, and how many numbers agree makes no difference. No verdict: what is published does \
    not determine whether ours is right.";

/// The report as one page of Markdown.
fn whole(outcomes: &[Outcome], checks: &[Check]) -> String {
    let mut to = Markdown::default();
    to.head(TITLE);
    to.paragraph(INTRODUCTION);
    to.heading(2, "Overview", None);
    overview(outcomes, checks, &|o| format!("#{}", o.experiment.id), &mut to);
    for page in &Page::ALL[1..] {
        if page.has_content(outcomes) && *page != Page::Machines {
            let anchor = (*page == Page::Prediction).then_some("prediction");
            to.heading(2, &page.title(), anchor);
            page.write(outcomes, checks, &mut to);
        }
    }
    to.end()
}

fn overview(outcomes: &[Outcome], checks: &[Check], link: &dyn Fn(&Outcome) -> String, to: &mut impl Format) {
    let verdict = |o: &Outcome| o.findings.as_ref().map_or("failed", |f| f.verdict.name());
    let row = |o: &Outcome| {
        let link = Text { text: o.experiment.title.into(), link: Some(link(o)) };
        let place = format!("{} {}", o.experiment.document.number(), o.experiment.place);
        vec![Text::from(place), link, Text::from(verdict(o).to_owned())]
    };
    to.table(&["place", "experiment", "verdict"], &outcomes.iter().map(row).collect::<Vec<_>>());
    to.paragraph(&experiments::summary(outcomes));
    to.paragraph(CLASSES);
    let of = |(class, count): (Agreement, usize)| format!("{count} {}", class.text());
    let classes: Vec<_> = summary(checks).into_iter().map(of).collect();
    to.paragraph(&format!("Of {} numbers of the documents: {}.", checks.len(), classes.join(", ")));
}

fn document(of: Document, outcomes: &[Outcome], to: &mut impl Format) {
    to.paragraph(of.reference());
    let equations = equations::of(of);
    if !equations.is_empty() {
        to.heading(3, "Equations", None);
        to.paragraph(
            "Corrected where the document or its scan is wrong. The name is that of 'tercio lab eval'; one that ends in \
             'as-printed' has the printed form, or what follows from it. Of several lines, the last ones are the result.",
        );
        equations.iter().for_each(|e| to.equation(e));
        let left_out = equations::left_out(of);
        if !left_out.is_empty() {
            to.paragraph(&format!("Not typeset: {}.", left_out.join("; ")));
        }
    }
    unstated_inputs(of, outcomes, to);
    to.paragraph(
        "In the figures, filled symbols and bars and solid lines are computed here; hollow symbols, dashed lines and hatched \
         bars are the document's own values and equations.",
    );
    let of_document = |machine: &Machine| machine.sorting.source.starts_with(of.number());
    let machines: Vec<_> = built_in().filter(of_document).collect();
    if !machines.is_empty() {
        to.heading(3, "Machines", None);
        machines.iter().for_each(|m| machine(m, to));
    }
    outcomes.iter().filter(|o| o.experiment.document == of).for_each(|o| experiment(o, to));
}

/// What every figure of a document asks of inputs that it does not state, and whether one value gives all.
fn unstated_inputs(of: Document, outcomes: &[Outcome], to: &mut impl Format) {
    let inputs = unstated::joined(outcomes.iter().filter(|o| o.experiment.document == of));
    if inputs.is_empty() {
        return;
    }
    to.heading(3, unstated::HEADING, Some(&format!("unstated-{}", of.number())));
    to.paragraph(
        "Each was swept, figure by figure: in these intervals ours is what is printed. A scene that is lost has one value in all \
         figures that draw it from the same view; pictures with another number of visible polygons are other views. \
         Readings of one print are alternatives.",
    );
    let rows: Vec<Vec<Text>> = inputs
        .iter()
        .flat_map(|input| {
            input.prints.iter().map(|print| {
                let [number, intervals] = print.cells();
                [input.name.clone(), print.place.clone(), number, intervals].map(Text::from).into()
            })
        })
        .collect();
    to.table(&["input", "figure", "printed", "values that give it"], &rows);
    for conclusion in inputs.iter().filter_map(unstated::Input::conclusion) {
        to.paragraph(&conclusion);
    }
}

/// The built-in machines. A test reads them all.
fn built_in() -> impl Iterator<Item = Machine> {
    NAMES.iter().filter_map(|name| machines::load(name).ok())
}

fn all_machines(to: &mut impl Format) {
    to.paragraph(
        "Where each machine sorts, and what travels there. At most three units of a stage are drawn; the last one stands for \
         those between. Stages that differ in number or kind are those of the machine's description; otherwise the same \
         processors are drawn twice, for geometry and for rasterization. Of a machine with tile engines, its pipeline is drawn: heap, stages of each engine, and the entries of \
         the queues between them; of more than two engines or lanes two are drawn.",
    );
    for of in built_in() {
        to.heading(3, &of.name, None);
        machine(&of, to);
    }
}

fn machine(of: &Machine, to: &mut impl Format) {
    let Machine { name, summary, sorting, processors, network, .. } = of;
    to.labelled(name, &format!("{summary} {} ({}).", sorting.how, sorting.source));
    to.drawing(&diagram::svg(of));
    let network = network
        .as_ref()
        .map_or(String::new(), |n| format!("; network: {}, {} a link", n.topology.name(), n.bandwidth));
    to.paragraph(&format!(
        "Sorting: {}; screen: {}; processors: {}{network}.",
        sorting.class.name(),
        sorting.screen.name(),
        processors.count
    ));
}

fn experiment(outcome: &Outcome, to: &mut impl Format) {
    let of = &outcome.experiment;
    to.heading(3, &format!("{}: {}", of.place, of.title), Some(of.id));
    let findings = match &outcome.findings {
        Ok(findings) => findings,
        Err(error) => return to.labelled("failed", &error.to_string()),
    };
    to.labelled(findings.verdict.name(), &findings.verdict.text());
    if findings.tables.iter().any(|table| table.name == unstated::INTERVALS) {
        to.paragraph(unstated::REFERENCE);
    }
    for remark in &findings.remarks {
        to.paragraph(remark);
    }
    for plot in &findings.plots {
        to.picture(&format!("{}/{}.svg", of.id, plot.name), &plot.title);
    }
    let file = |name: &String| (format!("{name}.csv"), format!("{}/{name}.csv", of.id));
    findings.tables.iter().for_each(|t| to.data(t));
    to.links("Data", &findings.tables.iter().map(|t| file(&t.name)).collect::<Vec<_>>());
}

/// Predictions for the renderer, compared with measurements: tables from the repository, because a report is the same
/// wherever it is made.
fn predicted_frames(to: &mut impl Format) {
    to.paragraph(
        "Measured before, not with this report. Counters have to be equal, times within the percentage of the \
         verdict. Of two times the first is predicted; the time of a stage is that of its busiest rank, waiting is \
         that of rank 0, page faults and context switches are those of all ranks. Differences are predicted less \
         measured, by stage, the largest first.",
    );
    quoted_frames("Threads", quoted::of_threads(), to);
    quoted_frames("Ranks of one process", quoted::of_ranks(), to);
    quoted_frames("Ranks over MPI", quoted::of_mpi(), to);
}

fn quoted_frames<R: QuotedRow>(title: &str, table: Result<Quoted<R>, toml::de::Error>, to: &mut impl Format) {
    let anchor = format!("prediction-{}", title.to_lowercase().replace(' ', "-"));
    to.heading(3, title, Some(&anchor));
    let table = match table {
        Ok(table) => table,
        Err(error) => return to.labelled("failed", &error.to_string()),
    };
    to.labelled(
        &format!("{} of {} rows hold", table.holding(), table.rows.len()),
        &format!("{}, {}.", table.machine, table.date),
    );
    to.paragraph(&format!("Commands: {}.", table.commands.join("; ")));
    for why in &table.why {
        to.labelled("Misses", why);
    }
    let rows: Vec<Vec<Text>> =
        table.rows.iter().map(|r| r.cells().into_iter().map(Text::from).collect()).collect();
    to.table(R::HEADER, &rows);
}

fn published_numbers(checks: &[Check], to: &mut impl Format) {
    to.paragraph(
        "Ours is compared with what is printed. Where a document or its scan is wrong, ours contradicts the print, and \
         the last column says why, in our reading. Numbers that are read from the scan are measurements on lost scenes; \
         nothing computes them, and a reading is off by what is said of it.",
    );
    let without: Vec<_> = WITHOUT_EXPERIMENT.iter().map(|(id, why)| format!("{id} ({why})")).collect();
    to.paragraph(&format!(
        "Each number that contradicts print is in the verdict of an experiment, but for {}.",
        without.join("; ")
    ));
    let row = |c: &Check| {
        let n = &c.number;
        let unit = n.unit.as_deref().map_or(String::new(), |u| format!(" {u}"));
        [
            n.id.clone(),
            format!("{} {}", n.document, n.place),
            c.print().map_or(String::new(), |_| format!("{}{unit}", c.print_text())),
            c.ours_text(&unit),
            c.tolerance_text(),
            c.agreement().text().to_owned(),
            n.why.clone().unwrap_or_default(),
        ]
        .map(Text::from)
        .into()
    };
    let rows: Vec<Vec<Text>> = checks.iter().map(row).collect();
    to.table(&["number", "place", "printed", "ours", "tolerance", "class", "why"], &rows);
}

#[cfg(test)]
mod tests;
