//! Model files. One module per format; the format is found by content, never by file name.

mod companions;
pub mod input;
pub mod las;
mod not_drawn;
pub mod obj;
pub mod off;
pub mod pcd;
pub mod ply;
pub mod prepared;
pub mod share;
mod sniff;
pub mod stl;
pub mod text;
mod translucent;
pub mod vtk;
pub mod xyz;

use std::path::{Path, PathBuf};

use crate::loops::prelude::*;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::strokes::Strokes;
use crate::{Aabb, Mesh, OctNormal, Progress, ReadError};
pub use companions::relative;
use input::Input;
pub use not_drawn::NotDrawn;
pub use sniff::sniff;
pub use translucent::Translucent;

/// How a model is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReadOptions<'a> {
    /// Most bytes that the model and its reading may take; `None` for no limit.
    pub memory_limit: Option<u64>,
    /// Receives the progress of reading.
    pub progress: Option<&'a Progress>,
    /// The [origin](Mesh::origin) of the mesh, in file coordinates; chosen from the vertices if it is `None`.
    pub origin: Option<DVec3>,
    /// The file is a part of a model: what depends on the whole of it is left to [`share::Facts::settle`].
    pub is_part: bool,
    /// Which of the [times](vtk::times) of a collection is read, counted from 0; the first one, with a warning, if it is `None`. Other
    /// files have one time, whatever this is.
    pub step: Option<usize>,
}

impl ReadOptions<'_> {
    /// Fails if `needed` bytes for `what` are over the limit. Call it before memory is taken.
    ///
    /// # Errors
    /// [`ReadError::MemoryLimit`].
    pub fn check_memory(&self, file: &str, what: &str, needed: u64) -> Result<(), ReadError> {
        match self.memory_limit {
            Some(limit) if needed > limit => {
                Err(ReadError::MemoryLimit { file: file.into(), what: what.into(), needed, limit })
            }
            _ => Ok(()),
        }
    }
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Stanford polygon format.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, ASCII or binary.
    Stl,
    /// Geomview object file format and its dialects.
    Off,
    /// Legacy files of VTK.
    Vtk,
    /// XML files of VTK, and collections of them.
    VtkXml,
    /// Point clouds of the Point Cloud Library.
    Pcd,
    /// Point clouds of laser scanners, LAS or LAZ.
    Las,
    /// Point clouds as text.
    Xyz,
}

/// What a reader found besides the mesh itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ReadReport {
    /// Format and dialect, such as "PLY, binary little-endian".
    pub format: String,
    /// Size of the file on disk, in bytes.
    pub file_bytes: u64,
    /// Faces of any number of corners that the file holds.
    pub faces: u64,
    /// What the file holds or requests that is not drawn.
    pub not_drawn: NotDrawn,
    /// What of it is not opaque.
    pub translucent: Translucent,
    /// Other files that belong to the model: material libraries that were read, and the paths of the textures that it
    /// names. An output must not overwrite any of them.
    pub companions: Vec<PathBuf>,
    /// Warnings, one sentence each, ready to be shown after "warning: FILE: ".
    pub warnings: Vec<String>,
}

/// A mesh and what was found while it was read. The mesh is as the file holds it: not cleaned, not welded, without
/// generated normals. Positions may be non-finite; indices are in range. A normal that the file leaves out, or gives
/// as zero or not finite, is [`OctNormal::NONE`]; [`crate::normals::mend_normals`] replaces it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ReadModel {
    /// The mesh.
    pub mesh: Mesh,
    /// Lines and points of the file.
    pub strokes: Strokes,
    /// Bounds of all vertices with finite coordinates, in file coordinates.
    pub coordinates: Aabb,
    /// What was found.
    pub report: ReadReport,
}

/// Reads a model; `-` is standard input. Gzip is decompressed first, then the format is found by content.
///
/// # Errors
/// Any [`ReadError`]; a broken file never panics.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let input = input::open(path, options)?;
    read_input(&input, options)
}

/// Reads a model from bytes in memory; `input.base` is where companion files (MTL) are looked for.
///
/// # Errors
/// Any [`ReadError`].
pub fn read_input(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let mut model = match sniff(input) {
        Some(Format::Ply) => ply::read(input, options),
        Some(Format::Obj) => obj::read(input, options),
        Some(Format::Stl) => stl::read(input, options),
        Some(Format::Off) => off::read(input, options),
        Some(Format::Vtk) => vtk::read_legacy(input, options),
        Some(Format::VtkXml) => vtk::read_xml(input, options),
        Some(Format::Pcd) => pcd::read(input, options),
        Some(Format::Las) => las::read(input, options),
        Some(Format::Xyz) => xyz::read(input, options),
        None => return Err(sniff::refusal(input)),
    }?;
    model.report.file_bytes = input.file_bytes;
    model.report.warnings.splice(0..0, input.warnings.iter().cloned());
    if options.is_part {
        return Ok(model);
    }
    if warn_of_normals(&mut model) {
        model.mesh.normals = None;
    }
    count_all(&mut model);
    Ok(model)
}

/// Counts what is not drawn and what is not opaque; what is invisible everywhere becomes opaque.
fn count_all(model: &mut ReadModel) {
    let is_cloud = model.report.not_drawn.count_mesh(&model.mesh, model.report.faces);
    let are_vertices = is_cloud && model.strokes.is_empty();
    if are_vertices {
        let points = (0..model.mesh.positions.len() as u32).collect();
        model.strokes = Strokes::of_vertices(&model.mesh, Vec::new(), points);
    }
    let (translucent, warning) = Translucent::count(&mut model.mesh);
    model.report.translucent = translucent;
    let of_strokes = translucent::make_strokes_opaque(&mut model.strokes);
    // Points that are vertices of the mesh count as these.
    if !are_vertices {
        model.report.translucent.count_strokes(&model.strokes);
    }
    model.report.warnings.extend(warning.or(of_strokes));
}

/// Warns of normals that are missing, zero or not finite. Returns whether no valid one is left.
fn warn_of_normals(model: &mut ReadModel) -> bool {
    let Some(normals) = &model.mesh.normals else { return false };
    let broken = normals.par_iter().filter(|n| **n == OctNormal::NONE).count();
    let (all, are) = (normals.len(), if broken == 1 { "is" } else { "are" });
    if broken == 0 {
        return false;
    }
    model.report.warnings.push(format!(
        "{broken} of {all} normals {are} missing, zero or not finite; made from the triangles instead"
    ));
    broken == all
}
