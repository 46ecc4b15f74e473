//! ASCII STL: `solid`, then facets of `vertex` statements, `endsolid`; any number of solids.
//!
//! Read as a stream of words, so that any white space is accepted. Unknown words are skipped between the statements,
//! but never where numbers are expected.

use crate::loops::prelude::*;

use crate::error::{Place, counted};
use crate::io::obj::transcode;
use crate::io::text::{Cursor, find};
use crate::io::{ReadModel, ReadOptions, ReadReport, input::Input};
use crate::mesh::localize_at;
use crate::strokes::Strokes;
use crate::{Mesh, ReadError};

use super::{check_facets, soup};

/// Parsed contents of one chunk of the file.
#[derive(Debug, Default)]
struct Part {
    points: Vec<[f64; 3]>,
    lines: u64,
    solids: u64,
    solid_ends: u64,
    skipped_words: u64,
    /// The error that ended the chunk, with a line number that counts from the front of the chunk.
    error: Option<ReadError>,
}

/// Reads ASCII STL.
///
/// # Errors
/// An invalid statement, too many facets, or too little memory.
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let mut odd = Vec::new();
    let text = transcode::text(input, options, &mut odd)?;
    let step = (text.len() / (8 * rayon::current_num_threads())).clamp(1 << 16, 1 << 22);
    let parts = split(&text, input.stretch(step), |bytes| input.consumed(bytes));
    input.check_chunk_lengths(&parts, options)?;
    let mut model = read_parts(input, options, &parts)?;
    model.report.warnings.splice(0..0, odd);
    Ok(model)
}

/// Splits before lines that begin with `facet`.
fn split(text: &[u8], step: usize, consumed: impl Fn(usize)) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = text;
    while rest.len() > step {
        let mut cut = step;
        loop {
            match rest.get(cut..).and_then(|tail| find(|b| b == b'\n', tail, &consumed)) {
                Some(n) => cut += n + 1,
                None => cut = rest.len(),
            }
            let tail = rest.get(cut..).unwrap_or_default();
            if tail.is_empty() || is_word(Cursor::new(tail, 0).word(), b"facet") {
                break;
            }
        }
        let (part, tail) = rest.split_at(cut);
        consumed(part.len());
        parts.push(part);
        rest = tail;
    }
    parts.push(rest);
    parts
}

#[inline]
fn is_word(word: &[u8], keyword: &[u8]) -> bool {
    word.eq_ignore_ascii_case(keyword)
}

fn read_parts(input: &Input, options: &ReadOptions, texts: &[&[u8]]) -> Result<ReadModel, ReadError> {
    let bytes: u64 = texts.iter().map(|t| t.len() as u64).sum();
    if let Some(p) = options.progress {
        p.begin("parsing", bytes);
    }
    // A facet takes at least 61 bytes of text, mostly 200 and more.
    let facets_at_most = bytes / 61;
    let expected = if options.memory_limit.is_some() { count_facets(input, texts) } else { 0 };
    options.check_memory(
        &input.name,
        "triangles",
        input.held_bytes() + expected.min(facets_at_most) * 3 * (24 + 24 + 12 + 4),
    )?;
    let mut parts: Vec<Part> = texts
        .par_iter()
        .map(|text| {
            let part = parse(&input.name, text);
            input.consumed(text.len());
            if let Some(p) = options.progress {
                p.advance(text.len() as u64);
            }
            part
        })
        .collect();
    let mut line = 0;
    for part in &mut parts {
        if let Some(error) = part.error.take() {
            return Err(shifted(error, line));
        }
        line += part.lines;
    }
    let facets: u64 = parts.iter().map(|p| p.points.len() as u64 / 3).sum();
    check_facets(input, facets)?;

    let sum = |of: fn(&Part) -> u64| parts.iter().map(of).sum::<u64>();
    let (solids, ends, skipped) = (sum(|p| p.solids), sum(|p| p.solid_ends), sum(|p| p.skipped_words));
    let mut warnings = Vec::new();
    if ends < solids {
        warnings.push("the end of the last solid is missing".into());
    }
    if skipped > 0 {
        warnings.push(format!("skipped {} between the statements", counted(skipped, "unknown word")));
    }
    let mut points = Vec::with_capacity(facets as usize * 3);
    for part in parts {
        points.extend(part.points);
    }
    let (coordinates, origin, positions) = localize_at(&points, options.origin);
    let mesh = Mesh { origin, positions, triangles: soup(facets as usize), ..Mesh::default() };
    let report = ReadReport {
        format: "STL, ASCII".into(),
        file_bytes: input.file_bytes,
        faces: facets,
        warnings,
        ..ReadReport::default()
    };
    Ok(ReadModel { mesh, strokes: Strokes::default(), coordinates, report })
}

/// Counts without parsing; worth its time only if memory is limited.
fn count_facets(input: &Input, texts: &[&[u8]]) -> u64 {
    let ends = |text: &&[u8]| {
        input.consumed(text.len());
        text.split(|b| b.is_ascii_whitespace()).filter(|w| is_word(w, b"endfacet")).count() as u64
    };
    texts.par_iter().map(ends).sum()
}

fn shifted(error: ReadError, lines: u64) -> ReadError {
    match error {
        ReadError::Malformed { file, place: Place::Line(n), expected, found } => {
            ReadError::Malformed { file, place: Place::Line(n + lines), expected, found }
        }
        other => other,
    }
}

fn parse(file: &str, bytes: &[u8]) -> Part {
    let mut part = Part::default();
    part.points.reserve(bytes.len() / 80);
    let mut cursor = Cursor::new(bytes, 1);
    part.error = statements(file, &mut cursor, &mut part).err();
    part.lines = cursor.line() - 1;
    part
}

fn statements(file: &str, cursor: &mut Cursor, part: &mut Part) -> Result<(), ReadError> {
    loop {
        cursor.skip_space();
        if cursor.is_at_end() {
            return Ok(());
        }
        let word = cursor.word();
        if is_word(word, b"facet") {
            facet(file, cursor, &mut part.points)?;
        } else if is_word(word, b"solid") {
            part.solids += 1;
            skip_name(cursor);
        } else if is_word(word, b"endsolid") {
            part.solid_ends += 1;
            skip_name(cursor);
        } else if is_word(word, b"vertex") || is_word(word, b"outer") {
            return Err(cursor.expected(file, "a facet round the vertices"));
        } else {
            part.skipped_words += 1;
        }
    }
}

/// Skips the name of a solid: the rest of the line, unless a statement follows on it.
fn skip_name(cursor: &mut Cursor) {
    loop {
        let before = cursor.clone();
        let word = cursor.word();
        let mut ahead = cursor.clone();
        if word.is_empty() {
            return;
        }
        if (is_word(word, b"facet") && is_word(ahead.word(), b"normal")) || is_word(word, b"endsolid") {
            *cursor = before;
            return;
        }
    }
}

/// Reads a facet after its keyword. The normal is skipped, whatever it is.
fn facet(file: &str, cursor: &mut Cursor, points: &mut Vec<[f64; 3]>) -> Result<(), ReadError> {
    loop {
        cursor.skip_space();
        let before = cursor.clone();
        let word = cursor.word();
        if is_word(word, b"outer") {
            break;
        }
        if word.is_empty()
            || ["vertex", "facet", "endfacet", "endloop"].iter().any(|k| is_word(word, k.as_bytes()))
        {
            return Err(before.expected(file, "\"outer loop\""));
        }
    }
    cursor.skip_space();
    expect(file, cursor, "loop")?;
    for _ in 0..3 {
        cursor.skip_space();
        expect(file, cursor, "vertex")?;
        let mut point = [0.0; 3];
        for x in &mut point {
            cursor.skip_space();
            match cursor.float() {
                Some(value) => *x = value,
                None => return Err(cursor.expected(file, "three coordinates of a vertex")),
            }
        }
        points.push(point);
    }
    cursor.skip_space();
    expect(file, cursor, "endloop")?;
    // Other words may precede the end of the facet, but no further vertices.
    loop {
        cursor.skip_space();
        let before = cursor.clone();
        let word = cursor.word();
        if is_word(word, b"endfacet") {
            return Ok(());
        }
        if word.is_empty()
            || ["vertex", "facet", "outer", "endsolid"].iter().any(|k| is_word(word, k.as_bytes()))
        {
            return Err(before.expected(file, "\"endfacet\""));
        }
    }
}

#[inline]
fn expect(file: &str, cursor: &mut Cursor, keyword: &'static str) -> Result<(), ReadError> {
    let before = cursor.clone();
    if is_word(cursor.word(), keyword.as_bytes()) {
        return Ok(());
    }
    Err(before.expected(file, format!("\"{keyword}\"")))
}

#[cfg(test)]
pub mod for_tests {
    //! Reads with a chosen chunk size.
    use super::*;

    pub fn read_in_steps(input: &Input, step: usize) -> Result<ReadModel, ReadError> {
        read_parts(input, &ReadOptions::default(), &split(input.bytes(), step, |_| ()))
    }
}
