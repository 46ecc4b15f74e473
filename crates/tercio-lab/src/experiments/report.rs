//! The report: all experiments in the order of the documents, as `report.md` and `index.html`.

use std::fmt::Write;
use std::path::Path;

use super::files::{self, WriteError};
use super::{Document, Outcome};
use crate::predict::quoted::{self, Quoted, QuotedRow};
use crate::published::{Agreement, Check, summary};

/// Writes `report.md` and `index.html` into `directory`, beside the experiments' folders.
///
/// # Errors
/// A file that cannot be written.
pub fn write(outcomes: &[Outcome], checks: &[Check], directory: impl AsRef<Path>) -> Result<(), WriteError> {
    let directory = directory.as_ref();
    files::write(&directory.join("report.md"), &page(outcomes, checks, &mut Markdown::default()))?;
    files::write(&directory.join("index.html"), &page(outcomes, checks, &mut Html::default()))
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

fn page(outcomes: &[Outcome], checks: &[Check], to: &mut impl Format) -> String {
    to.head("Published graphics machines, reproduced");
    to.paragraph(
        "Every figure and table of the five documents that follows from a formula or a simulator, reproduced: data, \
         plot, and result of the comparison. Lost scenes are replaced by our own, and marked so.",
    );
    overview(outcomes, checks, to);
    for document in Document::ALL {
        let of_document = || outcomes.iter().filter(|o| o.experiment.document == document);
        if of_document().next().is_none() {
            continue;
        }
        to.heading(2, &format!("Document {}", document.number()), None);
        to.paragraph(document.reference());
        for outcome in of_document() {
            experiment(outcome, to);
        }
    }
    predicted_frames(to);
    published_numbers(checks, to);
    to.end()
}

fn overview(outcomes: &[Outcome], checks: &[Check], to: &mut impl Format) {
    let verdict = |o: &Outcome| o.findings.as_ref().map_or("failed", |f| f.verdict.name());
    let row = |o: &Outcome| {
        let link = Text { text: o.experiment.title.into(), link: Some(format!("#{}", o.experiment.id)) };
        let place = format!("{} {}", o.experiment.document.number(), o.experiment.place);
        vec![Text::from(place), link, Text::from(verdict(o).to_owned())]
    };
    to.heading(2, "Overview", None);
    to.table(&["place", "experiment", "verdict"], &outcomes.iter().map(row).collect::<Vec<_>>());
    let of = |(class, count): (Agreement, usize)| format!("{count} {}", class.text());
    let classes: Vec<_> = summary(checks).into_iter().map(of).collect();
    to.paragraph(&format!(
        "Of {} numbers of the documents: {}; see the end of the page.",
        checks.len(),
        classes.join(", ")
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
    for remark in &findings.remarks {
        to.paragraph(remark);
    }
    for plot in &findings.plots {
        to.picture(&format!("{}/{}.svg", of.id, plot.name), &plot.title);
    }
    let file = |name: &String| (format!("{name}.csv"), format!("{}/{name}.csv", of.id));
    to.links("Data", &findings.tables.iter().map(|t| file(&t.name)).collect::<Vec<_>>());
}

/// Predictions for the renderer, compared with measurements: tables from the repository, because a report is the same
/// wherever it is made.
fn predicted_frames(to: &mut impl Format) {
    to.heading(2, "The renderer, predicted and measured", Some("prediction"));
    to.paragraph(
        "Measured before, not with this report. Counters have to be equal, times within 25 %. Of two times the \
         first is predicted; the time of a stage is that of its busiest rank, waiting is that of rank 0, page faults \
         and context switches are those of all ranks.",
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
    to.heading(2, "Published numbers", None);
    to.paragraph(
        "Ours is compared with what is printed. Where a document or its scan is wrong, ours contradicts the print, and \
         the last column says why, in our reading. Numbers that are read from the scan are measurements on lost scenes; \
         nothing computes them.",
    );
    let row = |c: &Check| {
        let n = &c.number;
        let unit = n.unit.as_deref().map_or(String::new(), |u| format!(" {u}"));
        let ours = c.ours.as_ref().map_or_else(ToString::to_string, |v| format!("{v}{unit}"));
        [
            n.id.clone(),
            format!("{} {}", n.document, n.place),
            c.print().map_or(String::new(), |_| format!("{}{unit}", c.print_text())),
            ours,
            format!("{} ({})", n.tolerance, c.tolerance_text()),
            c.agreement().text().to_owned(),
            n.why.clone().unwrap_or_default(),
        ]
        .map(Text::from)
        .into()
    };
    let rows: Vec<Vec<Text>> = checks.iter().map(row).collect();
    to.table(&["number", "place", "printed", "ours", "tolerance", "class", "why"], &rows);
}

/// Markdown (CommonMark with tables).
#[derive(Default)]
struct Markdown(String);

impl Markdown {
    // Writing into a string cannot fail.
    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.0, "{text}\n");
    }
}

/// Escapes characters with a meaning in Markdown.
fn markdown_escaped(text: &str) -> String {
    text.replace('|', "\\|").replace('*', "\\*").replace('<', "&lt;").replace('[', "\\[").replace(']', "\\]")
}

impl Format for Markdown {
    fn head(&mut self, title: &str) {
        self.line(format_args!("# {title}"));
    }

    fn heading(&mut self, level: usize, text: &str, anchor: Option<&str>) {
        if let Some(anchor) = anchor {
            self.line(format_args!("<a id=\"{anchor}\"></a>"));
        }
        self.line(format_args!("{} {}", "#".repeat(level), markdown_escaped(text)));
    }

    fn paragraph(&mut self, text: &str) {
        self.line(format_args!("{}", markdown_escaped(text)));
    }

    fn labelled(&mut self, label: &str, text: &str) {
        self.line(format_args!("**{label}.** {}", markdown_escaped(text)));
    }

    fn picture(&mut self, path: &str, title: &str) {
        self.line(format_args!("![{}]({path})", markdown_escaped(title)));
    }

    fn links(&mut self, label: &str, links: &[(String, String)]) {
        let all: Vec<_> = links.iter().map(|(name, path)| format!("[{name}]({path})")).collect();
        self.line(format_args!("{label}: {}", all.join(", ")));
    }

    fn table(&mut self, header: &[&str], rows: &[Vec<Text>]) {
        let _ = writeln!(self.0, "| {} |\n|{}", header.join(" | "), "---|".repeat(header.len()));
        for row in rows {
            let cell = |c: &Text| {
                let text = markdown_escaped(&c.text);
                c.link.as_ref().map_or_else(|| text.clone(), |link| format!("[{text}]({link})"))
            };
            let _ = writeln!(self.0, "| {} |", row.iter().map(cell).collect::<Vec<_>>().join(" | "));
        }
        self.0.push('\n');
    }

    fn end(&mut self) -> String {
        std::mem::take(&mut self.0)
    }
}

/// One HTML page that needs no other files but its pictures.
#[derive(Default)]
struct Html(String);

const STYLE: &str = "body{font:17px/1.5 Georgia,serif;max-width:56rem;margin:2rem auto;padding:0 1rem;color:#111}\
h1,h2,h3{font-family:system-ui,sans-serif;line-height:1.2}h2{margin-top:3rem;border-bottom:1px solid #ccc}\
img{width:100%;margin:1rem 0}table{border-collapse:collapse;font:14px/1.4 system-ui,sans-serif;width:100%}\
td,th{border-bottom:1px solid #ddd;padding:.25rem .5rem;text-align:left;vertical-align:top}a{color:#0072b2}";

impl Html {
    fn line(&mut self, text: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.0, "{text}");
    }
}

fn html_escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl Format for Html {
    fn head(&mut self, title: &str) {
        let title = html_escaped(title);
        self.line(format_args!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>"
        ));
    }

    fn heading(&mut self, level: usize, text: &str, anchor: Option<&str>) {
        let id = anchor.map_or(String::new(), |a| format!(" id=\"{}\"", html_escaped(a)));
        self.line(format_args!("<h{level}{id}>{}</h{level}>", html_escaped(text)));
    }

    fn paragraph(&mut self, text: &str) {
        self.line(format_args!("<p>{}</p>", html_escaped(text)));
    }

    fn labelled(&mut self, label: &str, text: &str) {
        self.line(format_args!("<p><strong>{}.</strong> {}</p>", html_escaped(label), html_escaped(text)));
    }

    fn picture(&mut self, path: &str, title: &str) {
        self.line(format_args!("<img src=\"{}\" alt=\"{}\">", html_escaped(path), html_escaped(title)));
    }

    fn links(&mut self, label: &str, links: &[(String, String)]) {
        let link = |(name, path): &(String, String)| {
            format!("<a href=\"{}\">{}</a>", html_escaped(path), html_escaped(name))
        };
        let all: Vec<_> = links.iter().map(link).collect();
        self.line(format_args!("<p>{label}: {}</p>", all.join(", ")));
    }

    fn table(&mut self, header: &[&str], rows: &[Vec<Text>]) {
        let header: String = header.iter().map(|h| format!("<th>{}</th>", html_escaped(h))).collect();
        self.line(format_args!("<table>\n<tr>{header}</tr>"));
        for row in rows {
            let cell = |c: &Text| {
                let text = html_escaped(&c.text);
                match &c.link {
                    Some(link) => format!("<td><a href=\"{}\">{text}</a></td>", html_escaped(link)),
                    None => format!("<td>{text}</td>"),
                }
            };
            self.line(format_args!("<tr>{}</tr>", row.iter().map(cell).collect::<String>()));
        }
        self.line(format_args!("</table>"));
    }

    fn end(&mut self) -> String {
        self.line(format_args!("</body>\n</html>"));
        std::mem::take(&mut self.0)
    }
}
