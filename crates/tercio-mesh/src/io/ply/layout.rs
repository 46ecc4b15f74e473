//! Where the instances of an element are in a binary file.

use crate::loops::prelude::*;

use super::binary::{Binary, number};
use super::header::{Element, Scalar, Shape};
use super::malformed;
use crate::error::{Place, ReadError};

/// Instances in one piece of work.
pub(super) const BLOCK: usize = 8192;

/// Bytes between two reports of consumed input.
pub(super) const REPORT_STEP: usize = 1 << 16;

/// Where the instances are.
#[derive(Debug)]
pub(super) enum Layout {
    /// All take the same number of bytes, because they hold no lists or lists of one length each.
    Uniform {
        stride: usize,
        /// Offset of each property in an instance; for a list, that of its length.
        offsets: Vec<usize>,
        /// Length of each property's list.
        lengths: Vec<usize>,
    },
    /// Offset in the file of every [`BLOCK`]th instance.
    Ragged { starts: Vec<usize> },
}

/// Finds the layout of `rows` instances from byte `at` on, and the offset after the last of them.
pub(super) fn find(
    binary: &Binary,
    element: &Element,
    rows: usize,
    at: usize,
) -> Result<(Layout, usize), ReadError> {
    if let Some((layout, stride)) = uniform(binary, element, rows, at) {
        let left = binary.bytes.len() - at;
        return match stride.checked_mul(rows) {
            Some(size) if size <= left => Ok((layout, at + size)),
            _ => {
                let expected = format!("{rows} instances of {stride} bytes of element {}", element.name);
                Err(malformed(binary.file, Place::Byte(at as u64), expected, format!("{left} bytes")))
            }
        };
    }
    scan(binary, element, rows, at)
}

/// The layout that follows from the first instance, if all others agree.
pub(super) fn uniform(binary: &Binary, element: &Element, rows: usize, at: usize) -> Option<(Layout, usize)> {
    let body = binary.bytes.get(at..)?;
    let mut stride = 0usize;
    let (mut offsets, mut lengths, mut lists) = (Vec::new(), Vec::new(), Vec::new());
    for property in &element.properties {
        offsets.push(stride);
        let mut length = 0;
        match property.shape {
            Shape::One(scalar) => stride = stride.checked_add(scalar.size())?,
            Shape::List { count, item } => {
                length = list_length(number(count, binary.big, body.get(stride..)?)?)?;
                lists.push((count, stride, length));
                let items = item.size().checked_mul(length)?;
                stride = stride.checked_add(count.size())?.checked_add(items)?;
            }
        }
        lengths.push(length);
    }
    if !lists.is_empty() {
        let body = body.get(..stride.checked_mul(rows)?)?;
        let agrees = |block: &[u8]| {
            let agrees = lists.iter().all(|&(count, offset, length)| {
                all_counts_are(count, binary.big, block, stride, offset, length as f64)
            });
            binary.input.consumed(block.len());
            agrees
        };
        let rows = binary.input.stretch(stride.checked_mul(BLOCK)?).checked_div(stride)?.max(1);
        if !body.par_chunks(stride * rows).all(agrees) {
            return None;
        }
    }
    Some((Layout::Uniform { stride, offsets, lengths }, stride))
}

fn all_counts_are(ty: Scalar, big: bool, rows: &[u8], stride: usize, offset: usize, expected: f64) -> bool {
    let mut rows = rows.chunks_exact(stride);
    if matches!(ty, Scalar::U8 | Scalar::I8) {
        let expected = expected as u8;
        return rows.all(|row| row.get(offset) == Some(&expected));
    }
    rows.all(|row| row.get(offset..).and_then(|b| number(ty, big, b)) == Some(expected))
}

/// A list's length, if it is a whole number.
#[inline]
pub(super) fn list_length(value: f64) -> Option<usize> {
    let length = value as u32;
    (f64::from(length) == value).then_some(length as usize)
}

/// Walks over the instances one by one. Only list lengths are read.
fn scan(binary: &Binary, element: &Element, rows: usize, at: usize) -> Result<(Layout, usize), ReadError> {
    enum Step {
        Skip(usize),
        List { count: Scalar, item: usize },
    }
    let mut steps: Vec<Step> = Vec::new();
    for property in &element.properties {
        match (property.shape, steps.last_mut()) {
            (Shape::One(scalar), Some(Step::Skip(bytes))) => *bytes += scalar.size(),
            (Shape::One(scalar), _) => steps.push(Step::Skip(scalar.size())),
            (Shape::List { count, item }, _) => steps.push(Step::List { count, item: item.size() }),
        }
    }
    let (mut at, mut reported) = (at, at);
    let mut starts = Vec::with_capacity(rows / BLOCK + 1);
    for row in 0..rows {
        if row % BLOCK == 0 {
            starts.push(at);
        }
        if at - reported >= REPORT_STEP {
            binary.input.consumed(at - reported);
            reported = at;
        }
        let cut = |at, what: String| {
            let expected = format!("{what} of element {} {row}", element.name);
            malformed(binary.file, Place::Byte(at as u64), expected, binary.left_from(at))
        };
        for step in &steps {
            match *step {
                Step::Skip(bytes) => {
                    if binary.bytes.len().saturating_sub(at) < bytes {
                        return Err(cut(at, format!("{bytes} bytes")));
                    }
                    at += bytes;
                }
                Step::List { count, item } => {
                    let value = binary.bytes.get(at..).and_then(|b| number(count, binary.big, b));
                    let Some(value) = value else { return Err(cut(at, "a list length".into())) };
                    let Some(length) = list_length(value) else {
                        let expected = format!("a list length of element {} {row}", element.name);
                        return Err(malformed(
                            binary.file,
                            Place::Byte(at as u64),
                            expected,
                            value.to_string(),
                        ));
                    };
                    at += count.size();
                    let size = length as u64 * item as u64;
                    if ((binary.bytes.len() - at) as u64) < size {
                        return Err(cut(at, format!("{size} bytes of a list of {length}")));
                    }
                    at += size as usize;
                }
            }
        }
    }
    Ok((Layout::Ragged { starts }, at))
}
