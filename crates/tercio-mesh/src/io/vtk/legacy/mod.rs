//! Legacy files of VTK (`.vtk`), ASCII and binary, versions 1.0 to 5.1.
//!
//! A file is its title, then keywords with arrays. Binary arrays are big-endian and begin after the line of their
//! keyword. Up to version 4.2 a list of cells is the number of points of each cell and these; from version 5.0 on it
//! is two arrays, OFFSETS and CONNECTIVITY. Programs mix both, so that the words decide, not the version.
//!
//! Source: VTK File Formats (VTK User's Guide); `vtkDataReader` and `vtkDataWriter` of VTK 9.

mod arrays;
mod data;
mod geometry;

use std::borrow::Cow;

use super::dataset::{DataSet, Job};
use super::join;
use super::part::{self, Part};
use crate::ReadError;
use crate::error::Place;
use crate::io::obj::transcode;
use crate::io::text::Cursor;
use crate::io::{ReadModel, ReadOptions, input::Input};
use data::Data;
use geometry::Geometry;

/// Longest header of three lines that is looked for.
const FRONT: usize = 4096;

/// How the first line begins.
pub const SIGNATURE: &[u8] = b"# vtk DataFile Version";

/// Bytes between two reports of progress.
const STEP: usize = 1 << 16;

/// A file that is read.
struct Parser<'j, 'a> {
    job: &'j Job<'a>,
    cursor: Cursor<'a>,
    binary: bool,
    reported: usize,
}

/// Reads a legacy file.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let job = Job::new(input, options);
    let (part, format) = part_and_format(&job)?;
    let mut model = join::join(job.file(), vec![part], options.origin)?;
    model.report.format = format;
    model.report.warnings = job.into_warnings();
    Ok(model)
}

/// What a legacy file draws.
///
/// # Errors
/// Any [`ReadError`].
pub fn part(job: &Job) -> Result<Option<Part>, ReadError> {
    part_and_format(job).map(|(part, _)| Some(part))
}

fn part_and_format(job: &Job) -> Result<(Part, String), ReadError> {
    let text = text(job)?;
    let (data, format) = parse(job, &text)?;
    Ok((part::make(job, data)?, format))
}

/// The file, as text where it is not binary.
fn text<'a>(job: &Job<'a>) -> Result<Cow<'a, [u8]>, ReadError> {
    let (input, mut warnings) = (job.input, Vec::new());
    if is_binary(input.bytes()) {
        return Ok(Cow::Borrowed(input.bytes()));
    }
    let text = transcode::text(input, job.options, &mut warnings)?;
    warnings.into_iter().for_each(|warning| job.warn(warning));
    Ok(text)
}

/// The time that the field data of a file have, which are before its data of points and cells: as a rule before its points, too.
///
/// # Errors
/// Any [`ReadError`].
pub fn time(job: &Job) -> Result<Option<f64>, ReadError> {
    let text = text(job)?;
    let (mut parser, _) = begin(job, &text)?;
    let (mut geometry, mut data) = (Geometry::default(), Data::default());
    while let Some(word) = parser.keyword() {
        match word.as_str() {
            "POINT_DATA" | "CELL_DATA" => break,
            "FIELD" | "METADATA" => drop(data.read(&mut parser, &word)?),
            "DATASET" => drop(geometry.read(&mut parser, &word)?),
            // Numbers of text are not read for that.
            _ if !parser.binary => {
                if !parser.skip_to_field() {
                    break;
                }
            }
            // Those of binary files are passed over.
            _ => {
                if !geometry.read(&mut parser, &word)? {
                    break;
                }
            }
        }
        if data.time.is_some() {
            break;
        }
    }
    Ok(data.time)
}

/// Is the third line of the header the word BINARY?
fn is_binary(bytes: &[u8]) -> bool {
    let front = transcode::front(bytes, FRONT);
    let mut lines = front.trim_ascii_start().split(|&b| b == b'\n').skip(2);
    lines.next().is_some_and(|line| line.trim_ascii().eq_ignore_ascii_case(b"BINARY"))
}

/// Reads the header: returns what reads the rest, and the version.
fn begin<'j, 'a>(job: &'j Job<'a>, text: &'a [u8]) -> Result<(Parser<'j, 'a>, String), ReadError> {
    let mut parser = Parser { job, cursor: Cursor::new(text, 1), binary: false, reported: 0 };
    parser.cursor.skip_space();
    let first = parser.cursor.rest_of_line();
    let version = first.strip_prefix(SIGNATURE).map(<[u8]>::trim_ascii).unwrap_or_default();
    let version = String::from_utf8_lossy(&version[..version.len().min(8)]).into_owned();
    parser.cursor.skip_line();
    parser.cursor.skip_space();
    let before = parser.cursor.clone();
    let encoding = parser.cursor.rest_of_line().to_ascii_uppercase();
    parser.binary = match &encoding[..] {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => return Err(before.expected(job.file(), "ASCII or BINARY in the third line")),
    };
    Ok((parser, version))
}

fn parse<'a>(job: &Job<'a>, text: &'a [u8]) -> Result<(DataSet<'a>, String), ReadError> {
    job.begin("parsing", text.len() as u64);
    let (mut parser, version) = begin(job, text)?;
    let (mut geometry, mut data) = (Geometry::default(), Data::default());
    while let Some(word) = parser.keyword() {
        let known = data.read(&mut parser, &word)? || geometry.read(&mut parser, &word)?;
        if !known {
            parser.cursor = parser.keyword_start(&word);
            return Err(parser.expected("a keyword of VTK (POINTS, POLYGONS, CELLS, POINT_DATA, SCALARS, …)"));
        }
    }
    let kind = geometry.kind();
    let (points, cells) = geometry.finish(&parser)?;
    let [point_data, cell_data] = data.finish();
    let encoding = if parser.binary { "binary" } else { "ASCII" };
    let format = format!("VTK legacy {version}, {encoding}, {kind}");
    Ok((DataSet { points, cells, beside: Vec::new(), point_data, cell_data }, format))
}

impl<'a> Parser<'_, 'a> {
    /// The next word, in capitals; `None` at the end.
    fn keyword(&mut self) -> Option<String> {
        self.report();
        self.cursor.skip_space();
        let word = self.cursor.word();
        (!word.is_empty()).then(|| String::from_utf8_lossy(word).to_ascii_uppercase())
    }

    /// Goes to the next line of text that begins a field; false if there is none before the data of points and cells.
    fn skip_to_field(&mut self) -> bool {
        while !self.cursor.rest().is_empty() {
            self.cursor.skip_line();
            let mut ahead = self.cursor.clone();
            let word = ahead.word();
            if word.eq_ignore_ascii_case(b"FIELD") {
                return true;
            }
            if word.eq_ignore_ascii_case(b"POINT_DATA") || word.eq_ignore_ascii_case(b"CELL_DATA") {
                return false;
            }
        }
        false
    }

    /// A cursor before a word that was just read.
    fn keyword_start(&self, word: &str) -> Cursor<'a> {
        let mut cursor = self.cursor.clone();
        cursor.step_back(word.len());
        cursor
    }

    fn report(&mut self) {
        let read = self.cursor.offset() - self.reported;
        if read >= STEP {
            self.reported = self.cursor.offset();
            self.job.advance(read as u64);
            if !self.binary {
                self.job.input.consumed(read);
            }
        }
    }

    fn place(&self) -> Place {
        if self.binary { Place::Byte(self.cursor.offset() as u64) } else { Place::Line(self.cursor.line()) }
    }

    #[cold]
    fn expected(&self, expected: impl Into<String>) -> ReadError {
        match self.cursor.expected(self.job.file(), expected) {
            ReadError::Malformed { file, expected, found, .. } => {
                ReadError::Malformed { file, place: self.place(), expected, found }
            }
            error => error,
        }
    }

    /// A word on this line.
    fn word(&mut self, what: &str) -> Result<&'a [u8], ReadError> {
        let word = self.cursor.clone().word();
        if word.is_empty() {
            return Err(self.expected(what));
        }
        self.cursor.word();
        Ok(word)
    }

    /// A count on this line or a later one.
    fn count(&mut self, what: &str) -> Result<u64, ReadError> {
        self.cursor.skip_space();
        let before = self.cursor.clone();
        let count = self.cursor.integer().and_then(|n| u64::try_from(n).ok());
        count.ok_or_else(|| {
            self.cursor = before;
            self.expected(what)
        })
    }

    /// A number on this line or a later one.
    fn float(&mut self, what: &str) -> Result<f64, ReadError> {
        self.cursor.skip_space();
        self.cursor.float().ok_or_else(|| self.expected(what))
    }

    /// Is this the next word? Then it is read.
    fn has_word(&mut self, expected: &str) -> bool {
        let mut ahead = self.cursor.clone();
        ahead.skip_space();
        let has = ahead.word().eq_ignore_ascii_case(expected.as_bytes());
        if has {
            self.cursor = ahead;
        }
        has
    }
}
