//! Errors of machine descriptions.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why a machine could not be loaded.
#[derive(Debug, Error)]
pub enum MachineError {
    /// Neither a file nor a built-in machine.
    #[error("no machine \"{name}\": neither a file nor one of {known}")]
    Unknown {
        /// The requested name.
        name: String,
        /// The built-in machines.
        known: String,
    },
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The text is not a valid description.
    #[error("{file}:{line}:{column}: {what}")]
    Text {
        /// Which file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was expected and what was found.
        what: String,
    },
    /// The description lacks a required part.
    #[error("machine \"{machine}\": needed here, and missing in its description: {what}")]
    Missing {
        /// Which machine.
        machine: String,
        /// The section or number.
        what: String,
    },
    /// A network that the machine's control has no rules for.
    #[error(
        "machine \"{machine}\": processors.control = \"simd\" has rules for a ring only, found a network that is a {found}"
    )]
    NoRules {
        /// Which machine.
        machine: String,
        /// The network.
        found: &'static str,
    },
    /// Its engines or processors cannot share a frame in that way.
    #[error("machine \"{machine}\": {what}")]
    Sharing {
        /// Which machine.
        machine: String,
        /// Why.
        what: String,
    },
    /// More processors than the machine may have.
    #[error("machine \"{machine}\": expected at most {most} {what}, found {found}")]
    TooMany {
        /// Which machine.
        machine: String,
        /// Processors, or those that share a memory.
        what: &'static str,
        /// The most that it may have.
        most: u64,
        /// The number requested.
        found: u64,
    },
}

impl MachineError {
    /// Both values; parts that are missing in both are named at once.
    pub(crate) fn both<A, B>(a: Result<A, Self>, b: Result<B, Self>) -> Result<(A, B), Self> {
        match (a, b) {
            (Err(Self::Missing { machine, what }), Err(Self::Missing { what: too, .. })) => {
                Err(Self::Missing { machine, what: format!("{what}, {too}") })
            }
            (a, b) => Ok((a?, b?)),
        }
    }

    /// An error of the TOML reader, with its line and column.
    pub(super) fn of_toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let start = error.span().map_or(0, |s| s.start.min(text.len()));
        Self::after(file, &text[..start], error.message())
    }

    /// The error for bytes after `before` that are not text.
    pub(super) fn of_bytes(file: &str, before: &[u8]) -> Self {
        let before = String::from_utf8_lossy(before);
        Self::after(file, &before, "expected text, found bytes that are not UTF-8")
    }

    /// An error at the position after `before`.
    fn after(file: &str, before: &str, what: &str) -> Self {
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        Self::Text { file: file.into(), line, column, what: what.into() }
    }
}
