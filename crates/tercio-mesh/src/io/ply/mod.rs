//! PLY, the Stanford polygon format: ASCII and binary of both byte orders.
//!
//! The header (`header`) declares elements, tables of numbers and lists. `plan` decides what of them is
//! kept; `binary` and `ascii` read the kept part into tables of the mesh's own types (`table`);
//! `assemble` makes triangles of faces and strips and puts the mesh together, which has to wait for the
//! end because the elements may stand in any order.
//!
//! Source: G. Turk, "The PLY Polygon File Format" (1994), with the names of properties that are in use.

mod ascii;
mod assemble;
mod binary;
mod direct;
mod faces;
mod header;
mod layout;
mod plan;
mod row;
mod table;
#[cfg(test)]
mod tests;
mod wedges;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::{ReadModel, ReadOptions, input::Input};
use crate::ReadError;
use crate::error::Place;
use header::Encoding;
use plan::Role;

/// Does the content look like this format?
pub fn looks_like(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.starts_with(b"ply") && start.get(3).is_none_or(u8::is_ascii_whitespace)
}

/// Reads it.
///
/// Positions, normals, colours and texture coordinates are found by the usual property names; all other
/// scalars of vertices and faces become attributes. Texture coordinates that stand at the corners of faces
/// split the vertices at which they differ, so there may be more vertices than in the file; the copies
/// stand behind the vertices of the file.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let bytes = input.bytes();
    let mut header = header::parse(input)?;
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
    let mut model = assemble::model(&job, &header, plans, tables)?;
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

/// One reading: what is read, and what it has cost and met so far.
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

    /// Asks for memory before it is taken.
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
