//! One data set as triangles, lines and points with their data, before it is joined with those of other files.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::loops::prelude::*;

use super::dataset::{Array, Cells, DataSet, Job, Points, Use};
use super::numbers::Scalar;
use super::surface::{self, Surface};
use crate::{Attribute, AttributeDomain, OctNormal, ReadError};

/// Positions in file coordinates, as precise as in the file.
pub enum Positions {
    Single(Vec<[f32; 3]>),
    Double(Vec<[f64; 3]>),
}

/// Bytes that a part takes itself, also while parts are joined, and with the allocations of small ones: a file may have very many.
const PART_BYTES: u64 = 2 * size_of::<Part>() as u64 + 512;

/// What is drawn of a data set.
pub struct Part {
    pub positions: Positions,
    pub triangles: Vec<[u32; 3]>,
    /// The cell of each triangle; `None` where it has the same number.
    pub cells: Option<Vec<u32>>,
    /// Cells of the data set.
    pub cell_count: u64,
    pub normals: Option<Vec<OctNormal>>,
    pub texcoords: Option<Vec<[f32; 2]>>,
    pub vertex_colors: Option<Vec<[u8; 4]>>,
    pub face_colors: Option<Vec<[u8; 4]>>,
    pub attributes: Vec<Attribute>,
    pub strokes: Strokes,
}

/// Lines and points, with vertices of their own for every cell: so each can have the data of its cell.
#[derive(Default)]
pub struct Strokes {
    pub positions: Vec<[f64; 3]>,
    pub colors: Option<Vec<[u8; 4]>>,
    pub attributes: Vec<Attribute>,
    pub segments: Vec<[u32; 2]>,
    pub points: Vec<u32>,
}

/// Makes a part of a data set.
///
/// # Errors
/// Too many elements, or too little memory.
pub fn make(job: &Job, mut data: DataSet) -> Result<Part, ReadError> {
    for (arrays, count, what) in
        [(&data.point_data, data.points.count(), "points"), (&data.cell_data, data.cells.count(), "cells")]
    {
        for array in arrays {
            if array.tuples() != count {
                let expected =
                    format!("{count} tuples of array {:?}, one for each of the {what}", array.name);
                return Err(job.malformed(array.numbers.place(0), expected, array.tuples().to_string()));
            }
        }
    }
    // Arrays of nothing, of any number of components, would become as many attributes.
    if data.points.count() == 0 {
        data.point_data.clear();
    }
    if data.cells.count() == 0 {
        data.cell_data.clear();
    }
    let cell_count = data.cells.count();
    // Points of polygonal data belong to the surface, and where nothing is left out they need not be counted.
    let all_points = match (&data.cells, &data.points) {
        (Cells::Poly([verts, lines, ..]), Points::Listed(_)) => verts.len() + lines.len() == 0,
        _ => false,
    };
    let mut surface = surface::extract(job, &mut data)?;
    let kept = if all_points { None } else { Some(keep_used(job, &mut surface, data.points.count())?) };
    let kept = kept.as_deref();
    let count = kept.map_or(data.points.count(), |k| k.len() as u64);
    let components = |arrays: &[Array]| arrays.iter().map(|a| a.components as u64).sum::<u64>();
    let triangles = surface.triangles.len() as u64;
    let stroke_vertices = surface.lines.len() as u64 + surface.dots.len() as u64;
    let per_vertex = 24 + 12 + 4 * (components(&data.point_data) + 4);
    let needed =
        count.saturating_mul(per_vertex) + triangles.saturating_mul(4 * (components(&data.cell_data) + 1));
    let of_strokes = per_vertex + 4 * components(&data.cell_data) + 20;
    // Of the surface, and of lines and points.
    let arrays = data.point_data.iter().chain(&data.cell_data);
    let own = |a: &Array| a.names.iter().map(|name| name.len() as u64).sum::<u64>();
    let names: u64 = arrays.map(|a| 2 * (Attribute::bytes_of_names(&a.name, a.components) + own(a))).sum();
    job.reserve(
        "its vertices and their data",
        needed
            .saturating_add(stroke_vertices.saturating_mul(of_strokes))
            .saturating_add(names)
            .saturating_add(PART_BYTES),
    )?;

    let strokes = strokes(job, &data, &surface)?;
    let mut part = Part {
        positions: positions(&data.points, kept),
        triangles: surface.triangles,
        cells: surface.cells,
        cell_count,
        normals: None,
        texcoords: None,
        vertex_colors: None,
        face_colors: None,
        attributes: Vec::new(),
        strokes,
    };
    // Vertices are left without triangles only where the file holds points and no cells.
    if part.triangles.is_empty() && !all_points {
        return Ok(part);
    }
    for array in &data.point_data {
        match array.r#use {
            Use::Normals => {
                part.normals = Some(
                    array
                        .numbers
                        .tuples(array.components, kept, OctNormalOf::from)
                        .into_iter()
                        .map(|n| n.0)
                        .collect(),
                )
            }
            Use::Texcoords => {
                let texcoords =
                    array.numbers.tuples(array.components, kept, |[u, v]: [f64; 2]| [u as f32, v as f32]);
                part.texcoords = Some(texcoords);
            }
            Use::Colors => part.vertex_colors = Some(colors(array, kept)),
            Use::Attribute => {}
        }
        attributes(job, array, AttributeDomain::Vertex, kept, &mut part.attributes);
    }
    for array in &data.cell_data {
        let cells = part.cells.as_deref();
        if array.r#use == Use::Colors {
            part.face_colors = Some(colors(array, cells));
        }
        attributes(job, array, AttributeDomain::Triangle, cells, &mut part.attributes);
    }
    if !surface.polygons.is_empty() {
        let (name, domain) = (Attribute::POLYGON.into(), AttributeDomain::Triangle);
        part.attributes.push(Attribute {
            name,
            domain,
            values: surface.polygons,
            offset: 0.0,
            component: None,
        });
    }
    Ok(part)
}

/// A normal that can be filled in.
#[derive(Clone)]
struct OctNormalOf(OctNormal);

impl Default for OctNormalOf {
    fn default() -> Self {
        Self(OctNormal::NONE)
    }
}

impl OctNormalOf {
    fn from(normal: [f64; 3]) -> Self {
        Self(OctNormal::from_vector(normal))
    }
}

/// Numbers the points that triangles use, in their order.
fn keep_used(job: &Job, surface: &mut Surface, points: u64) -> Result<Vec<u32>, ReadError> {
    let corners = surface.triangles.as_flattened().len() as u64;
    // Of a large grid few points are on the surface: they are sorted, so that no table of all points is needed.
    if points / 64 > corners {
        job.reserve("the vertices of its surface", 4 * corners)?;
        let mut kept = surface.triangles.as_flattened().to_vec();
        kept.par_sort_unstable();
        kept.dedup();
        let number = |v: u32| kept.binary_search(&v).map_or(0, |i| i as u32);
        surface.triangles.par_iter_mut().for_each(|t| *t = t.map(number));
        return Ok(kept);
    }
    let words = points.div_ceil(64);
    job.reserve("the vertices of its surface", 4 * points.min(corners) + 12 * words)?;
    // A bit of each point.
    let used: Vec<AtomicU64> = (0..words).map(|_| AtomicU64::new(0)).collect();
    surface.triangles.par_iter().for_each(|triangle| {
        for &v in triangle {
            let (word, bit) = (&used[v as usize / 64], 1 << (v % 64));
            // Nearly always it is there, and reading is cheaper.
            if word.load(Relaxed) & bit == 0 {
                word.fetch_or(bit, Relaxed);
            }
        }
    });
    let used: Vec<u64> = used.into_iter().map(AtomicU64::into_inner).collect();
    let count: usize = used.iter().map(|bits| bits.count_ones() as usize).sum();
    let (mut kept, mut before) = (Vec::with_capacity(count), Vec::with_capacity(used.len()));
    for (word, &bits) in used.iter().enumerate() {
        before.push(kept.len() as u32);
        let mut rest = bits;
        while rest != 0 {
            kept.push(64 * word as u32 + rest.trailing_zeros());
            rest &= rest - 1;
        }
    }
    if kept.len() as u64 == points {
        return Ok(kept);
    }
    let number = |v: u32| {
        let word = v as usize / 64;
        before[word] + (used[word] & ((1 << (v % 64)) - 1)).count_ones()
    };
    surface.triangles.par_iter_mut().for_each(|t| *t = t.map(number));
    Ok(kept)
}

fn positions(points: &Points, kept: Option<&[u32]>) -> Positions {
    match (points, kept) {
        (Points::Listed(numbers), None) if numbers.scalar == Scalar::F32 => {
            Positions::Single(numbers.points32())
        }
        (Points::Listed(numbers), Some(_)) if numbers.scalar == Scalar::F32 => {
            Positions::Single(numbers.tuples(3, kept, |p: [f64; 3]| p.map(|c| c as f32)))
        }
        (Points::Listed(numbers), _) => Positions::Double(numbers.tuples(3, kept, |p: [f64; 3]| p)),
        (_, Some(kept)) => Positions::Double(kept.par_iter().map(|&p| points.get(p)).collect()),
        (_, None) => {
            Positions::Double((0..points.count() as u32).into_par_iter().map(|p| points.get(p)).collect())
        }
    }
}

fn colors(array: &Array, elements: Option<&[u32]>) -> Vec<[u8; 4]> {
    let scale = if array.numbers.scalar.is_real() { 255.0 } else { 1.0 };
    let components = array.components;
    array.numbers.tuples(components, elements, |c: [f64; 4]| {
        let byte = |x: f64| (x * scale).clamp(0.0, 255.0).round() as u8;
        match components {
            1 => [byte(c[0]), byte(c[0]), byte(c[0]), 255],
            2 => [byte(c[0]), byte(c[0]), byte(c[0]), byte(c[1])],
            3 => [byte(c[0]), byte(c[1]), byte(c[2]), 255],
            _ => c.map(byte),
        }
    })
}

/// Appends the components of an array as attributes.
fn attributes(
    job: &Job,
    array: &Array,
    domain: AttributeDomain,
    elements: Option<&[u32]>,
    to: &mut Vec<Attribute>,
) {
    if Attribute::is_polygon(&array.name, domain) {
        job.warn(format!("values of {:?} at cells are left out: the name is reserved", array.name));
        return;
    }
    let mut warning = None;
    for component in 0..array.components {
        let doubles = array.numbers.doubles(component, array.components);
        warning = warning.or_else(|| doubles.warning(&array.name, !array.numbers.scalar.is_real()));
        let (offset, of_part) = doubles.offset_for(&array.name, job.options.is_part);
        warning = warning.or(of_part);
        let values = array.numbers.component(component, array.components, elements, offset);
        let name = Attribute::component_name(&array.name, component, array.components);
        let own = array.component(component).map(str::to_owned);
        to.push(Attribute { name, domain, values, offset, component: own });
    }
    warning.into_iter().for_each(|warning| job.warn(warning));
}

/// Lines and points with the data of their points and cells.
fn strokes(job: &Job, data: &DataSet, surface: &Surface) -> Result<Strokes, ReadError> {
    let mut strokes = Strokes::default();
    let count = surface.lines.len() + surface.dots.len();
    if count == 0 {
        return Ok(strokes);
    }
    if count as u64 > crate::mesh::MAX_ELEMENTS {
        return Err(ReadError::TooMany {
            file: job.file().into(),
            what: "points of lines",
            count: count as u64,
        });
    }
    let mut points = surface.lines.clone();
    let mut cells = Vec::with_capacity(count);
    let mut start = 0;
    for &(end, cell) in &surface.line_ends {
        let vertices = start as u32..end as u32;
        strokes.segments.extend(vertices.clone().zip(vertices.clone().skip(1)).map(|(a, b)| [a, b]));
        cells.extend(vertices.map(|_| cell));
        start = end;
    }
    for &[point, cell] in &surface.dots {
        strokes.points.push(points.len() as u32);
        points.push(point);
        cells.push(cell);
    }
    strokes.positions = points.iter().map(|&p| data.points.get(p)).collect();
    for (arrays, elements) in [(&data.point_data, &points), (&data.cell_data, &cells)] {
        for array in arrays {
            if array.r#use == Use::Colors {
                strokes.colors = Some(colors(array, Some(elements)));
            }
            attributes(job, array, AttributeDomain::Vertex, Some(elements), &mut strokes.attributes);
        }
    }
    Ok(strokes)
}
