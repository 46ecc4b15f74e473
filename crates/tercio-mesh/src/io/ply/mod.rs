//! PLY, the Stanford polygon format: ASCII and binary of both byte orders.
//!
//! The header (`header`) declares elements: tables of numbers and lists. `plan` decides which of them are kept;
//! `binary` and `ascii` read the kept ones into tables of the mesh's own types (`table`); `assemble` makes triangles
//! of faces and strips and assembles the mesh, which has to wait for the end because the elements may come in any
//! order.
//!
//! Source: G. Turk, "The PLY Polygon File Format" (1994), with the property names in common use.

mod ascii;
mod assemble;
mod binary;
mod direct;
mod faces;
mod header;
mod layout;
mod plan;
mod row;
pub(super) mod share;
mod table;
#[cfg(test)]
mod tests;
mod wedges;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::{ReadModel, ReadOptions, input::Input, obj::transcode};
use crate::ReadError;
use crate::error::{Place, counted, printable};
use header::Encoding;
use plan::Role;

/// Does the content look like PLY?
pub fn looks_like(input: &Input) -> bool {
    start(input).is_some()
}

/// Where the line "ply" begins, and what precedes it. Nothing should; a byte order mark, blank lines and one other
/// line are skipped.
struct Start {
    at: usize,
    lines: u64,
    warning: Option<String>,
}

fn start(input: &Input) -> Option<Start> {
    let bytes = input.bytes();
    let without_space = |text| {
        let space = input.position(text, |b| !b.is_ascii_whitespace()).unwrap_or(text.len());
        text.get(space..).unwrap_or_default()
    };
    let marked = transcode::without_mark(bytes);
    let mut warning = marked.map(|_| transcode::MARK_WARNING.to_owned());
    let mut text = without_space(marked.unwrap_or(bytes));
    let is_magic = |text: &[u8]| text.starts_with(b"ply") && text.get(3).is_none_or(u8::is_ascii_whitespace);
    if !is_magic(text) {
        let length = text.iter().take(1 << 12).position(|b| matches!(b, b'\n' | b'\r'))?;
        let (line, rest) = text.split_at(length);
        text = without_space(rest);
        // Without the format line, any text may happen to have such a line.
        let second = without_space(text.get(3..).unwrap_or_default());
        if !is_magic(text) || !second.starts_with(b"format ") {
            return None;
        }
        warning = Some(format!("ignored the line before \"ply\": {}", printable(line.trim_ascii_end())));
    }
    let at = bytes.len() - text.len();
    let before = bytes.get(..at).unwrap_or_default();
    let ends = |end: u8| input.count(before, |b| b == end);
    let lines = match ends(b'\n') {
        0 => ends(b'\r'),
        n => n,
    };
    Some(Start { at, lines, warning })
}

/// Reads PLY.
///
/// Positions, normals, colours and texture coordinates are found by the usual property names; all other scalars of
/// vertices and faces become attributes. Texture coordinates given at the corners of faces split the vertices at
/// which they differ, so there may be more vertices than in the file; the copies come after the vertices of the file.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let Start { at, lines, warning } = start(input).unwrap_or(Start { at: 0, lines: 0, warning: None });
    let bytes = input.bytes().get(at..).unwrap_or_default();
    read_from(input, bytes, options, warning).map_err(|error| error.shifted(lines, at as u64))
}

/// Reads from the line "ply" on.
fn read_from(
    input: &Input,
    mut bytes: &[u8],
    options: &ReadOptions,
    warning: Option<String>,
) -> Result<ReadModel, ReadError> {
    let mut header = header::parse(input, bytes)?;
    header.warnings.splice(0..0, warning);
    if header.encoding == Encoding::Ascii {
        // If nothing follows the header, zeros on its last line are part of the header.
        let (before, body) = bytes.split_at(header.body);
        let text = input.unpadded(body);
        if text.len() < body.len() {
            let padding = counted((body.len() - text.len()) as u64, "zero byte");
            header.warnings.push(format!("ignored {padding} at the end"));
            bytes = bytes.get(..before.len() + text.len()).unwrap_or_default();
        }
    }
    let job = Job {
        input,
        file: &input.name,
        bytes,
        options,
        held: AtomicU64::new(input.held_bytes()),
        warnings: Mutex::new(Vec::new()),
    };
    let mut warnings = std::mem::take(&mut header.warnings);
    let plans = plan::make(&input.name, &header, bytes, &mut warnings)?;
    warnings.into_iter().for_each(|w| job.warn(w));
    let tables = match header.encoding {
        Encoding::Ascii => ascii::read(&job, &header, &plans)?,
        Encoding::LittleEndian => binary::read(&job, &header, &plans, false)?,
        Encoding::BigEndian => binary::read(&job, &header, &plans, true)?,
    };
    let mut model = assemble::model(&job, &header, plans, tables, input.base.as_deref())?;
    model.report.format = match header.encoding {
        Encoding::Ascii => "PLY, ASCII",
        Encoding::LittleEndian => "PLY, binary little-endian",
        Encoding::BigEndian => "PLY, binary big-endian",
    }
    .into();
    model.report.file_bytes = input.file_bytes;
    model.report.warnings = job.warnings.into_inner().unwrap_or_default();
    Ok(model)
}

/// State of a reading: the input, the memory taken so far, and the warnings.
#[derive(Debug)]
struct Job<'a> {
    input: &'a Input,
    file: &'a str,
    bytes: &'a [u8],
    options: &'a ReadOptions<'a>,
    /// Bytes of memory taken.
    held: AtomicU64,
    warnings: Mutex<Vec<String>>,
}

impl Job<'_> {
    fn warn(&self, warning: String) {
        if let Ok(mut warnings) = self.warnings.lock() {
            warnings.push(warning);
        }
    }

    /// Checks the memory limit before memory is taken.
    fn reserve(&self, what: &str, bytes: u64) -> Result<(), ReadError> {
        let needed = self.held.load(Relaxed).saturating_add(bytes);
        self.options.check_memory(self.file, what, needed)?;
        self.held.store(needed, Relaxed);
        Ok(())
    }

    fn begin(&self, role: Role, total: u64) {
        if let Some(progress) = self.options.progress {
            let stage = if role == Role::Vertices { "reading vertices" } else { "reading faces" };
            progress.begin(stage, total);
        }
    }

    fn advance(&self, units: u64) {
        if let Some(progress) = self.options.progress {
            progress.advance(units);
        }
    }
}

fn malformed(file: &str, place: Place, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
    ReadError::Malformed { file: file.into(), place, expected: expected.into(), found: found.into() }
}
