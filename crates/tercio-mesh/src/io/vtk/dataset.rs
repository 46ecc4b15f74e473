//! What a VTK file holds, in the terms of VTK: points, cells, and arrays of both.

use std::collections::HashSet;
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

use super::extents::{Extents, Range3};
use super::numbers::{Numbers, Scalar};
use crate::ReadError;
use crate::error::Place;
use crate::io::{ReadOptions, input::Input};

/// One file that is read.
pub struct Job<'a> {
    pub input: &'a Input,
    pub options: &'a ReadOptions<'a>,
    /// The extents of all pieces of a grid, if this is the file of one of them.
    pub extents: Arc<Extents>,
    /// Bytes of memory taken.
    held: AtomicU64,
    warnings: Mutex<Warnings>,
    /// A byte of the file, and how many lines end before it: see [`Job::line`].
    counted: Mutex<(usize, u64)>,
}

/// Different warnings, up to [`MOST_WARNINGS`], and how many more there were.
#[derive(Default)]
struct Warnings {
    first: Vec<String>,
    /// Hashes of all of them.
    known: HashSet<u64>,
}

/// An array each could have one.
const MOST_WARNINGS: usize = 64;

impl<'a> Job<'a> {
    pub fn new(input: &'a Input, options: &'a ReadOptions<'a>) -> Self {
        let held = AtomicU64::new(input.held_bytes());
        let (warnings, counted) = (Mutex::default(), Mutex::default());
        Self { input, options, extents: Arc::default(), held, warnings, counted }
    }

    pub fn file(&self) -> &'a str {
        &self.input.name
    }

    /// Checks the memory limit before memory is taken.
    pub fn reserve(&self, what: &str, bytes: u64) -> Result<(), ReadError> {
        let needed = self.held.load(Relaxed).saturating_add(bytes);
        self.options.check_memory(self.file(), what, needed)?;
        self.held.store(needed, Relaxed);
        Ok(())
    }

    /// All of the file will be in memory at once.
    pub fn count_all(&self) -> Result<(), ReadError> {
        let before = self.input.held_bytes();
        self.input.count_all();
        self.reserve("the file", self.input.held_bytes().saturating_sub(before))
    }

    pub fn warn(&self, warning: String) {
        if let Ok(mut warnings) = self.warnings.lock()
            && warnings.known.insert(BuildHasherDefault::<DefaultHasher>::default().hash_one(&warning))
            && warnings.first.len() < MOST_WARNINGS
        {
            warnings.first.push(warning);
        }
    }

    pub fn into_warnings(self) -> Vec<String> {
        let Warnings { first: mut warnings, known } = self.warnings.into_inner().unwrap_or_default();
        let more = known.len() - warnings.len();
        if more > 0 {
            warnings.push(format!("{more} more warnings of this kind"));
        }
        warnings
    }

    /// The line with a byte of the file. Lines are counted from the byte that was asked for before: arrays, of which there may be many,
    /// ask one after the other.
    pub fn line(&self, at: usize) -> Place {
        let bytes = self.input.bytes();
        let at = at.min(bytes.len());
        let ends = |from: usize, to: usize| {
            let between = bytes.get(from..to).unwrap_or_default();
            between.iter().filter(|&&b| b == b'\n').count() as u64
        };
        let mut last = self.counted.lock().unwrap_or_else(PoisonError::into_inner);
        let (before, lines) = *last;
        let lines = if at < before { lines - ends(at, before) } else { lines + ends(before, at) };
        *last = (at, lines);
        Place::Line(1 + lines)
    }

    pub fn begin(&self, stage: &'static str, total: u64) {
        if let Some(progress) = self.options.progress {
            progress.begin(stage, total);
        }
    }

    pub fn advance(&self, units: u64) {
        if let Some(progress) = self.options.progress {
            progress.advance(units);
        }
    }

    #[cold]
    pub fn malformed(
        &self,
        place: Place,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> ReadError {
        ReadError::Malformed {
            file: self.file().into(),
            place,
            expected: expected.into(),
            found: found.into(),
        }
    }

    #[cold]
    pub fn unsupported(&self, place: Place, what: impl Into<String>) -> ReadError {
        ReadError::Unsupported { file: self.file().into(), place, what: what.into() }
    }
}

/// What an array is for, besides being an attribute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    Attribute,
    Normals,
    Texcoords,
    /// Components of 0 to 255 if they are whole, 0 to 1 otherwise.
    Colors,
}

impl Use {
    /// What an array of points or cells is for, by its name and type.
    pub fn of(name: &str, components: usize, scalar: Scalar) -> Self {
        let is = |names: &[&str]| names.iter().any(|n| name.eq_ignore_ascii_case(n));
        if components == 3 && scalar.is_real() && is(&["normals", "normal"]) {
            Self::Normals
        } else if scalar == Scalar::U8
            && matches!(components, 3 | 4)
            && is(&["rgb", "rgba", "color", "colors"])
        {
            Self::Colors
        } else {
            Self::Attribute
        }
    }
}

/// An array of points or cells.
pub struct Array<'a> {
    pub name: String,
    pub components: usize,
    pub numbers: Numbers<'a>,
    pub r#use: Use,
    /// What the file calls the components; none if it does not, and empty names for those without.
    pub names: Vec<String>,
}

impl Array<'_> {
    /// What the file calls a component.
    pub fn component(&self, number: usize) -> Option<&str> {
        self.names.get(number).map(String::as_str).filter(|name| !name.is_empty())
    }

    pub fn tuples(&self) -> u64 {
        (self.numbers.len() / self.components.max(1)) as u64
    }
}

/// Where the points are.
pub enum Points<'a> {
    Listed(Numbers<'a>),
    /// Columns of the matrix from numbers along the axes to coordinates, and the first point.
    Uniform {
        axes: [[f64; 3]; 3],
        first: [f64; 3],
        from: [i64; 3],
        dims: [u64; 3],
    },
    Rectilinear {
        axes: [Numbers<'a>; 3],
    },
}

impl Points<'_> {
    pub fn count(&self) -> u64 {
        match self {
            Self::Listed(numbers) => (numbers.len() / 3) as u64,
            Self::Uniform { dims, .. } => dims.iter().fold(1, |n: u64, &d| n.saturating_mul(d)),
            Self::Rectilinear { axes } => axes.iter().fold(1, |n: u64, a| n.saturating_mul(a.len() as u64)),
        }
    }

    /// A point in file coordinates.
    pub fn get(&self, point: u32) -> [f64; 3] {
        let point = point as usize;
        let split =
            |x: usize, y: usize| [point % x.max(1), point / x.max(1) % y.max(1), point / (x * y).max(1)];
        match self {
            Self::Listed(numbers) => [0, 1, 2].map(|k| numbers.double(3 * point + k)),
            Self::Uniform { axes, first, from, dims } => {
                let ijk = split(dims[0] as usize, dims[1] as usize);
                let along = [0, 1, 2].map(|k| from[k] as f64 + ijk[k] as f64);
                [0, 1, 2]
                    .map(|c| first[c] + axes[0][c] * along[0] + axes[1][c] * along[1] + axes[2][c] * along[2])
            }
            Self::Rectilinear { axes } => {
                let ijk = split(axes[0].len(), axes[1].len());
                [0, 1, 2].map(|k| axes[k].double(ijk[k]))
            }
        }
    }
}

/// The points of each of several cells.
#[derive(Default)]
pub struct CellList {
    pub ends: Ends,
    pub connectivity: Vec<u32>,
}

/// Where cells end in a list.
pub enum Ends {
    /// All have as many points.
    Uniform {
        corners: usize,
        cells: usize,
    },
    Each(Vec<u64>),
}

impl Default for Ends {
    fn default() -> Self {
        Self::Uniform { corners: 0, cells: 0 }
    }
}

impl CellList {
    pub fn len(&self) -> usize {
        match &self.ends {
            Ends::Uniform { cells, .. } => *cells,
            Ends::Each(ends) => ends.len(),
        }
    }

    pub fn range(&self, cell: usize) -> Range<usize> {
        match &self.ends {
            Ends::Uniform { corners, .. } => cell * corners..(cell + 1) * corners,
            Ends::Each(ends) => {
                let end = |i: usize| ends.get(i).map_or(0, |&e| e as usize);
                cell.checked_sub(1).map_or(0, end)..end(cell)
            }
        }
    }

    pub fn get(&self, cell: usize) -> &[u32] {
        self.connectivity.get(self.range(cell)).unwrap_or_default()
    }
}

/// Cells of a data set.
pub enum Cells {
    /// Of polygonal data: points, lines, polygons and strips, numbered in this order.
    Poly([CellList; 4]),
    Unstructured {
        types: Vec<u8>,
        list: CellList,
        /// The faces of polyhedra: their number, then each as its number of points, and these.
        polyhedra: CellList,
    },
    /// Of a grid with so many points along its axes.
    Structured([u64; 3]),
}

/// One data set.
pub struct DataSet<'a> {
    pub points: Points<'a>,
    pub cells: Cells,
    /// Cells of the same grid in other pieces, in numbers that count from the first cell of this one: what they touch is not
    /// outside.
    pub beside: Vec<Range3>,
    pub point_data: Vec<Array<'a>>,
    pub cell_data: Vec<Array<'a>>,
}

impl Cells {
    /// Number of cells; saturates.
    pub fn count(&self) -> u64 {
        match self {
            Self::Poly(lists) => lists.iter().map(|l| l.len() as u64).sum(),
            Self::Unstructured { types, .. } => types.len() as u64,
            Self::Structured(dims) => {
                dims.iter().fold(1, |n: u64, &d| n.saturating_mul(if d > 1 { d - 1 } else { d }))
            }
        }
    }
}

/// Names of arrays that say which cells and points are ghosts.
pub const GHOSTS: [&str; 2] = ["vtkGhostType", "vtkGhostLevels"];

impl<'a> Array<'a> {
    /// The array of this name whose numbers say which cells are ghosts.
    pub fn ghosts<'b>(arrays: &'b [Array<'a>]) -> Option<&'b Array<'a>> {
        arrays.iter().find(|a| GHOSTS.contains(&a.name.as_str()) && a.components == 1)
    }
}
