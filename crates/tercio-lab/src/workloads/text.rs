//! Reads the small line formats of the workloads, with the place of every mistake.

use super::SyntaxError;

/// The part of a line that has not been read yet.
pub struct Line<'a> {
    number: usize,
    rest: &'a str,
}

/// The lines that hold something, with their numbers from 1. `#` begins a comment.
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
    /// The error that `expected` does not stand where reading stopped.
    pub fn error(&self, expected: impl Into<String>) -> SyntaxError {
        let mut found: String = self.rest.chars().take(24).collect();
        found = if found.is_empty() { "the end of the line".into() } else { format!("\"{found}\"") };
        SyntaxError { line: self.number, expected: expected.into(), found }
    }

    /// The error that a number does not mean what it should.
    pub fn wrong(&self, expected: impl Into<String>, found: impl ToString) -> SyntaxError {
        SyntaxError { line: self.number, expected: expected.into(), found: found.to_string() }
    }

    /// Takes a piece of text that has to stand here.
    pub fn literal(&mut self, text: &str) -> Result<(), SyntaxError> {
        match self.rest.strip_prefix(text) {
            Some(rest) => {
                self.rest = rest.trim_start();
                Ok(())
            }
            None => Err(self.error(format!("\"{text}\""))),
        }
    }

    /// Takes a number; `what` names it in the error.
    pub fn number<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, SyntaxError> {
        let end =
            self.rest.find(|c: char| c.is_whitespace() || "(),=".contains(c)).unwrap_or(self.rest.len());
        let value = self.rest[..end].parse().map_err(|_| self.error(what))?;
        self.rest = self.rest[end..].trim_start();
        Ok(value)
    }

    /// Takes `(x, y)`.
    pub fn point<T: std::str::FromStr>(&mut self) -> Result<[T; 2], SyntaxError> {
        self.literal("(")?;
        let x = self.number("x, a whole number of pixels")?;
        self.literal(",")?;
        let y = self.number("y, a whole number of pixels")?;
        self.literal(")")?;
        Ok([x, y])
    }

    /// The line must end here.
    pub fn end(&self) -> Result<(), SyntaxError> {
        if self.rest.is_empty() { Ok(()) } else { Err(self.error("the end of the line")) }
    }
}
