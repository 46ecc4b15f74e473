//! Pages of HTML that need no other files but their pictures.

use std::fmt::Write;

use super::equations::Typeset;
use super::{Format, Text};
use crate::experiments::plot::six_digits;
use crate::experiments::{Cell, Column, Table};

/// One HTML page that needs no other files but its pictures.
#[derive(Default)]
pub(super) struct Html(String);

const STYLE: &str = "body{font:17px/1.5 Georgia,serif;max-width:56rem;margin:2rem auto;padding:0 1rem;color:#111}\
h1,h2,h3{font-family:system-ui,sans-serif;line-height:1.2}h2{margin-top:3rem;border-bottom:1px solid #ccc}\
img{width:100%;margin:1rem 0}table{border-collapse:collapse;font:14px/1.4 system-ui,sans-serif;width:100%}\
td,th{border-bottom:1px solid #ddd;padding:.25rem .5rem;text-align:left;vertical-align:top}a{color:#0072b2}\
figure{margin:1rem 0}figure svg{width:100%;height:auto}figcaption{font-size:14px}math{font-size:120%}\
details{margin:.5rem 0;overflow-x:auto}";
/// Rows of a table that a page shows.
const MOST_ROWS: usize = 60;

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

    fn equation(&mut self, equation: &Typeset) {
        let Typeset { text, math, symbols, .. } = equation;
        let (text, symbols) = (html_escaped(text), html_escaped(symbols));
        self.line(format_args!(
            "<figure>{math}<figcaption><strong>{text}.</strong> {symbols}.</figcaption></figure>"
        ));
    }

    fn drawing(&mut self, svg: &str) {
        self.line(format_args!("<figure>{svg}</figure>"));
    }

    fn data(&mut self, table: &Table) {
        let name = html_escaped(&table.name);
        self.line(format_args!("<details><summary>Table: {name}</summary>"));
        let header: Vec<String> = table.columns.iter().map(Column::heading).collect();
        let cell = |cell: &Cell| {
            Text::from(match cell {
                Cell::Number(number) => six_digits(*number),
                Cell::Text(text) => text.clone(),
                Cell::Empty => String::new(),
            })
        };
        let rows: Vec<Vec<Text>> =
            table.rows.iter().take(MOST_ROWS).map(|row| row.iter().map(cell).collect()).collect();
        self.table(&header.iter().map(String::as_str).collect::<Vec<_>>(), &rows);
        if table.rows.len() > MOST_ROWS {
            self.paragraph(&format!("{} more rows are in the file.", table.rows.len() - MOST_ROWS));
        }
        self.line(format_args!("</details>"));
    }

    fn end(&mut self) -> String {
        self.line(format_args!("</body>\n</html>"));
        std::mem::take(&mut self.0)
    }
}
