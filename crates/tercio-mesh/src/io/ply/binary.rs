//! Values of a binary file, decoded by many threads.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::loops::prelude::*;

use super::direct;
use super::header::{Element, Header, Scalar, Shape};
use super::layout::{self, BLOCK, Layout, REPORT_STEP, list_length};
use super::plan::{Field, Plan, Role};
use super::table::{Lists, Slots, Table, put_row};
use super::{Job, malformed};
use crate::error::{Place, ReadError, counted};
use crate::io::input::Input;

/// Most items of a list that are read between two reports of consumed bytes.
const LONG: usize = 1 << 14;

/// Instances decoded at once: their columns stay in the first-level cache.
const STEP: usize = 512;

/// A binary file.
#[derive(Debug)]
pub(super) struct Binary<'a> {
    pub(super) input: &'a Input,
    pub(super) file: &'a str,
    pub(super) bytes: &'a [u8],
    pub(super) big: bool,
}

impl Binary<'_> {
    /// Describes the rest of the file, where more was expected.
    pub(super) fn left_from(&self, at: usize) -> String {
        match self.bytes.len().saturating_sub(at) {
            0 => "the end of the file".into(),
            n => format!("{n} bytes up to the end of the file"),
        }
    }
}

/// The number at the front of `bytes`; `None` if there are too few bytes.
#[inline]
pub(super) fn number(ty: Scalar, big: bool, bytes: &[u8]) -> Option<f64> {
    macro_rules! as_type {
        ($t:ty) => {{
            let bytes = *bytes.first_chunk()?;
            if big { <$t>::from_be_bytes(bytes) } else { <$t>::from_le_bytes(bytes) }.into()
        }};
    }
    Some(match ty {
        Scalar::I8 => as_type!(i8),
        Scalar::U8 => as_type!(u8),
        Scalar::I16 => as_type!(i16),
        Scalar::U16 => as_type!(u16),
        Scalar::I32 => as_type!(i32),
        Scalar::U32 => as_type!(u32),
        Scalar::F32 => as_type!(f32),
        Scalar::F64 => as_type!(f64),
    })
}

/// The number at `offset` of every `stride` bytes.
fn decode_column(ty: Scalar, big: bool, rows: &[u8], stride: usize, offset: usize, out: &mut [f64]) {
    macro_rules! as_type {
        ($t:ty) => {{
            let rows = rows.chunks_exact(stride).zip(out);
            let bytes = |row: &[u8]| row.get(offset..).and_then(|b| b.first_chunk().copied());
            if big {
                rows.for_each(|(row, v)| {
                    *v = bytes(row).map_or(0.0, |b| <$t>::from_be_bytes(b).into());
                });
            } else {
                rows.for_each(|(row, v)| {
                    *v = bytes(row).map_or(0.0, |b| <$t>::from_le_bytes(b).into());
                });
            }
        }};
    }
    match ty {
        Scalar::I8 => as_type!(i8),
        Scalar::U8 => as_type!(u8),
        Scalar::I16 => as_type!(i16),
        Scalar::U16 => as_type!(u16),
        Scalar::I32 => as_type!(i32),
        Scalar::U32 => as_type!(u32),
        Scalar::F32 => as_type!(f32),
        Scalar::F64 => as_type!(f64),
    }
}

/// Reads all elements.
pub(super) fn read(job: &Job, header: &Header, plans: &[Plan], big: bool) -> Result<Vec<Table>, ReadError> {
    let binary = Binary { input: job.input, file: job.file, bytes: job.bytes, big };
    let mut at = header.body;
    let mut tables = Vec::with_capacity(plans.len());
    for (element, plan) in header.elements.iter().zip(plans) {
        let (layout, end) = layout::find(&binary, element, plan.rows, at)?;
        let mut table = Table::default();
        if plan.role != Role::Skipped {
            job.begin(plan.role, plan.rows as u64);
            let lists = match plan.corners.and_then(|i| element.properties.get(i)).map(|p| p.shape) {
                Some(Shape::List { item, .. }) => ((end - at) / item.size()) as u64 * 4,
                _ => 0,
            };
            job.reserve("the mesh", plan.field_bytes().saturating_add(lists))?;
            table = Table::new(plan);
            match &layout {
                Layout::Uniform { stride, offsets, lengths } => {
                    let uniform = Uniform { binary: &binary, element, plan, at, stride: *stride, offsets };
                    let triangles = plan.role == Role::Faces
                        && plan.wedges.is_none()
                        && plan.corners.is_some_and(|i| lengths.get(i) == Some(&3));
                    if plan.corners.is_none() || triangles {
                        uniform.read(job, &mut table)?;
                    } else {
                        let starts: Vec<usize> =
                            (0..plan.rows).step_by(BLOCK).map(|row| at + row * stride).collect();
                        read_ragged(job, &binary, element, plan, &starts, &mut table)?;
                    }
                }
                Layout::Ragged { starts } => {
                    read_ragged(job, &binary, element, plan, starts, &mut table)?;
                }
            }
        }
        tables.push(table);
        at = end;
    }
    if at < job.bytes.len() {
        let left = counted((job.bytes.len() - at) as u64, "byte");
        job.warn(format!("ignored {left} after the last element"));
    }
    Ok(tables)
}

/// An element whose instances all take the same number of bytes: columns are read with a stride.
struct Uniform<'a> {
    binary: &'a Binary<'a>,
    element: &'a Element,
    plan: &'a Plan,
    at: usize,
    stride: usize,
    offsets: &'a [usize],
}

impl Uniform<'_> {
    fn read(&self, job: &Job, table: &mut Table) -> Result<(), ReadError> {
        let rows = self.plan.rows;
        let mut triangles = self.plan.corners.map(|_| vec![[0u32; 3]; rows]);
        let mut rest = triangles.as_deref_mut().map(|t| t.chunks_mut(BLOCK));
        let mut slots = table.slots();
        let blocks: Vec<_> = (0..rows)
            .step_by(BLOCK)
            .map(|first| {
                let slots: Vec<Slots> = slots.iter_mut().map(|s| s.take_front(BLOCK)).collect();
                let triangles = rest.as_mut().and_then(Iterator::next).unwrap_or_default();
                (first, slots, triangles)
            })
            .collect();
        let good = AtomicBool::new(true);
        blocks.into_par_iter().for_each(|(first, mut slots, triangles)| {
            let here = BLOCK.min(rows - first);
            let from = self.at + first * self.stride;
            let bytes = self.binary.bytes.get(from..from + here * self.stride).unwrap_or_default();
            let mut columns = [[0.0; STEP]; 4];
            let step = (job.input.stretch(STEP * self.stride) / self.stride).max(1);
            for first in (0..here).step_by(step) {
                let bytes = bytes.get(first * self.stride..).unwrap_or_default();
                let rows = step.min(here - first);
                self.fields(&mut slots, first, rows, bytes, &mut columns);
                if let Some(triangles) = triangles.get_mut(first..first + rows) {
                    let bytes = bytes.get(..rows * self.stride).unwrap_or_default();
                    if !self.triangles(triangles, bytes, &mut columns) {
                        good.store(false, Relaxed);
                    }
                }
                job.input.consumed(rows * self.stride);
            }
            job.input.finished(bytes);
            job.advance(here as u64);
        });
        drop(slots);
        if !good.load(Relaxed) {
            return Err(self.first_bad_vertex());
        }
        table.triangles = triangles;
        Ok(())
    }

    fn fields(
        &self,
        slots: &mut [Slots],
        first: usize,
        rows: usize,
        bytes: &[u8],
        columns: &mut [[f64; STEP]; 4],
    ) {
        for (field, slots) in self.plan.fields.iter().zip(slots) {
            if let (Slots::Points32(points), Some(offset)) = (&mut *slots, self.offset_of_floats(field)) {
                let points = points.get_mut(first..first + rows).unwrap_or_default();
                direct::points(bytes, self.stride, offset, self.binary.big, points);
                continue;
            }
            let blank = field.blank();
            for (k, column) in columns.iter_mut().enumerate() {
                match field.properties.get(k) {
                    Some(&property) => self.column(property, 0, bytes, &mut column[..rows]),
                    None => column[..rows].fill(blank[k]),
                }
            }
            let [a, b, c, d] = &*columns;
            slots.fill(first, rows, field.scale, |i| [a[i], b[i], c[i], d[i]]);
        }
    }

    /// Offset of the three properties of a field if they are contiguous `f32`.
    fn offset_of_floats(&self, field: &Field) -> Option<usize> {
        let [x, y, z] = *field.properties.as_slice() else { return None };
        let float =
            |i: usize| matches!(self.element.properties.get(i)?.shape, Shape::One(Scalar::F32)).then_some(());
        [x, y, z].into_iter().try_for_each(float)?;
        let offset = |i: usize| self.offsets.get(i).copied();
        let first = offset(x)?;
        (offset(y)? == first + 4 && offset(z)? == first + 8).then_some(first)
    }

    /// Decodes one property, or item `item` of its lists.
    fn column(&self, property: usize, item: usize, bytes: &[u8], out: &mut [f64]) {
        let (Some(&offset), Some(p)) = (self.offsets.get(property), self.element.properties.get(property))
        else {
            return;
        };
        let (ty, offset) = match p.shape {
            Shape::One(ty) => (ty, offset),
            Shape::List { count, item: ty } => (ty, offset + count.size() + item * ty.size()),
        };
        decode_column(ty, self.binary.big, bytes, self.stride, offset, out);
    }

    /// Reads a list of three vertex numbers from each row; false if one is out of range.
    fn triangles(&self, triangles: &mut [[u32; 3]], bytes: &[u8], columns: &mut [[f64; STEP]; 4]) -> bool {
        let Some(property) = self.plan.corners else { return true };
        if let (Some(&offset), Some(Shape::List { count, item: item @ (Scalar::I32 | Scalar::U32) })) =
            (self.offsets.get(property), self.element.properties.get(property).map(|p| p.shape))
        {
            // As an unsigned number, a negative one is large.
            let most = if item == Scalar::I32 { 1 << 31 } else { u32::MAX };
            let (offset, vertices) = (offset + count.size(), self.plan.vertices.min(most));
            return direct::triangles(bytes, self.stride, offset, self.binary.big, vertices, triangles);
        }
        let [a, b, c, _] = columns;
        for (k, column) in [&mut *a, &mut *b, &mut *c].into_iter().enumerate() {
            self.column(property, k, bytes, &mut column[..triangles.len()]);
        }
        let mut good = true;
        for (((triangle, &a), &b), &c) in triangles.iter_mut().zip(&*a).zip(&*b).zip(&*c) {
            *triangle = [a as u32, b as u32, c as u32];
            // The cast saturates: a negative, fractional or too large number does not compare equal after the
            // conversion back.
            for (number, value) in triangle.iter().zip([a, b, c]) {
                good &= f64::from(*number) == value && *number < self.plan.vertices;
            }
        }
        good
    }

    /// Finds the vertex number that [`Self::triangles`] rejected.
    #[cold]
    fn first_bad_vertex(&self) -> ReadError {
        let mut lists = Lists::default();
        let mut values = vec![0.0; self.element.properties.len()];
        let mut at = self.at;
        for row in 0..self.plan.rows {
            let walked =
                walk_row(self.binary, self.element, self.plan, row, &mut at, &mut values, &mut lists);
            if let Err(error) = walked {
                return error;
            }
            lists = Lists::default();
            self.binary.input.consumed(self.stride);
        }
        malformed(self.binary.file, Place::File, self.plan.expected_vertex(), "something else")
    }
}

/// Reads an element by walking through its instances, in parallel over blocks.
fn read_ragged(
    job: &Job,
    binary: &Binary,
    element: &Element,
    plan: &Plan,
    starts: &[usize],
    table: &mut Table,
) -> Result<(), ReadError> {
    let mut slots = table.slots();
    let blocks: Vec<(usize, usize, Vec<Slots>)> = (0..plan.rows)
        .step_by(BLOCK)
        .zip(starts)
        .map(|(first, &at)| (first, at, slots.iter_mut().map(|s| s.take_front(BLOCK)).collect()))
        .collect();
    // The error of the first block is reported, so that the same file always gives the same message.
    let lists: Vec<Result<Lists, ReadError>> = blocks
        .into_par_iter()
        .map(|(first, at, mut slots)| {
            let here = BLOCK.min(plan.rows - first);
            let mut lists = Lists::default();
            if plan.corners.is_some() {
                lists.counts.reserve(here);
                lists.corners.reserve(4 * here);
            }
            let mut values = vec![0.0; element.properties.len()];
            let (first_byte, mut at, mut reported) = (at, at, at);
            for row in 0..here {
                walk_row(binary, element, plan, first + row, &mut at, &mut values, &mut lists)?;
                put_row(plan, &mut slots, row, &values);
                if at - reported >= REPORT_STEP {
                    job.input.consumed(at - reported);
                    reported = at;
                }
            }
            job.input.consumed(at - reported);
            job.input.finished(binary.bytes.get(first_byte..at).unwrap_or_default());
            job.advance(here as u64);
            Ok(lists)
        })
        .collect();
    drop(slots);
    table.lists = lists.into_iter().collect::<Result<_, _>>()?;
    Ok(())
}

/// Decodes one instance and moves past it.
#[inline]
fn walk_row(
    binary: &Binary,
    element: &Element,
    plan: &Plan,
    row: usize,
    at: &mut usize,
    values: &mut [f64],
    lists: &mut Lists,
) -> Result<(), ReadError> {
    let take = |at: &mut usize, ty: Scalar| {
        let value = binary.bytes.get(*at..).and_then(|b| number(ty, binary.big, b));
        let value = value.ok_or_else(|| {
            let expected = format!("{} bytes of element {} {row}", ty.size(), element.name);
            malformed(binary.file, Place::Byte(*at as u64), expected, binary.left_from(*at))
        });
        *at += ty.size();
        value
    };
    for (i, (property, slot)) in element.properties.iter().zip(values).enumerate() {
        let (count, item) = match property.shape {
            Shape::One(ty) => {
                *slot = take(at, ty)?;
                continue;
            }
            Shape::List { count, item } => (count, item),
        };
        let place = Place::Byte(*at as u64);
        let value = take(at, count)?;
        let length = list_length(value).ok_or_else(|| {
            let expected = format!("a list length of element {} {row}", element.name);
            malformed(binary.file, place, expected, value.to_string())
        })?;
        if plan.corners == Some(i) {
            lists.counts.push(length as u32);
            let end = at.saturating_add(length.saturating_mul(item.size()));
            // One bounds check for the whole list; a truncated list is read number by number.
            if let Some(items) = binary.bytes.get(*at..end) {
                let before = lists.corners.len();
                // Nearly every list is a single part.
                for items in items.chunks(item.size() * LONG) {
                    let vertices =
                        items.chunks_exact(item.size()).map(|b| plan.vertex(number(item, binary.big, b)?));
                    let here = lists.corners.len();
                    lists.corners.extend(vertices.map_while(|v| v));
                    if lists.corners.len() - here < items.len() / item.size() {
                        break;
                    }
                    if length > LONG {
                        binary.input.consumed(items.len());
                    }
                }
                if lists.corners.len() - before == length {
                    *at = end;
                    continue;
                }
            }
            for _ in 0..length {
                let place = Place::Byte(*at as u64);
                let value = take(at, item)?;
                if plan.vertex(value).is_none() {
                    return Err(malformed(binary.file, place, plan.expected_vertex(), value.to_string()));
                }
            }
        } else if plan.wedges == Some(i) {
            lists.wedge_counts.push(length as u32);
            for i in 1..=length {
                lists.wedges.push(take(at, item)? as f32);
                if i % LONG == 0 {
                    binary.input.consumed(LONG * item.size());
                }
            }
        } else {
            *at = at.saturating_add(length.saturating_mul(item.size()));
        }
    }
    Ok(())
}
