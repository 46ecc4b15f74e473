//! XML files of VTK (`.vtp`, `.vtu`, `.vti`, `.vts`, `.vtr`) and collections of them.
//!
//! Elements name arrays, whose numbers are text, base64, or appended to the elements; they may be compressed in
//! blocks. A library parses the elements; appended data are read where they are.
//!
//! Source: VTK XML Formats (docs.vtk.org); `vtkXMLWriter` and `vtkXMLDataReader` of VTK 9.

mod arrays;
mod base64;
mod compress;
mod pieces;
pub mod tree;

use super::TIME_NAMES;
use super::dataset::{Array, Cells, DataSet, GHOSTS, Job, Use};
use super::extents::{Extent, Extents};
use super::numbers::Scalar;
use super::part::{self, Part};
use crate::ReadError;
use arrays::{Encoding, Type};
use compress::Compressor;
use tree::{Document, Element};

/// Components of an array that may have names.
const MOST_NAMED: usize = 256;

/// What a file is.
pub enum Kind {
    /// A data set, with the name of its kind.
    Data(&'static str),
    /// A collection of files.
    Collection(&'static str),
}

/// The kind of a file.
///
/// # Errors
/// [`ReadError::Unsupported`] for those that are not read.
pub fn kind(job: &Job, document: &Document) -> Result<Kind, ReadError> {
    let root = &document.root;
    let kind = root.attribute("type").unwrap_or("without a type");
    Ok(match kind {
        "PolyData" => Kind::Data("polygonal data"),
        "UnstructuredGrid" => Kind::Data("unstructured grid"),
        "ImageData" => Kind::Data("image data"),
        "StructuredGrid" => Kind::Data("structured grid"),
        "RectilinearGrid" => Kind::Data("rectilinear grid"),
        "PPolyData" | "PUnstructuredGrid" | "PImageData" | "PStructuredGrid" | "PRectilinearGrid" => {
            Kind::Collection("parallel pieces")
        }
        "Collection" => Kind::Collection("collection"),
        "vtkMultiBlockDataSet" => Kind::Collection("blocks"),
        "vtkPartitionedDataSet" | "vtkPartitionedDataSetCollection" => Kind::Collection("partitions"),
        _ => return Err(job.unsupported(job.line(root.at), format!("VTK's data set {kind}"))),
    })
}

/// How the arrays of a file are encoded, in words, for the report.
pub fn encoding_name(document: &Document) -> String {
    let compressor = document.root.attribute("compressor").and_then(Compressor::named);
    let mut words = match document.appended {
        Some((_, true)) => "appended base64".to_owned(),
        Some((_, false)) => "appended raw".to_owned(),
        None => "inline".to_owned(),
    };
    if let Some(compressor) = compressor {
        words += &format!(", {}", compressor.name());
    }
    words
}

fn encoding(job: &Job, document: &Document) -> Result<Encoding, ReadError> {
    let root = &document.root;
    let malformed =
        |expected: &str, found: &str| job.malformed(job.line(root.at), expected, format!("{found:?}"));
    let big_endian = match root.attribute("byte_order") {
        Some("LittleEndian") | None => false,
        Some("BigEndian") => true,
        Some(other) => return Err(malformed("byte_order=\"LittleEndian\" or \"BigEndian\"", other)),
    };
    let word = match root.attribute("header_type") {
        Some("UInt32") | None => 4,
        Some("UInt64") => 8,
        Some(other) => return Err(malformed("header_type=\"UInt32\" or \"UInt64\"", other)),
    };
    let compressor =
        match root.attribute("compressor").filter(|name| !name.is_empty()) {
            None => None,
            Some(name) => Some(Compressor::named(name).ok_or_else(|| {
                malformed("the compressor vtkZLib-, vtkLZ4- or vtkLZMADataCompressor", name)
            })?),
        };
    Ok(Encoding { big_endian, word, compressor, appended: document.appended })
}

/// The time that the field data of a file have.
///
/// # Errors
/// Any [`ReadError`].
pub fn time(job: &Job, document: &Document) -> Result<Option<f64>, ReadError> {
    let kind = document.root.attribute("type").unwrap_or_default();
    let data = document.root.child(kind).and_then(|data| data.child("FieldData"));
    let arrays = data.into_iter().flat_map(|data| data.children_named("DataArray"));
    let is_time = |name: &str| TIME_NAMES.contains(&name);
    let Some(array) = { arrays }.find(|array| array.attribute("Name").is_some_and(is_time)) else {
        return Ok(None);
    };
    let Type::Numbers(scalar) = arrays::kind(job, array)? else { return Ok(None) };
    let numbers = arrays::numbers(job, &encoding(job, document)?, array, scalar)?;
    Ok((numbers.len() > 0).then(|| numbers.double(0)))
}

/// That of a piece of a grid.
fn extent(piece: &Element) -> Option<Extent> {
    Extent::parse(piece.attribute("Extent")?)
}

/// Does an array say which cells or points are ghosts?
fn is_ghost(array: &Element) -> bool {
    array.attribute("Name").is_some_and(|name| GHOSTS.contains(&name))
}

/// That of a piece whose cells are all there, as far as its arrays say: beside cells that are hidden, there is an outside.
fn solid_extent(piece: &Element) -> Option<Extent> {
    let of = |name| piece.children_named(name).flat_map(|data| &data.children);
    if of("PointData").chain(of("CellData")).any(is_ghost) { None } else { extent(piece) }
}

/// The files that are the pieces of a grid, with their extents; none if cells may be hidden.
pub fn extents(document: &Document) -> Vec<(&str, Extent)> {
    let grids = document.root.children.iter();
    let arrays = grids.clone().flat_map(|grid| &grid.children).flat_map(|data| &data.children);
    if { arrays }.any(is_ghost) {
        return Vec::new();
    }
    let pieces = grids.flat_map(|grid| grid.children_named("Piece"));
    pieces.filter_map(|piece| Some((piece.attribute("Source")?, extent(piece)?))).collect()
}

/// All pieces of a file with a data set.
///
/// # Errors
/// Any [`ReadError`].
pub fn parts(job: &Job, document: &Document) -> Result<Vec<Part>, ReadError> {
    let reader = Reader { job, encoding: encoding(job, document)? };
    let root = &document.root;
    let kind = root.attribute("type").unwrap_or_default();
    let Some(data) = root.child(kind) else {
        return Err(job.malformed(job.line(root.at), format!("the element {kind}"), "none"));
    };
    job.begin("reading pieces", data.children_named("Piece").count() as u64);
    let extents: Extents = data.children_named("Piece").filter_map(solid_extent).collect();
    let mut parts = Vec::new();
    for piece in data.children_named("Piece") {
        if let Some(mut set) = reader.piece(kind, data, piece)? {
            if let (Cells::Structured(_), Some(own)) = (&set.cells, extent(piece)) {
                set.beside = extents.beside(&own);
                set.beside.extend(job.extents.beside(&own));
            }
            parts.push(part::make(job, set)?);
        }
        job.advance(1);
    }
    Ok(parts)
}

/// Reads the pieces of a file.
struct Reader<'j, 'a> {
    job: &'j Job<'a>,
    encoding: Encoding,
}

impl<'a> Reader<'_, 'a> {
    /// The arrays of so many points or cells of a piece.
    fn data(&self, piece: &Element, name: &str, count: u64) -> Result<Vec<Array<'a>>, ReadError> {
        let Some(data) = piece.child(name) else { return Ok(Vec::new()) };
        let mut arrays = Vec::new();
        for element in data.children_named("DataArray") {
            // Of several times the first one.
            if element.attribute("TimeStep").is_some_and(|t| t.trim() != "0") {
                continue;
            }
            let kind = arrays::kind(self.job, element)?;
            // Of nothing there may be any number of bits.
            if kind == Type::Text || (kind == Type::Bits && count == 0) {
                continue;
            }
            let components = match element.attribute("NumberOfComponents").map(|n| n.trim().parse::<u32>()) {
                None => 1,
                Some(Ok(n)) if (1..=1 << 16).contains(&n) => n as usize,
                _ => {
                    let place = self.job.line(element.at);
                    let found = format!("{:?}", element.attribute("NumberOfComponents").unwrap_or_default());
                    return Err(self.job.malformed(place, "NumberOfComponents from 1 to 65536", found));
                }
            };
            let numbers = match kind {
                Type::Numbers(scalar) => arrays::numbers(self.job, &self.encoding, element, scalar)?,
                _ => {
                    let bits = count.saturating_mul(components as u64);
                    arrays::bits(self.job, &self.encoding, element, bits)?
                }
            };
            let name = element.attribute("Name").unwrap_or("unnamed").to_owned();
            let is = |role: &str| data.attribute(role) == Some(&name);
            let r#use = if is("Normals") && components == 3 {
                Use::Normals
            } else if is("TCoords") && components >= 2 {
                Use::Texcoords
            } else if is("Scalars") && kind == Type::Numbers(Scalar::U8) && matches!(components, 3 | 4) {
                Use::Colors
            } else {
                match kind {
                    Type::Numbers(scalar) => Use::of(&name, components, scalar),
                    _ => Use::Attribute,
                }
            };
            let own =
                |k: usize| element.attribute(&format!("ComponentName{k}")).unwrap_or_default().to_owned();
            let mut names: Vec<String> = (0..components.min(MOST_NAMED)).map(own).collect();
            if names.iter().all(String::is_empty) {
                names.clear();
            }
            arrays.push(Array { name, components, numbers, r#use, names });
        }
        Ok(arrays)
    }

    fn piece(&self, kind: &str, data: &Element, piece: &Element) -> Result<Option<DataSet<'a>>, ReadError> {
        let Some((points, cells)) = self.geometry(kind, data, piece)? else { return Ok(None) };
        let point_data = self.data(piece, "PointData", points.count())?;
        let mut cell_data = self.data(piece, "CellData", cells.count())?;
        for array in &mut cell_data {
            if array.r#use != Use::Colors {
                array.r#use = Use::Attribute;
            }
        }
        // Arrays of what there is nothing of may be left out or hold anything.
        let keep = |count: u64, arrays: Vec<Array<'a>>| if count == 0 { Vec::new() } else { arrays };
        let (point_data, cell_data) =
            (keep(points.count(), point_data), keep(Cells::count(&cells), cell_data));
        Ok(Some(DataSet { points, cells, beside: Vec::new(), point_data, cell_data }))
    }
}
