//! From parsed chunks to the mesh.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use crate::loops::prelude::*;

use crate::error::{Place, counted, printable};
use crate::io::{NotDrawn, ReadModel, ReadOptions, ReadReport, Translucent, input::Input};
use crate::mesh::{Attribute, AttributeDomain, MAX_ELEMENTS, localize_at};
use crate::polygon::Triangulator;
use crate::strokes::Strokes;
use crate::{FileMaterial, Mesh, OctNormal, ReadError};

use super::faces::NONE;
use super::lines::join;
use super::mtl;
use super::names::{self, Names};
use super::parse::{Chunk, UNKNOWN_KEPT};
use super::unify::{Vertices, is_unified};

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
        strokes = strokes.colored(
            |number, own| painted.segments.color(number, own),
            |number, own| painted.points.color(number, own),
        );
        strokes.materials = painted.materials;
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

/// The lines and points of the file.
fn strokes(chunks: &mut [Chunk], mesh: &Mesh, warnings: &mut Vec<String>) -> Strokes {
    let broken: u64 = chunks.iter().map(|c| c.not_vertices).sum();
    if broken > 0 {
        let are = if broken == 1 { "is no vertex" } else { "are no vertices" };
        warnings.push(format!("{} of lines and points (l, p) {are}", counted(broken, "end")));
    }
    let segments = chunks.iter_mut().flat_map(|c| std::mem::take(&mut c.segments)).collect();
    let points = chunks.iter_mut().flat_map(|c| std::mem::take(&mut c.dots)).collect();
    Strokes::of_vertices(mesh, segments, points)
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

fn warn_of_missing_texcoords(chunks: &[Chunk], warnings: &mut Vec<String>) {
    let missing: u64 = chunks
        .par_iter()
        .map(|c| {
            let without = if c.corners.vt.is_empty() { c.corners.v.len() } else { 0 };
            (without + c.corners.vt.iter().filter(|&&i| i == NONE).count()) as u64
        })
        .sum();
    if missing > 0 {
        warnings.push(format!(
            "set the texture coordinates of {} without any to 0, 0",
            counted(missing, "corner")
        ));
    }
}

/// Colours that follow the positions: 0 to 1, or 0 to 255 as some programs write them.
fn vertex_colors(chunks: &[Chunk], count: usize, warnings: &mut Vec<String>) -> Option<Vec<[u8; 4]>> {
    if chunks.iter().all(|c| c.colors.is_empty()) {
        return None;
    }
    let largest_of = |c: &Chunk| {
        c.colors.iter().flat_map(|c| &c[..3]).filter(|x| x.is_finite()).fold(0.0f32, |a, &b| a.max(b))
    };
    let largest = chunks.par_iter().map(largest_of).reduce(|| 0.0, f32::max);
    // Colours computed in floating point may exceed 1 by a little.
    let is_bytes = largest > 2.0;
    if is_bytes {
        warnings.push("took vertex colours as 0 to 255, because some are far above 1".into());
    }
    let scale = if is_bytes { 1.0 } else { 255.0 };
    let byte = |x: f32| (x * scale).round() as u8;
    let mut colors = Vec::with_capacity(count);
    let mut without = 0;
    for chunk in chunks {
        colors.extend(chunk.colors.iter().map(|&[r, g, b, a]| {
            if !(r.is_finite() && g.is_finite() && b.is_finite()) {
                without += 1;
                return [255; 4];
            }
            // A missing alpha is stored as 1 in either range.
            let alpha = if a == 1.0 || !a.is_finite() { 255 } else { byte(a) };
            [byte(r), byte(g), byte(b), alpha]
        }));
        let held = chunk.vertices as usize - chunk.colors.len();
        without += held;
        colors.resize(colors.len() + held, [255; 4]);
    }
    if without > 0 {
        warnings
            .push(format!("set the colour of vertices without a finite one to white: {without} of {count}"));
    }
    Some(colors)
}

/// The faces as triangles, and each triangle's face if their numbers differ. Frees the corners.
fn triangles(
    chunks: &mut [Chunk],
    positions: &[[f64; 3]],
    count: usize,
) -> (Vec<[u32; 3]>, Option<Vec<u32>>) {
    let cut: Vec<Option<Cut>> = chunks
        .par_iter()
        .map(|chunk| Some(triangulate(&chunk.corners.v, chunk.corners.sizes()?, positions)))
        .collect();
    let is_mixed = cut.iter().any(Option::is_some);
    let mut triangles = Vec::with_capacity(count);
    let mut faces = Vec::with_capacity(if is_mixed { count } else { 0 });
    let mut face = 0;
    for (chunk, cut) in chunks.iter_mut().zip(cut) {
        let corners = std::mem::take(&mut chunk.corners.v);
        match cut {
            Some((t, f)) => {
                triangles.extend(t);
                faces.extend(f.into_iter().map(|f| f + face));
            }
            None => {
                triangles.extend_from_slice(corners.as_chunks::<3>().0);
                if is_mixed {
                    faces.extend(face..face + chunk.corners.faces());
                }
            }
        }
        face += chunk.corners.faces();
    }
    (triangles, is_mixed.then_some(faces))
}

/// Triangles, and the face of the chunk that each comes from.
type Cut = (Vec<[u32; 3]>, Vec<u32>);

fn triangulate(corners: &[u32], sizes: &[u32], positions: &[[f64; 3]]) -> Cut {
    let mut triangulator = Triangulator::default();
    let mut points = Vec::new();
    let mut triangles = Vec::with_capacity(corners.len() - 2 * sizes.len());
    let mut faces = Vec::with_capacity(triangles.capacity());
    let mut rest = corners;
    for (face, &size) in sizes.iter().enumerate() {
        let (polygon, tail) = rest.split_at(size as usize);
        rest = tail;
        if let &[a, b, c] = polygon {
            triangles.push([a, b, c]);
        } else {
            points.clear();
            points.extend(polygon.iter().map(|&v| positions[v as usize]));
            triangulator.triangulate(&points, |t| triangles.push(t.map(|i| polygon[i])));
        }
        faces.resize(triangles.len(), face as u32);
    }
    (triangles, faces)
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
            });
        }
    }
}

/// Colours of materials of lines and points.
struct Painted<'a> {
    segments: Paints<'a>,
    points: Paints<'a>,
    /// All of these materials, each once.
    materials: Vec<FileMaterial>,
}

/// Materials of elements of one kind.
struct Paints<'a> {
    used: Names<'a>,
    /// The colour of each name.
    colors: Vec<Option<[u8; 4]>>,
}

impl Paints<'_> {
    /// The colour of an element at a vertex with a colour of its own, which then has only the material's opacity, as at the corners
    /// of faces. Without a material, or with an undefined one, it is that of the vertex, if it has one.
    fn color(&self, element: usize, own: Option<[u8; 4]>) -> Option<[u8; 4]> {
        let of_material = self.used.of(element).and_then(|name| self.colors[name as usize]);
        let with_opacity = |[r, g, b, a]: [u8; 4], opacity: u8| {
            [r, g, b, (f32::from(a) * f32::from(opacity) / 255.0).round() as u8]
        };
        match (own, of_material) {
            (Some(own), Some([.., opacity])) => Some(with_opacity(own, opacity)),
            (own, of_material) => own.or(of_material),
        }
    }
}

/// Colour and opacity of a material where there is neither light nor texture.
fn flat_color(material: &FileMaterial) -> [u8; 4] {
    let [r, g, b] = material.diffuse;
    [r, g, b, material.opacity].map(|level| (level * 255.0).round() as u8)
}

/// Looks up the materials that faces, lines and points use. A material that no library defines causes a warning and gets no number,
/// because an invented colour could be mistaken for one of the file. `None` if lines and points have no material.
fn add_materials<'a>(
    input: &Input,
    chunks: &[Chunk<'a>],
    mesh: &mut Mesh,
    companions: &mut Vec<PathBuf>,
    warnings: &mut Vec<String>,
) -> Option<Painted<'a>> {
    let used = Names::join(input, chunks, faces, |c| c.materials.iter().map(|p| (p.face, p.name)));
    let of_segments = |c: &Chunk| c.segments.len() as u64;
    let of_segments =
        Names::join(input, chunks, of_segments, |c| c.materials.iter().map(|p| (p.segment, p.name)));
    let of_dots = |c: &Chunk| c.dots.len() as u64;
    let of_dots = Names::join(input, chunks, of_dots, |c| c.materials.iter().map(|p| (p.dot, p.name)));
    if [&used, &of_segments, &of_dots].iter().all(|used| used.names.is_empty()) {
        // The libraries are not read for this model, but they are files of it nevertheless.
        if let Some(base) = &input.base {
            let (libraries, mut scratch) = (mtl::Libraries::new(base), Vec::new());
            // Each once, in the order of the file.
            let mut noted: HashSet<&[u8]> = HashSet::new();
            for names in chunks.iter().flat_map(|c| &c.libraries).filter(|names| noted.insert(names)) {
                libraries.note_unread(join(names, &mut scratch), companions);
            }
        }
        return None;
    }
    let library = load_libraries(input, chunks, companions, warnings);
    warnings.dedup();
    let mut by_name = HashMap::new();
    for material in library.iter().rev() {
        by_name.insert(material.name.as_str(), material);
    }
    let (mut undefined, mut noted) = (Vec::new(), HashSet::new());
    let mut find = |name: &'a [u8]| {
        let text = names::text(name);
        let material = by_name.get(text.as_str()).copied();
        if material.is_none() && noted.insert(name) {
            undefined.push(format!("\"{text}\""));
        }
        material
    };
    let numbers: Vec<u32> = used
        .names
        .iter()
        .map(|name| match find(name) {
            Some(material) => {
                mesh.materials.push(FileMaterial::clone(material));
                mesh.materials.len() as u32 - 1
            }
            None => Mesh::NO_MATERIAL,
        })
        .collect();
    let mut listed = HashSet::new();
    let names = of_segments.names.iter().chain(&of_dots.names).filter(|name| listed.insert(**name));
    let materials = names.filter_map(|name| find(name).cloned()).collect();
    let [segments, points] = [of_segments, of_dots].map(|used| {
        let colors = used.names.iter().map(|name| find(name).map(flat_color)).collect();
        Paints { used, colors }
    });
    if !undefined.is_empty() {
        let dots = if undefined.len() > 3 { ", …" } else { "" };
        let first = undefined.iter().take(3).cloned().collect::<Vec<_>>().join(", ");
        warnings.push(format!(
            "found no definition of {}: {first}{dots}",
            counted(undefined.len() as u64, "material")
        ));
    }
    if !mesh.materials.is_empty() {
        let number =
            |n: Option<u32>| n.and_then(|n| numbers.get(n as usize)).copied().unwrap_or(Mesh::NO_MATERIAL);
        mesh.triangle_materials =
            Some(used.spread(mesh.triangles.len(), mesh.face_of_triangle.as_deref(), number));
    }
    let has_color = |paints: &Paints| paints.colors.iter().any(Option::is_some);
    (has_color(&segments) || has_color(&points)).then_some(Painted { segments, points, materials })
}

fn load_libraries(
    input: &Input,
    chunks: &[Chunk],
    companions: &mut Vec<PathBuf>,
    warnings: &mut Vec<String>,
) -> Vec<FileMaterial> {
    let lines = chunks.iter().flat_map(|c| &c.libraries);
    let Some(base) = &input.base else {
        if lines.count() > 0 {
            warnings.push("did not look for material libraries: the model comes without a folder".into());
        }
        return Vec::new();
    };
    let mut libraries = mtl::Libraries::new(base);
    let mut asked = HashSet::new();
    let mut scratch = Vec::new();
    for &names in lines {
        if !asked.insert(names) {
            continue;
        }
        // The line may be continued.
        let names = join(names, &mut scratch);
        match asked.len() {
            ..=MOST_LIBRARIES => libraries.load(names, companions, warnings),
            n => {
                if n == MOST_LIBRARIES + 1 {
                    warnings.push(format!("did not read more than {MOST_LIBRARIES} material libraries"));
                }
                libraries.note_unread(names, companions);
            }
        }
    }
    libraries.materials
}

/// Each takes several file-system queries.
const MOST_LIBRARIES: usize = 256;

fn warn_of_ignored(chunks: &[Chunk], warnings: &mut Vec<String>) {
    let small: u64 = chunks.iter().map(|c| c.small_faces).sum();
    if let Some(line) = chunks.iter().find_map(|c| c.first_small_face) {
        warnings.push(format!(
            "ignored {} with fewer than three corners, the first in line {line}",
            counted(small, "face")
        ));
    }
    let pointless: u64 = chunks.iter().map(|c| c.corners.pointless).sum();
    if pointless > 0 {
        let indices = if pointless == 1 { "index" } else { "indices" };
        warnings.push(format!(
            "ignored {pointless} {indices} of texture coordinates or normals that the file does not hold"
        ));
    }
    let odd: u64 = chunks.iter().map(|c| c.odd_numbers).sum();
    if odd > 0 {
        warnings.push(format!("guessed {} written in a way that OBJ does not know", counted(odd, "number")));
    }
    let lines: u64 = chunks.iter().map(|c| c.unknown_lines).sum();
    if lines > 0 {
        let mut unknown: Vec<&[u8]> = Vec::new();
        for keyword in chunks.iter().flat_map(|c| &c.unknown) {
            if unknown.len() < UNKNOWN_KEPT && !unknown.contains(keyword) {
                unknown.push(keyword);
            }
        }
        let shown = unknown.iter().map(|k| printable(k)).collect::<Vec<_>>().join(", ");
        let begin = if lines == 1 { "begins" } else { "begin" };
        warnings
            .push(format!("ignored {} that {begin} with an unknown word: {shown}", counted(lines, "line")));
    }
}
