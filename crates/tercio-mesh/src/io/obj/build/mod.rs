//! From parsed chunks to the mesh.

mod ignored;
mod materials;
mod strokes;
mod triangles;
mod vertices;

use crate::loops::prelude::*;

use crate::error::Place;
use crate::io::{NotDrawn, ReadModel, ReadOptions, ReadReport, Translucent, input::Input};
use crate::mesh::{Attribute, AttributeDomain, MAX_ELEMENTS, localize_at};
use crate::{Mesh, OctNormal, ReadError};

use super::faces::NONE;
use super::names::Names;
use super::parse::Chunk;
use super::unify::{Vertices, is_unified};
use ignored::warn_of_ignored;
use materials::add_materials;
use strokes::strokes;
use triangles::triangles;
use vertices::{vertex_colors, warn_of_missing_texcoords};

/// The parsed contents of the file.
pub struct Parsed<'a> {
    /// From `v`.
    pub positions: Vec<[f64; 3]>,
    /// From `vt`.
    pub texcoords: Vec<[f32; 2]>,
    /// From `vn`.
    pub normals: Vec<OctNormal>,
    /// Everything else.
    pub chunks: Vec<Chunk<'a>>,
}

/// Makes the mesh.
///
/// # Errors
/// Too many vertices or triangles, or too little memory for them.
pub fn build(input: &Input, options: &ReadOptions, parsed: Parsed) -> Result<ReadModel, ReadError> {
    let Parsed { mut positions, texcoords, mut normals, mut chunks } = parsed;
    if positions.is_empty() {
        return Err(ReadError::Malformed {
            file: input.name.clone(),
            place: Place::File,
            expected: "at least one vertex (v)".into(),
            found: "none in the whole file".into(),
        });
    }
    let mut warnings = Vec::new();
    let faces: u64 = chunks.iter().map(|c| u64::from(c.corners.faces())).sum();
    let triangle_count: u64 = chunks.iter().map(|c| c.corners.triangles()).sum();
    let too_many = |what, count| ReadError::TooMany { file: input.name.clone(), what, count };
    if triangle_count > MAX_ELEMENTS {
        return Err(too_many("triangles", triangle_count));
    }

    let with_vt = uses(&chunks, |c| &c.corners.vt);
    let with_vn = uses(&chunks, |c| &c.corners.vn);
    if with_vt {
        warn_of_missing_texcoords(&chunks, &mut warnings);
    }
    let corners: u64 = chunks.iter().map(|c| c.corners.v.len() as u64).sum();
    let vertices_needed =
        positions.len() as u64 * 48 + texcoords.len() as u64 * 16 + normals.len() as u64 * 16;
    let needed = input.held_bytes() + vertices_needed + corners * 4 + triangle_count * 24;
    options.check_memory(&input.name, "triangles", needed)?;

    let unified = is_unified(&chunks, with_vt, with_vn);
    let vertices = if unified {
        None
    } else {
        let v = Vertices::unify(positions.len(), &mut chunks, with_vt, with_vn)
            .map_err(|count| too_many("vertices", count))?;
        options.check_memory(&input.name, "split vertices", needed + v.extra() as u64 * 68)?;
        Some(v)
    };
    let vertex_colors = vertex_colors(&chunks, positions.len(), &mut warnings);
    let mut mesh = Mesh { vertex_colors, ..Mesh::default() };
    match &vertices {
        Some(v) => {
            v.extend(&mut positions);
            if let Some(colors) = &mut mesh.vertex_colors {
                v.extend(colors);
            }
            // A vertex that no corner uses has no normal index, and needs no normal.
            let at = |i: u32| match i {
                NONE => OctNormal::NONE,
                i => normals.get(i as usize).copied().unwrap_or_default(),
            };
            mesh.normals = with_vn.then(|| v.normals().map(at).collect());
            let at = |i: u32| texcoords.get(i as usize).copied().unwrap_or_default();
            mesh.texcoords = with_vt.then(|| v.texcoords().map(at).collect());
        }
        None => {
            let count = positions.len();
            mesh.normals = with_vn.then(|| {
                normals.resize(count, OctNormal::default());
                std::mem::take(&mut normals)
            });
            mesh.texcoords = with_vt.then(|| {
                let mut t = texcoords;
                t.resize(count, [0.0; 2]);
                t
            });
        }
    }
    drop(vertices);
    drop(normals);
    (mesh.triangles, mesh.face_of_triangle) = triangles(&mut chunks, &positions, triangle_count as usize);
    let coordinates;
    (coordinates, mesh.origin, mesh.positions) = localize_at(&positions, options.origin);
    drop(positions);

    let not_drawn = not_drawn(&chunks);
    add_names(input, &chunks, &mut mesh);
    let mut companions = Vec::new();
    let painted = add_materials(input, &chunks, &mut mesh, &mut companions, &mut warnings);
    let mut strokes = strokes(&mut chunks, &mesh, &mut warnings);
    if let Some(painted) = painted {
        // Each end may become a vertex of its own, which is looked up by its colour.
        let ends = 2 * strokes.segments.len() as u64 + strokes.points.len() as u64;
        let each = 64 + 8 * strokes.attributes.len() as u64;
        options.check_memory(&input.name, "coloured lines and points", needed + ends * each)?;
        strokes = painted.paint(strokes);
    }
    warn_of_ignored(&chunks, &mut warnings);
    let report = ReadReport {
        format: "OBJ".into(),
        file_bytes: input.file_bytes,
        faces,
        translucent: Translucent::default(),
        not_drawn,
        companions,
        warnings,
    };
    Ok(ReadModel { mesh, strokes, coordinates, report })
}

fn not_drawn(chunks: &[Chunk]) -> NotDrawn {
    let sum = |of: fn(&Chunk) -> u64| chunks.iter().map(of).sum();
    NotDrawn {
        points: sum(|c| c.points),
        lines: sum(|c| c.lines),
        curves: sum(|c| c.curves),
        surfaces: sum(|c| c.surfaces),
        ..NotDrawn::default()
    }
}

fn uses(chunks: &[Chunk], of: impl for<'c> Fn(&'c Chunk) -> &'c Vec<u32> + Sync) -> bool {
    chunks.par_iter().any(|c| of(c).iter().any(|&i| i != NONE))
}

fn faces(chunk: &Chunk) -> u64 {
    chunk.corners.faces().into()
}

/// Groups and objects become attributes if there is more than one.
fn add_names(input: &Input, chunks: &[Chunk], mesh: &mut Mesh) {
    let groups = Names::join(input, chunks, faces, |c| c.groups.iter().copied());
    let objects = Names::join(input, chunks, faces, |c| c.objects.iter().copied());
    for (name, names) in [("group", groups), ("object", objects)] {
        if names.differ() {
            // Faces before the first name count as a group of their own, number 0.
            let values = names.spread(mesh.triangles.len(), mesh.face_of_triangle.as_deref(), |number| {
                number.map_or(0.0, |n| n as f32 + 1.0)
            });
            mesh.attributes.push(Attribute {
                name: name.into(),
                domain: AttributeDomain::Triangle,
                values,
                offset: 0.0,
                component: None,
            });
        }
    }
}
