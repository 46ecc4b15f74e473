//! The numbers of all lines.

use crate::loops::prelude::*;

use super::front::{Column, Front, is_comment, number};
use crate::ReadError;
use crate::error::{Place, printable};
use crate::io::ReadOptions;
use crate::io::input::Input;
use crate::io::text::split_lines;

/// Bytes of text that a thread parses at a time.
const PIECE: usize = 4 << 20;

/// All points.
#[derive(Debug, Default)]
pub struct Table {
    pub points: Vec<[f64; 3]>,
    /// Of every column that is neither a coordinate nor left out.
    pub columns: Vec<Vec<f64>>,
}

/// Parses the lines behind the front.
pub fn all(input: &Input, options: &ReadOptions, text: &[u8], front: &Front) -> Result<Table, ReadError> {
    let body = text.get(front.begin..).unwrap_or_default();
    let values = front.columns.iter().filter(|c| is_value(c)).count();
    // A number and its delimiter have two bytes at least.
    let most = (body.len() / (2 * front.columns.len())) as u64 + 1;
    let bytes_of_a_point = (24 + 8 * values + 16) as u64;
    // What the pieces become is copied into one table while they are still there.
    let estimate = estimate(body).min(most);
    let needed = input.held_bytes().saturating_add(estimate.saturating_mul(2 * bytes_of_a_point));
    options.check_memory(&input.name, "its points", needed)?;
    let piece = input.stretch(PIECE);
    let pieces = split_lines(body, body.len() / piece + 1, |_| {});
    input.check_chunk_lengths(&pieces, options)?;
    let parse = |bytes: &&[u8]| {
        let table = some(bytes, front, values);
        input.consumed(bytes.len());
        if let Some(progress) = options.progress {
            progress.advance(bytes.len() as u64);
        }
        table
    };
    let tables: Vec<Result<Table, Wrong>> = pieces.par_iter().map(parse).collect();
    let mut whole = Table { points: Vec::new(), columns: vec![Vec::new(); values] };
    let mut before = 0;
    for (table, bytes) in tables.into_iter().zip(&pieces) {
        match table {
            Ok(table) => {
                whole.points.extend(table.points);
                whole.columns.iter_mut().zip(table.columns).for_each(|(to, from)| to.extend(from));
            }
            Err(wrong) => {
                let lines = |bytes: &[u8]| bytes.iter().filter(|&&b| b == b'\n').count() as u64;
                let start = body.get(..before).unwrap_or_default();
                let line = front.lines + lines(start) + wrong.line;
                return Err(ReadError::Malformed {
                    file: input.name.clone(),
                    place: Place::Line(line),
                    expected: wrong.expected,
                    found: wrong.found,
                });
            }
        }
        before += bytes.len();
    }
    Ok(whole)
}

fn is_value(column: &Column) -> bool {
    matches!(column, Column::Color(_) | Column::Value(_))
}

/// About how many lines there are, from the length of the first ones.
fn estimate(body: &[u8]) -> u64 {
    let front = body.get(..1 << 16).unwrap_or(body);
    let lines = front.iter().filter(|&&b| b == b'\n').count().max(1);
    (body.len() as u128 * lines as u128 / front.len().max(1) as u128) as u64 + 1
}

/// What is wrong in a piece.
struct Wrong {
    /// Counted from 1 in the piece.
    line: u64,
    expected: String,
    found: String,
}

fn some(bytes: &[u8], front: &Front, values: usize) -> Result<Table, Wrong> {
    let mut table = Table { points: Vec::new(), columns: vec![Vec::new(); values] };
    for (line_number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let line = line.trim_ascii();
        if line.is_empty() || is_comment(line) {
            continue;
        }
        let wrong = |expected: String, found: &[u8]| {
            let found = if found.is_empty() { "the end of the line".into() } else { printable(found) };
            Wrong { line: line_number as u64 + 1, expected, found }
        };
        let (mut point, mut rest, mut value) = ([0.0; 3], Some(line), 0);
        for (k, column) in front.columns.iter().enumerate() {
            let expected = || format!("number {} of {}", k + 1, front.columns.len());
            let Some(field) = front.delimiter.field(&mut rest) else { return Err(wrong(expected(), b"")) };
            match column {
                Column::LeftOut(_) => {}
                Column::Axis(axis) => match number(field) {
                    Some(number) => point[*axis] = number,
                    None => return Err(wrong(expected(), field)),
                },
                Column::Color(_) | Column::Value(_) => {
                    let Some(number) = number(field) else { return Err(wrong(expected(), field)) };
                    if let Some(to) = table.columns.get_mut(value) {
                        to.push(number);
                    }
                    value += 1;
                }
            }
        }
        // A delimiter at the end is no further column.
        if let Some(surplus) = rest.map(<[u8]>::trim_ascii).filter(|rest| !rest.is_empty()) {
            return Err(wrong(format!("{} numbers in the line", front.columns.len()), surplus));
        }
        table.points.push(point);
    }
    Ok(table)
}
