//! Parses the small line formats of the workloads, with the line of every mistake.

use super::SyntaxError;

/// The unparsed rest of a line.
pub struct Line<'a> {
    number: usize,
    rest: &'a str,
}

/// The lines that are not empty, with their numbers from 1. `#` begins a comment.
pub fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let lines = text.lines().enumerate().map(|(index, line)| {
        let rest = line.split('#').next().unwrap_or_default().trim();
        Line { number: index + 1, rest }
    });
    lines.filter(|line| !line.rest.is_empty())
}

/// The error of a file that ends too early.
pub fn missing(text: &str, expected: impl Into<String>) -> SyntaxError {
    SyntaxError { line: text.lines().count() + 1, expected: expected.into(), found: "the end".into() }
}

impl Line<'_> {
    /// The error that `expected` is missing where parsing stopped.
    pub fn error(&self, expected: impl Into<String>) -> SyntaxError {
        let mut found: String = self.rest.chars().take(24).collect();
        found = if found.is_empty() { "the end of the line".into() } else { format!("\"{found}\"") };
        SyntaxError { line: self.number, expected: expected.into(), found }
    }

    /// The error that a value is not the expected one.
    pub fn wrong(&self, expected: impl Into<String>, found: impl ToString) -> SyntaxError {
        SyntaxError { line: self.number, expected: expected.into(), found: found.to_string() }
    }

    /// Consumes a given piece of text.
    pub fn literal(&mut self, text: &str) -> Result<(), SyntaxError> {
        match self.rest.strip_prefix(text) {
            Some(rest) => {
                self.rest = rest.trim_start();
                Ok(())
            }
            None => Err(self.error(format!("\"{text}\""))),
        }
    }

    /// Consumes a number; `what` names it in the error.
    pub fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, SyntaxError> {
        let end =
            self.rest.find(|c: char| c.is_whitespace() || "(),=".contains(c)).unwrap_or(self.rest.len());
        let value = self.rest[..end].parse().map_err(|_| self.error(what))?;
        self.rest = self.rest[end..].trim_start();
        Ok(value)
    }

    /// Consumes `(x, y)`.
    pub fn point<T: std::str::FromStr>(&mut self) -> Result<[T; 2], SyntaxError> {
        self.literal("(")?;
        let x = self.number("x, a whole number of pixels")?;
        self.literal(",")?;
        let y = self.number("y, a whole number of pixels")?;
        self.literal(")")?;
        Ok([x, y])
    }

    /// Checks that the line ends here.
    pub fn end(&self) -> Result<(), SyntaxError> {
        if self.rest.is_empty() { Ok(()) } else { Err(self.error("the end of the line")) }
    }
}
