//! `tercio lab machines`: the built-in descriptions, and checking of others.

use std::fmt::Write;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use serde_json::{Value, json};
use tercio::image::Destination;
use tercio_lab::machines::{Machine, NAMES, load};

use crate::named_files::NamedFiles;
use crate::output::write_text;

/// Lists machines, or shows the description of one with the source of each number.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  tercio lab machines
  tercio lab machines hybris-asic
  tercio lab machines mine.toml --json

Exit code: 0 success, 1 error (with line and column), 2 wrong usage.")]
pub struct Machines {
    /// A built-in machine, or a file.
    #[arg(value_name = "MACHINE")]
    machine: Option<String>,
    /// Writes JSON with stable keys.
    #[arg(long)]
    json: bool,
}

impl Machines {
    /// Runs the command.
    ///
    /// # Errors
    /// A machine that does not exist, or mistakes in its description.
    pub fn run(&self) -> Result<ExitCode> {
        let files = self.machine.iter().fold(NamedFiles::default(), |files, name| files.reads_machine(name));
        files.prints().ready()?;
        let text = match &self.machine {
            Some(name) => {
                let machine = load(name)?;
                if self.json {
                    format!("{:#}\n", serde_json::to_value(&machine)?)
                } else {
                    machine.to_toml()?
                }
            }
            None => self.list()?,
        };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }

    fn list(&self) -> Result<String> {
        let machines: Vec<(&str, Machine)> =
            NAMES.iter().map(|n| Ok((*n, load(n)?))).collect::<Result<_>>()?;
        if self.json {
            let all: Value = machines
                .iter()
                .map(|(id, m)| {
                    json!({
                        "id": id, "name": m.name, "summary": m.summary,
                        "sorting": m.sorting.class.name(), "screen": m.sorting.screen.name(),
                        "processors": m.processors.count.whole(),
                    })
                })
                .collect();
            return Ok(format!("{all:#}\n"));
        }
        let mut text = String::new();
        for (id, m) in &machines {
            // Writing into a string cannot fail.
            let _ = writeln!(
                text,
                "{id:24} {:>7} processors, {}, {}\n    {}",
                m.processors.count,
                m.sorting.class.name(),
                m.sorting.screen.name(),
                m.summary
            );
        }
        Ok(text)
    }
}
