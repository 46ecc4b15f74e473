//! Output of the rows of predicted and measured frames.

use std::fs;
use std::io;
use std::path::PathBuf;

use anyhow::{Context, Result};
use serde_json::Value;
use tercio::image::Destination;
use tercio_lab::predict::quoted::{Quoted, QuotedRow, date};

use crate::output::{check, write_text};

/// Standard output, and optionally a table that is kept in a file.
pub struct Measured {
    file: Option<PathBuf>,
    command: String,
    machine: String,
}

impl Measured {
    /// `command` measures the rows on `machine`; a new table records both.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(file: Option<PathBuf>, command: String, machine: String) -> Result<Self> {
        if let Some(path) = &file {
            check(&Destination::from_path(path))?;
        }
        Ok(Self { file, command, machine })
    }

    /// Prints the rows, as JSON or text, and adds them to the table.
    ///
    /// # Errors
    /// What cannot be written, or a file that is not such a table.
    pub fn write<R: QuotedRow>(
        &self,
        as_json: bool,
        json: impl FnOnce() -> Value,
        text: impl FnOnce() -> String,
        rows: &[R],
    ) -> Result<()> {
        if let Some(path) = &self.file {
            let name = || path.display().to_string();
            let mut table = match fs::read_to_string(path) {
                Ok(text) => Quoted::<R>::parse(&text).with_context(name)?,
                Err(error) if error.kind() == io::ErrorKind::NotFound => Quoted::new(self.machine.clone()),
                Err(error) => return Err(error).with_context(name),
            };
            table.add(rows.to_vec(), self.command.clone(), date::today());
            write_text(&Destination::from_path(path), &table.to_toml()?)?;
        }
        let text = if as_json { format!("{:#}\n", json()) } else { text() };
        write_text(&Destination::Stdout, &text)
    }
}
