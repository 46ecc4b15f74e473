//! The report as one page of Markdown.

use std::fmt::Write;

use super::equations::Typeset;
use super::{Format, Text};

/// Markdown (CommonMark with tables).
#[derive(Default)]
pub(super) struct Markdown(String);

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

    fn equation(&mut self, equation: &Typeset) {
        self.line(format_args!("`{}` ({})", equation.source, markdown_escaped(&equation.text)));
    }

    fn end(&mut self) -> String {
        std::mem::take(&mut self.0)
    }
}
