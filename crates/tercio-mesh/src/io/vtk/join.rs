//! Joins parts to one model.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::part::{Part, Positions};
use crate::io::{ReadModel, ReadReport};
use crate::mesh::{MAX_ELEMENTS, choose_origin, localize_at, localize_single_at};
use crate::strokes::Strokes;
use crate::{Aabb, Attribute, AttributeDomain, Mesh, OctNormal, ReadError};

impl Part {
    /// Bytes of memory, about.
    pub fn bytes(&self) -> u64 {
        let attributes = self.attributes.iter().chain(&self.strokes.attributes);
        let values: u64 = attributes.map(|a| 4 * a.values.len() as u64).sum();
        let strokes = 40 * self.strokes.positions.len() as u64;
        values + strokes + 48 * self.vertices() as u64 + 20 * self.triangles.len() as u64
    }

    fn vertices(&self) -> usize {
        match &self.positions {
            Positions::Single(positions) => positions.len(),
            Positions::Double(positions) => positions.len(),
        }
    }
}

/// Bytes of memory that joining parts takes, about.
pub fn needed_bytes(parts: &[Part]) -> u64 {
    let (mut vertices, mut triangles, mut ends) = (0u64, 0u64, 0u64);
    let (mut of_vertices, mut of_triangles, mut of_ends) = (HashSet::new(), HashSet::new(), HashSet::new());
    for part in parts {
        vertices += part.vertices() as u64;
        triangles += part.triangles.len() as u64;
        ends += part.strokes.positions.len() as u64;
        of_ends.extend(part.strokes.attributes.iter().map(|a| a.name.as_str()));
        for attribute in &part.attributes {
            let names = match attribute.domain {
                AttributeDomain::Vertex => &mut of_vertices,
                AttributeDomain::Triangle => &mut of_triangles,
            };
            names.insert(attribute.name.as_str());
        }
    }
    // What one part has is filled in for all others.
    let values = [(of_vertices, vertices), (of_triangles, triangles), (of_ends, ends)];
    let filled =
        values.iter().map(|(names, count)| 4 * names.len() as u64 * count).fold(0, u64::saturating_add);
    // Growing arrays may take twice their size.
    parts.iter().map(|p| 3 * p.bytes()).fold(filled.saturating_mul(2), u64::saturating_add)
}

/// Joins parts in their order. Faces are numbered by cells, one part after the other.
///
/// # Errors
/// Too many elements.
pub fn join(file: &str, mut parts: Vec<Part>, origin: Option<DVec3>) -> Result<ReadModel, ReadError> {
    let sums = |count: fn(&Part) -> u64| parts.iter().map(count).fold(0, u64::saturating_add);
    for (what, count) in [
        ("vertices", sums(|p| p.vertices() as u64)),
        ("triangles", sums(|p| p.triangles.len() as u64)),
        ("cells", sums(|p| p.cell_count)),
        ("points of lines", sums(|p| p.strokes.positions.len() as u64)),
    ] {
        if count > MAX_ELEMENTS {
            return Err(ReadError::TooMany { file: file.into(), what, count });
        }
    }
    let cell_count = sums(|p| p.cell_count);
    agree(&mut parts);
    let mut parts = parts.into_iter();
    let Some(mut whole) = parts.next() else { return Err(nothing(file)) };
    let rest: Vec<Part> = parts.collect();
    for part in rest {
        append(&mut whole, part);
    }

    let mut bounds = Aabb::EMPTY;
    let finite = |p: &DVec3| p.is_finite();
    whole.strokes.positions.iter().map(|&p| DVec3::from(p)).filter(finite).for_each(|p| bounds.add(p));
    match &whole.positions {
        Positions::Single(positions) => {
            let points = positions.iter().map(|p| DVec3::from(p.map(f64::from))).filter(finite);
            points.for_each(|p| bounds.add(p));
        }
        Positions::Double(positions) => {
            positions.iter().map(|&p| DVec3::from(p)).filter(finite).for_each(|p| bounds.add(p));
        }
    }
    let origin = origin.unwrap_or_else(|| choose_origin(&bounds));
    let (.., positions) = match whole.positions {
        Positions::Single(positions) => localize_single_at(positions, Some(origin)),
        Positions::Double(positions) => localize_at(&positions, Some(origin)),
    };
    let (.., stroke_positions) = localize_at(&whole.strokes.positions, Some(origin));
    let is_identity = whole.cells.as_ref().is_none_or(|cells| cells.iter().zip(0..).all(|(&c, i)| c == i))
        && whole.triangles.len() as u64 == cell_count;
    let cells = if is_identity {
        None
    } else {
        whole.cells.or_else(|| Some((0..whole.triangles.len() as u32).collect()))
    };
    let strokes = Strokes {
        origin,
        positions: stroke_positions,
        colors: whole.strokes.colors.map(|colors| colors.into_iter().map(Some).collect()),
        attributes: whole.strokes.attributes,
        segments: whole.strokes.segments,
        points: whole.strokes.points,
        materials: Vec::new(),
    };
    let mut report = ReadReport::default();
    report.not_drawn.lines = strokes.segments.len() as u64;
    report.not_drawn.points = strokes.points.len() as u64;
    report.faces = if whole.triangles.is_empty() { 0 } else { cell_count };
    let mesh = Mesh {
        origin,
        positions,
        normals: whole.normals,
        vertex_colors: whole.vertex_colors,
        face_colors: whole.face_colors,
        texcoords: whole.texcoords,
        attributes: whole.attributes,
        face_of_triangle: cells,
        triangles: whole.triangles,
        ..Mesh::default()
    };
    Ok(ReadModel { mesh, strokes, coordinates: bounds, report })
}

/// Gives the values of all parts that will be one attribute one offset.
fn agree(parts: &mut [Part]) {
    let mut of_cells: HashMap<(AttributeDomain, String), Vec<&mut Attribute>> = HashMap::new();
    let mut of_ends: HashMap<String, Vec<&mut Attribute>> = HashMap::new();
    let has_any = |p: &Part| p.attributes.iter().chain(&p.strokes.attributes).any(|a| a.offset != 0.0);
    if parts.len() < 2 || !parts.iter().any(has_any) {
        return;
    }
    for part in parts {
        for a in &mut part.attributes {
            of_cells.entry((a.domain, a.name.clone())).or_default().push(a);
        }
        for a in &mut part.strokes.attributes {
            of_ends.entry(a.name.clone()).or_default().push(a);
        }
    }
    of_cells.into_values().chain(of_ends.into_values()).for_each(|mut all| Attribute::agree(&mut all));
}

fn nothing(file: &str) -> ReadError {
    ReadError::HoldsNothing { file: file.into(), but: "the markup of VTK, without a data set" }
}

/// Appends a part to another one. What only one of them has is filled in: colours with white, all else with NaN.
fn append(whole: &mut Part, part: Part) {
    let (vertices, triangles) = (whole.vertices(), whole.triangles.len());
    let (more_vertices, more_triangles) = (part.vertices(), part.triangles.len());
    let double = |positions: Positions| match positions {
        Positions::Single(positions) => positions.into_iter().map(|p| p.map(f64::from)).collect(),
        Positions::Double(positions) => positions,
    };
    match (&mut whole.positions, part.positions) {
        (Positions::Single(all), Positions::Single(more)) => all.extend(more),
        (Positions::Double(all), more) => all.extend(double(more)),
        (all, more) => {
            let mut joined = double(std::mem::replace(all, Positions::Single(Vec::new())));
            joined.extend(double(more));
            *all = Positions::Double(joined);
        }
    }
    let shift = vertices as u32;
    let cells = whole.cells.get_or_insert_with(|| (0..triangles as u32).collect());
    let first = whole.cell_count as u32;
    match part.cells {
        Some(more) => cells.extend(more.iter().map(|cell| cell + first)),
        None => cells.extend((0..more_triangles as u32).map(|cell| cell + first)),
    }
    whole.cell_count += part.cell_count;
    whole.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + shift)));
    both(&mut whole.normals, part.normals, vertices, more_vertices, OctNormal::NONE);
    both(&mut whole.texcoords, part.texcoords, vertices, more_vertices, [0.0; 2]);
    both(&mut whole.vertex_colors, part.vertex_colors, vertices, more_vertices, [255; 4]);
    both(&mut whole.face_colors, part.face_colors, triangles, more_triangles, [255; 4]);
    let lengths = |domain| match domain {
        AttributeDomain::Vertex => (vertices, more_vertices),
        AttributeDomain::Triangle => (triangles, more_triangles),
    };
    append_attributes(&mut whole.attributes, part.attributes, lengths);

    let (all, more) = (&mut whole.strokes, part.strokes);
    let lengths = (all.positions.len(), more.positions.len());
    let shift = lengths.0 as u32;
    all.positions.extend(more.positions);
    all.segments.extend(more.segments.iter().map(|s| s.map(|v| v + shift)));
    all.points.extend(more.points.iter().map(|v| v + shift));
    both(&mut all.colors, more.colors, lengths.0, lengths.1, [255; 4]);
    append_attributes(&mut all.attributes, more.attributes, |_| lengths);
}

/// Appends one array to the other, if there is one of them.
fn both<T: Clone>(whole: &mut Option<Vec<T>>, part: Option<Vec<T>>, length: usize, more: usize, none: T) {
    match (whole.as_mut(), part) {
        (None, None) => {}
        (Some(whole), Some(part)) => whole.extend(part),
        (Some(whole), None) => whole.resize(length + more, none),
        (None, Some(part)) => {
            let mut joined = vec![none; length];
            joined.extend(part);
            *whole = Some(joined);
        }
    }
}

fn append_attributes(
    whole: &mut Vec<Attribute>,
    part: Vec<Attribute>,
    lengths: impl Fn(AttributeDomain) -> (usize, usize),
) {
    // Not by a search for each: a file of a kilobyte can have tens of thousands.
    let mut places: HashMap<(AttributeDomain, String), usize> = HashMap::new();
    for (place, attribute) in whole.iter().enumerate() {
        places.entry((attribute.domain, attribute.name.clone())).or_insert(place);
    }
    for attribute in part {
        match places.entry((attribute.domain, attribute.name.clone())) {
            Entry::Occupied(place) => {
                let all = whole.get_mut(*place.get());
                if let Some(all) = all.filter(|all| all.values.len() == lengths(attribute.domain).0) {
                    all.values.extend(attribute.values);
                }
            }
            Entry::Vacant(place) => {
                place.insert(whole.len());
                let mut values = vec![f32::NAN; lengths(attribute.domain).0];
                values.extend(attribute.values);
                whole.push(Attribute { values, ..attribute });
            }
        }
    }
    for attribute in whole {
        let (length, more) = lengths(attribute.domain);
        attribute.values.resize(length + more, f32::NAN);
    }
}
