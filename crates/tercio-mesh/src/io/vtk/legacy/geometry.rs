//! Points and cells.

use super::Parser;
use super::arrays::Type;
use crate::ReadError;
use crate::error::Place;
use crate::io::vtk::build;
use crate::io::vtk::dataset::{CellList, Cells, Job, Points};
use crate::io::vtk::numbers::{Numbers, Scalar};

/// What was read of the geometry.
#[derive(Default)]
pub struct Geometry<'a> {
    kind: Option<Kind>,
    points: Option<Numbers<'a>>,
    /// VERTICES, LINES, POLYGONS, TRIANGLE_STRIPS, and CELLS.
    lists: [Option<List<'a>>; 5],
    types: Option<Numbers<'a>>,
    dims: Option<[u64; 3]>,
    first: Option<[f64; 3]>,
    spacing: Option<[f64; 3]>,
    axes: [Option<Numbers<'a>>; 3],
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    PolyData,
    UnstructuredGrid,
    StructuredGrid,
    StructuredPoints,
    RectilinearGrid,
}

/// A list of cells as in the file.
enum List<'a> {
    Counted { cells: u64, numbers: Numbers<'a> },
    Offsets { offsets: Numbers<'a>, connectivity: Numbers<'a> },
}

const LISTS: [&str; 5] = ["VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS", "CELLS"];

impl<'a> Geometry<'a> {
    /// The kind of data set, for the report.
    pub fn kind(&self) -> &'static str {
        match self.kind {
            Some(Kind::PolyData) => "polygonal data",
            Some(Kind::UnstructuredGrid) => "unstructured grid",
            Some(Kind::StructuredGrid) => "structured grid",
            Some(Kind::StructuredPoints) => "structured points",
            Some(Kind::RectilinearGrid) => "rectilinear grid",
            None => "no data set",
        }
    }

    /// Reads what follows a keyword, if it is one of the geometry.
    pub fn read(&mut self, parser: &mut Parser<'_, 'a>, keyword: &str) -> Result<bool, ReadError> {
        if keyword != "DATASET" && self.kind.is_none() {
            parser.cursor = parser.keyword_start(keyword);
            return Err(parser.expected("DATASET and the kind of data set"));
        }
        match keyword {
            "DATASET" => self.kind = Some(kind(parser)?),
            "POINTS" => {
                let count = parser.count("the number of points")?;
                let kind = parser.scalar_type()?;
                self.points = Some(parser.numbers("the points", count.saturating_mul(3), kind)?);
            }
            "DIMENSIONS" => {
                let mut next = || parser.count("a number of points along an axis");
                self.dims = Some([next()?, next()?, next()?]);
            }
            "ORIGIN" => {
                let mut next = || parser.float("a coordinate of the origin");
                self.first = Some([next()?, next()?, next()?]);
            }
            "SPACING" | "ASPECT_RATIO" => {
                let mut next = || parser.float("a distance of points");
                self.spacing = Some([next()?, next()?, next()?]);
            }
            "X_COORDINATES" | "Y_COORDINATES" | "Z_COORDINATES" => {
                let count = parser.count("the number of coordinates")?;
                let kind = parser.scalar_type()?;
                let axis = usize::from(keyword.as_bytes()[0] - b'X');
                self.axes[axis] = Some(parser.numbers("the coordinates along an axis", count, kind)?);
            }
            "CELL_TYPES" => {
                let count = parser.count("the number of types")?;
                let kind = Type::Numbers(Scalar::I32);
                self.types = Some(parser.numbers("the types of cells", count, kind)?);
            }
            _ => match LISTS.iter().position(|list| *list == keyword) {
                Some(which) => self.lists[which] = Some(list(parser, LISTS[which])?),
                None => return Ok(false),
            },
        }
        Ok(true)
    }

    /// Checks and converts it.
    pub fn finish(self, parser: &Parser<'_, 'a>) -> Result<(Points<'a>, Cells), ReadError> {
        let job = parser.job;
        let Some(kind) = self.kind else { return Err(parser.expected("DATASET and the kind of data set")) };
        let missing = |what: &str| job.malformed(parser.place(), what, "the end of the file");
        let points = self.points.map(Points::Listed);
        let dims = || self.dims.ok_or_else(|| missing("DIMENSIONS before the end"));
        let [verts, lines, polygons, strips, cells] = self.lists;
        match kind {
            Kind::PolyData => {
                let lists = [verts, lines, polygons, strips];
                let count = points.as_ref().map_or(0, Points::count);
                let mut built: [CellList; 4] = Default::default();
                for ((to, list), what) in built.iter_mut().zip(lists).zip(LISTS) {
                    if let Some(list) = list {
                        *to = list.build(job, what, count)?;
                    }
                }
                Ok((points.ok_or_else(|| missing("POINTS before the end"))?, Cells::Poly(built)))
            }
            Kind::UnstructuredGrid => {
                let points = points.ok_or_else(|| missing("POINTS before the end"))?;
                let list = cells.ok_or_else(|| missing("CELLS before the end"))?;
                let types = self.types.ok_or_else(|| missing("CELL_TYPES before the end"))?;
                let count = points.count();
                // The list holds the faces of polyhedra, which are no points.
                let limit = if build::has_polyhedra(&types) { u32::MAX.into() } else { count };
                let list = list.build(job, "CELLS", limit)?;
                Ok((points, build::unstructured(job, &types, list, None, count)?))
            }
            Kind::StructuredGrid => {
                let (points, dims) = (points.ok_or_else(|| missing("POINTS before the end"))?, dims()?);
                check_dims(job, dims, points.count())?;
                Ok((points, Cells::Structured(dims)))
            }
            Kind::StructuredPoints => {
                let dims = dims()?;
                let [x, y, z] = self.spacing.unwrap_or([1.0; 3]);
                let axes = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
                let first = self.first.unwrap_or_default();
                Ok((Points::Uniform { axes, first, from: [0; 3], dims }, Cells::Structured(dims)))
            }
            Kind::RectilinearGrid => {
                let dims = dims()?;
                let [Some(x), Some(y), Some(z)] = self.axes else {
                    return Err(missing("X_COORDINATES, Y_COORDINATES and Z_COORDINATES before the end"));
                };
                let points = Points::Rectilinear { axes: [x, y, z] };
                check_dims(job, dims, points.count())?;
                Ok((points, Cells::Structured(dims)))
            }
        }
    }
}

/// Is there a point for every place of a grid?
fn check_dims(job: &Job, dims: [u64; 3], points: u64) -> Result<(), ReadError> {
    if dims.iter().fold(1, |n: u64, &d| n.saturating_mul(d)) == points {
        return Ok(());
    }
    let expected = format!("points for DIMENSIONS {} {} {}", dims[0], dims[1], dims[2]);
    Err(job.malformed(Place::File, expected, format!("{points} points")))
}

fn kind(parser: &mut Parser) -> Result<Kind, ReadError> {
    let before = parser.cursor.clone();
    let word = parser.word("the kind of data set")?.to_ascii_uppercase();
    Ok(match &word[..] {
        b"POLYDATA" => Kind::PolyData,
        b"UNSTRUCTURED_GRID" => Kind::UnstructuredGrid,
        b"STRUCTURED_GRID" => Kind::StructuredGrid,
        b"STRUCTURED_POINTS" | b"IMAGE_DATA" => Kind::StructuredPoints,
        b"RECTILINEAR_GRID" => Kind::RectilinearGrid,
        b"FIELD" | b"TABLE" | b"TREE" | b"DIRECTED_GRAPH" | b"UNDIRECTED_GRAPH" | b"MULTIBLOCK" => {
            let what = format!("VTK's data set {}", String::from_utf8_lossy(&word));
            return Err(parser.job.unsupported(parser.place(), what));
        }
        _ => {
            parser.cursor = before;
            return Err(parser.expected(
                "POLYDATA, UNSTRUCTURED_GRID, STRUCTURED_GRID, STRUCTURED_POINTS or RECTILINEAR_GRID",
            ));
        }
    })
}

fn list<'a>(parser: &mut Parser<'_, 'a>, what: &str) -> Result<List<'a>, ReadError> {
    let cells = parser.count("the number of cells")?;
    let size = parser.count("the size of the list of cells")?;
    if !parser.has_word("OFFSETS") {
        let numbers = parser.numbers(what, size, Type::Numbers(Scalar::I32))?;
        return Ok(List::Counted { cells, numbers });
    }
    let kind = parser.scalar_type()?;
    let offsets = parser.numbers("OFFSETS", cells, kind)?;
    if !parser.has_word("CONNECTIVITY") {
        return Err(parser.expected("CONNECTIVITY"));
    }
    let kind = parser.scalar_type()?;
    let connectivity = parser.numbers("CONNECTIVITY", size, kind)?;
    Ok(List::Offsets { offsets, connectivity })
}

impl List<'_> {
    fn build(&self, job: &Job, what: &str, limit: u64) -> Result<CellList, ReadError> {
        match self {
            List::Counted { cells, numbers } => build::counted_list(job, what, *cells, numbers, limit),
            List::Offsets { offsets, connectivity } => {
                build::offset_list(job, what, offsets, connectivity, true, limit)
            }
        }
    }
}
