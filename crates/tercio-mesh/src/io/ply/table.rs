//! Where the kept values of an element are stored: arrays in the mesh's own types, filled in pieces by many threads.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::plan::{Kind, Plan};
use crate::OctNormal;

/// The values of one field.
#[derive(Debug)]
pub(super) enum Column {
    Points32(Vec<[f32; 3]>),
    Points64(Vec<[f64; 3]>),
    Normals(Vec<OctNormal>),
    /// And the number of those that are not finite in the file.
    Colors(Vec<[u8; 4]>, AtomicU64),
    Texcoords(Vec<[f32; 2]>),
    Attribute(Vec<f32>),
    Attribute64(Vec<f64>),
}

/// A part of a [`Column`] to be filled.
#[derive(Debug)]
pub(super) enum Slots<'a> {
    Points32(&'a mut [[f32; 3]]),
    Points64(&'a mut [[f64; 3]]),
    Normals(&'a mut [OctNormal]),
    Colors(&'a mut [[u8; 4]], &'a AtomicU64),
    Texcoords(&'a mut [[f32; 2]]),
    Attribute(&'a mut [f32]),
    Attribute64(&'a mut [f64]),
}

impl Column {
    fn new(kind: Kind, rows: usize) -> Self {
        match kind {
            Kind::Points32 => Self::Points32(vec![[0.0; 3]; rows]),
            Kind::Points64 => Self::Points64(vec![[0.0; 3]; rows]),
            Kind::Normals => Self::Normals(vec![OctNormal::NONE; rows]),
            Kind::Colors => Self::Colors(vec![[0; 4]; rows], AtomicU64::new(0)),
            Kind::Texcoords => Self::Texcoords(vec![[0.0; 2]; rows]),
            Kind::Attribute => Self::Attribute(vec![0.0; rows]),
            Kind::Attribute64 => Self::Attribute64(vec![0.0; rows]),
        }
    }

    fn slots(&mut self) -> Slots<'_> {
        match self {
            Self::Points32(v) => Slots::Points32(v),
            Self::Points64(v) => Slots::Points64(v),
            Self::Normals(v) => Slots::Normals(v),
            Self::Colors(v, broken) => Slots::Colors(v, broken),
            Self::Texcoords(v) => Slots::Texcoords(v),
            Self::Attribute(v) => Slots::Attribute(v),
            Self::Attribute64(v) => Slots::Attribute64(v),
        }
    }
}

/// Splits the first `rows` off a slice.
fn front<'a, T>(slice: &mut &'a mut [T], rows: usize) -> &'a mut [T] {
    let whole = std::mem::take(slice);
    let (head, tail) = whole.split_at_mut(rows.min(whole.len()));
    *slice = tail;
    head
}

impl<'a> Slots<'a> {
    /// Splits off the first `rows`.
    pub(super) fn take_front(&mut self, rows: usize) -> Slots<'a> {
        match self {
            Self::Points32(s) => Slots::Points32(front(s, rows)),
            Self::Points64(s) => Slots::Points64(front(s, rows)),
            Self::Normals(s) => Slots::Normals(front(s, rows)),
            Self::Colors(s, broken) => Slots::Colors(front(s, rows), broken),
            Self::Texcoords(s) => Slots::Texcoords(front(s, rows)),
            Self::Attribute(s) => Slots::Attribute(front(s, rows)),
            Self::Attribute64(s) => Slots::Attribute64(front(s, rows)),
        }
    }

    /// Fills rows from `first` on with the results of `values`.
    #[inline]
    pub(super) fn fill(&mut self, first: usize, rows: usize, scale: f64, values: impl Fn(usize) -> [f64; 4]) {
        fn each<T>(slots: &mut [T], first: usize, rows: usize, value: impl Fn(usize) -> T) {
            let slots = slots.iter_mut().skip(first).take(rows);
            slots.enumerate().for_each(|(i, slot)| *slot = value(i));
        }
        match self {
            Self::Points32(s) => each(s, first, rows, |i| narrow(values(i))),
            Self::Points64(s) => each(s, first, rows, |i| {
                let [x, y, z, _] = values(i);
                [x, y, z]
            }),
            Self::Normals(s) => each(s, first, rows, |i| {
                let [x, y, z, _] = values(i);
                OctNormal::from_vector([x, y, z])
            }),
            // The cast saturates. Only floats are scaled up, and only they can be non-finite.
            Self::Colors(s, broken) if scale > 1.0 => each(s, first, rows, |i| {
                let color = values(i);
                match color.iter().all(|v| v.is_finite()) {
                    true => color.map(|v| (v * scale + 0.5) as u8),
                    false => {
                        broken.fetch_add(1, Relaxed);
                        replaced(color, scale)
                    }
                }
            }),
            Self::Colors(s, _) => each(s, first, rows, |i| values(i).map(|v| (v * scale + 0.5) as u8)),
            Self::Texcoords(s) => each(s, first, rows, |i| {
                let [u, v, ..] = values(i);
                [u as f32, v as f32]
            }),
            Self::Attribute(s) => each(s, first, rows, |i| values(i)[0] as f32),
            Self::Attribute64(s) => each(s, first, rows, |i| values(i)[0]),
        }
    }
}

/// A colour with a non-finite channel becomes white but keeps its alpha; a non-finite alpha becomes opaque.
#[cold]
fn replaced([r, g, b, a]: [f64; 4], scale: f64) -> [u8; 4] {
    let byte = |v: f64| (v * scale + 0.5) as u8;
    let color = if [r, g, b].iter().all(|v| v.is_finite()) { [r, g, b].map(byte) } else { [255; 3] };
    let alpha = if a.is_finite() { byte(a) } else { 255 };
    [color[0], color[1], color[2], alpha]
}

#[inline]
fn narrow([x, y, z, _]: [f64; 4]) -> [f32; 3] {
    [x as f32, y as f32, z as f32]
}

/// Lists of some rows, one after the other.
#[derive(Debug, Default)]
pub(super) struct Lists {
    /// Corners of each row.
    pub(super) counts: Vec<u32>,
    pub(super) corners: Vec<u32>,
    /// Number of texture-coordinate values of each row.
    pub(super) wedge_counts: Vec<u32>,
    pub(super) wedges: Vec<f32>,
}

/// The kept values of one element.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) columns: Vec<Column>,
    /// If every face is a triangle and that was known in advance; `lists` is empty then.
    pub(super) triangles: Option<Vec<[u32; 3]>>,
    /// Lists in pieces, in the order of the rows.
    pub(super) lists: Vec<Lists>,
}

impl Table {
    /// Takes the memory for the scalar fields.
    pub(super) fn new(plan: &Plan) -> Self {
        let columns = plan.fields.iter().map(|f| Column::new(f.kind, plan.rows)).collect();
        Self { columns, triangles: None, lists: Vec::new() }
    }

    /// All slots of every column.
    pub(super) fn slots(&mut self) -> Vec<Slots<'_>> {
        self.columns.iter_mut().map(Column::slots).collect()
    }
}

/// Writes one instance, given as one value per property.
#[inline]
pub(super) fn put_row(plan: &Plan, slots: &mut [Slots], row: usize, values: &[f64]) {
    for (field, slots) in plan.fields.iter().zip(slots) {
        let mut of_field = field.blank();
        for (value, &property) in of_field.iter_mut().zip(&field.properties) {
            *value = values.get(property).copied().unwrap_or_default();
        }
        slots.fill(row, 1, field.scale, |_| of_field);
    }
}
