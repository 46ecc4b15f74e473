//! Values of an ASCII file.
//!
//! Nearly every file has one instance per line, which lets many threads parse in parallel: [`in_parallel`] counts
//! line ends to know which instances are where, and checks that every instance ends with its line. Other files are
//! read again from the front by one thread ([`in_sequence`]): first as the format is defined, where any white space
//! separates numbers; then, because some writers put more on a line than their header declares, line by line with the
//! surplus ignored.

use std::borrow::Cow;
use std::sync::atomic::Ordering::Relaxed;

use crate::loops::prelude::*;

use super::Job;
use super::header::{Element, Header};
use super::layout::REPORT_STEP;
use super::plan::{Plan, Role};
use super::row::{Row, Spacing, Trouble};
use super::table::{Lists, Slots, Table, put_row};
use crate::error::{Place, ReadError, counted};
use crate::io::text::{Cursor, is_space, split_lines};

/// Reads all elements.
pub(super) fn read(job: &Job, header: &Header, plans: &[Plan]) -> Result<Vec<Table>, ReadError> {
    let mut body = Cow::Borrowed(job.bytes.get(header.body..).unwrap_or_default());
    if header.carriage_returns {
        job.input.count_all();
        job.held.store(job.input.held_bytes(), Relaxed);
        job.reserve("the content", body.len() as u64)?;
        body.to_mut().iter_mut().filter(|b| **b == b'\r').for_each(|b| *b = b'\n');
    }
    // Vertex numbers take no more bytes in memory than as text in all but tiny files.
    let fields: u64 = plans.iter().map(Plan::field_bytes).sum();
    job.reserve("the mesh", fields.saturating_add(body.len() as u64))?;
    if let Some(progress) = job.options.progress {
        progress.begin("reading vertices and faces", body.len() as u64);
    }
    let text = Text { job, body: &body, first_line: header.body_line, elements: &header.elements, plans };
    let too_long = match in_parallel(&text) {
        Ok(read) => return Ok(read.finish(&text)),
        Err(Trouble::Wrong(error)) => return Err(error),
        Err(trouble) => matches!(trouble, Trouble::Surplus(_)),
    };
    let free = in_sequence(&text, Spacing::Free);
    if let Ok(read) = free {
        if !read.trailing {
            return Ok(read.finish(&text));
        }
        return match in_sequence(&text, Spacing::Lenient) {
            Ok(by_line) => Ok(by_line.finish(&text)),
            Err(_) => Ok(read.finish(&text)),
        };
    }
    match (free, in_sequence(&text, Spacing::Lenient)) {
        (_, Ok(read)) | (Ok(read), _) => Ok(read.finish(&text)),
        (Err(free), Err(by_line)) => {
            // Report the error of the reading that was the better guess: that by line if the first bad line was too
            // long, none was too short and there is a line for every instance; else that of the reading that got
            // farther.
            let lines = job.input.count(&body, |b| b == b'\n');
            let rows: u64 = plans.iter().map(|p| p.rows as u64).sum();
            let prefer_lines = too_long && matches!(by_line, Trouble::Wrong(_)) && lines >= rows;
            let (free, by_line) = (free.into_error(), by_line.into_error());
            Err(if prefer_lines || line_of(&by_line) > line_of(&free) { by_line } else { free })
        }
    }
}

fn line_of(error: &ReadError) -> u64 {
    match error {
        ReadError::Malformed { place: Place::Line(line), .. } => *line,
        _ => 0,
    }
}

/// The text after the header.
#[derive(Debug)]
struct Text<'a> {
    job: &'a Job<'a>,
    body: &'a [u8],
    first_line: u64,
    elements: &'a [Element],
    plans: &'a [Plan],
}

/// The result of one reading.
#[derive(Debug)]
struct Reading {
    tables: Vec<Table>,
    /// Something follows the last instance.
    trailing: bool,
    /// For each element, the number of lines that hold more than it declares.
    surplus: Vec<u64>,
}

impl Reading {
    fn finish(mut self, text: &Text) -> Vec<Table> {
        for (i, &lines) in self.surplus.iter().enumerate().filter(|&(_, &lines)| lines > 0) {
            let (Some(element), Some(plan)) = (text.elements.get(i), text.plans.get(i)) else { continue };
            let hold = if lines == 1 { "holds" } else { "hold" };
            let (lines, name) = (counted(lines, "line"), &element.name);
            let mut warning = format!("{lines} of element {name} {hold} more than the header declares");
            // After a list that is not declared, scalars are not where the header says.
            if plan.role == Role::Faces && !plan.fields.is_empty() {
                warning += "; colours and attributes of the faces are left out";
                if let Some(table) = self.tables.get_mut(i) {
                    table.columns.clear();
                }
            }
            text.job.warn(warning);
        }
        if self.trailing {
            text.job.warn("the text after the last element is ignored".into());
        }
        self.tables
    }
}

impl Text<'_> {
    fn tables(&self) -> Vec<Table> {
        let kept = |p: &Plan| if p.role == Role::Skipped { Table::default() } else { Table::new(p) };
        self.plans.iter().map(kept).collect()
    }

    fn parser(&self, element: usize, spacing: Spacing) -> Option<(Row<'_>, &Plan)> {
        let (plan, element) = (self.plans.get(element)?, self.elements.get(element)?);
        Some((Row::new(self.job.file, element, plan, spacing), plan))
    }
}

/// Instances of one element in one chunk of the text.
struct Segment<'a> {
    element: usize,
    first: usize,
    rows: usize,
    slots: Vec<Slots<'a>>,
}

/// Result of one chunk of the text: lists with the number of their element.
struct Stretch {
    lists: Vec<(usize, Lists)>,
    trailing: bool,
}

/// One instance per line, all threads.
fn in_parallel(text: &Text) -> Result<Reading, Trouble> {
    let step = (text.body.len() / (rayon::current_num_threads() * 8)).max(1);
    let pieces = text.body.len() / text.job.input.stretch(step);
    let chunks = split_lines(text.body, pieces, |bytes| text.job.input.consumed(bytes));
    text.job.input.check_chunk_lengths(&chunks, text.job.options).map_err(Trouble::Wrong)?;
    let lines = |chunk: &&[u8]| {
        text.job.input.consumed(chunk.len());
        chunk.iter().filter(|&&b| b == b'\n').count()
    };
    let lines: Vec<usize> = chunks.par_iter().map(lines).collect();

    let mut tables = text.tables();
    let mut slots: Vec<Vec<Slots>> = tables.iter_mut().map(Table::slots).collect();
    let (mut element, mut row) = (0, 0);
    let mut line = text.first_line;
    let mut work = Vec::with_capacity(chunks.len());
    for (i, (&chunk, &lines)) in chunks.iter().zip(&lines).enumerate() {
        // The last line may lack a line end.
        let mut left = if i + 1 == chunks.len() { usize::MAX } else { lines };
        let mut segments = Vec::new();
        while let (Some(plan), Some(slots)) = (text.plans.get(element), slots.get_mut(element)) {
            let rows = left.min(plan.rows - row);
            let slots = slots.iter_mut().map(|s| s.take_front(rows)).collect();
            segments.push(Segment { element, first: row, rows, slots });
            left -= rows;
            row += rows;
            if row < plan.rows {
                break;
            }
            (element, row) = (element + 1, 0);
        }
        work.push((chunk, line, segments));
        line += lines as u64;
    }
    let pieces: Vec<Result<Stretch, Trouble>> = work
        .into_par_iter()
        .map(|(chunk, line, segments)| {
            let mut cursor = Cursor::new(chunk, line);
            let mut lists = Vec::with_capacity(segments.len());
            for segment in segments {
                lists.push((segment.element, read_segment(text, segment, &mut cursor)?));
            }
            text.job.advance(chunk.len() as u64);
            text.job.input.consumed(chunk.len());
            cursor.skip_space();
            Ok(Stretch { lists, trailing: !cursor.is_at_end() })
        })
        .collect();
    drop(slots);
    let mut trailing = false;
    // The error of the first chunk is reported: later ones may only follow from it.
    for piece in pieces {
        let Stretch { lists, trailing: more } = piece?;
        trailing |= more;
        for (element, lists) in lists {
            if let Some(table) = tables.get_mut(element) {
                table.lists.push(lists);
            }
        }
    }
    Ok(Reading { surplus: Vec::new(), tables, trailing })
}

fn read_segment(text: &Text, mut segment: Segment, cursor: &mut Cursor) -> Result<Lists, Trouble> {
    let mut lists = Lists::default();
    let Some((parser, plan)) = text.parser(segment.element, Spacing::Strict) else { return Ok(lists) };
    let mut values = vec![0.0; parser.width()];
    for row in 0..segment.rows {
        parser.parse(cursor, segment.first + row, &mut values, &mut lists)?;
        put_row(plan, &mut segment.slots, row, &values);
        if !cursor.line_is_over() {
            return Err(parser.surplus(cursor, segment.first + row));
        }
        cursor.skip_line();
    }
    Ok(lists)
}

/// Any spacing, one thread.
fn in_sequence(text: &Text, spacing: Spacing) -> Result<Reading, Trouble> {
    let mut tables = text.tables();
    let mut surplus = vec![0; tables.len()];
    let mut cursor = Cursor::new(text.body, text.first_line);
    for (i, (table, surplus)) in tables.iter_mut().zip(&mut surplus).enumerate() {
        let Some((parser, plan)) = text.parser(i, spacing) else { continue };
        let mut lists = Lists::default();
        let mut slots = table.slots();
        let mut values = vec![0.0; parser.width()];
        let mut reported = cursor.offset();
        for row in 0..plan.rows {
            if cursor.offset() - reported >= REPORT_STEP {
                text.job.input.consumed(cursor.offset() - reported);
                reported = cursor.offset();
            }
            cursor.skip_space();
            parser.parse(&mut cursor, row, &mut values, &mut lists)?;
            put_row(plan, &mut slots, row, &values);
            if spacing == Spacing::Lenient {
                *surplus += u64::from(!cursor.line_is_over());
                cursor.skip_line();
            }
        }
        drop(slots);
        table.lists.push(lists);
    }
    let trailing = !text.job.input.all(cursor.rest(), is_space);
    Ok(Reading { tables, trailing, surplus })
}
