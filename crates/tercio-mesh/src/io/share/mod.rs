//! Shares of a model file: each of several ranks reads some of the faces, and no rank reads all of them.
//!
//! Binary PLY and binary STL can be shared. The share of a rank is a range of the file's faces, with the vertices that they
//! use, as a small file of the same format in memory; the usual reader reads that. [`Facts`] are what depends on the whole
//! model.

mod facts;

use std::ops::Range;

use super::input::Input;
use super::{Format, ReadModel, ReadOptions, ply, sniff, stl};
use crate::error::Place;
use crate::{Aabb, ReadError};

pub use facts::Facts;

/// A file whose faces can be shared among ranks.
pub struct Shareable<'a> {
    input: &'a Input,
    kind: Kind<'a>,
}

enum Kind<'a> {
    Ply(ply::share::Faces<'a>),
    Stl(stl::share::Facets<'a>),
}

/// A share of a file.
pub struct Share {
    /// The faces of the share, as a file of their own.
    input: Input,
    format: Format,
    /// The colour of all faces, if it does not follow from them.
    color: Option<[u8; 4]>,
    /// The number in the file of each of its vertices, in ascending order; `None` if the corners of faces are the vertices.
    pub vertices: Option<Vec<u32>>,
}

impl<'a> Shareable<'a> {
    /// Looks at the head of a file.
    ///
    /// # Errors
    /// [`ReadError::Unsupported`] if it cannot be shared, and errors of the head.
    pub fn open(input: &'a Input) -> Result<Self, ReadError> {
        let kind = match sniff(input) {
            Some(Format::Ply) => Kind::Ply(ply::share::Faces::open(input)?),
            Some(Format::Stl) => Kind::Stl(stl::share::Facets::open(input)?),
            Some(Format::Obj) => return Err(refusal(input, "an OBJ file")),
            Some(Format::Off) => return Err(refusal(input, "an OFF file")),
            Some(Format::Vtk | Format::VtkXml) => return Err(refusal(input, "a VTK file")),
            Some(Format::Pcd) => return Err(refusal(input, "a PCD file")),
            Some(Format::Las) => return Err(refusal(input, "a LAS file")),
            Some(Format::Xyz) => return Err(refusal(input, "a point cloud as text")),
            None => return Err(sniff::refusal(input)),
        };
        Ok(Self { input, kind })
    }

    /// Faces of the file, of any number of corners.
    pub fn faces(&self) -> u64 {
        match &self.kind {
            Kind::Ply(faces) => faces.count() as u64,
            Kind::Stl(facets) => facets.count() as u64,
        }
    }

    /// Vertices of the file, used or not.
    pub fn vertices(&self) -> u64 {
        match &self.kind {
            Kind::Ply(faces) => faces.vertices() as u64,
            Kind::Stl(facets) => 3 * facets.count() as u64,
        }
    }

    /// The faces of one of `of` shares.
    ///
    /// # Panics
    /// If there is no such share.
    pub fn range(&self, number: usize, of: usize) -> Range<usize> {
        assert!(number < of, "a share of {of}");
        let at = |k: usize| (u128::from(self.faces()) * k as u128 / of as u128) as usize;
        at(number)..at(number + 1)
    }

    /// Do these faces take as many bytes each as the first one of the file? If it is so for all shares, their places are known
    /// without reading what is before them.
    pub fn is_uniform(&self, range: &Range<usize>) -> bool {
        match &self.kind {
            Kind::Ply(faces) => faces.is_uniform(range),
            Kind::Stl(_) => true,
        }
    }

    /// What these faces say of the attributes that only the whole file explains; the bits of all shares are to be combined
    /// with *and*.
    pub fn marks(&self, range: &Range<usize>) -> u64 {
        match &self.kind {
            Kind::Ply(_) => 0,
            Kind::Stl(facets) => facets.marks(range),
        }
    }

    /// A share. `is_uniform` and `marks` are those of all shares together.
    ///
    /// # Errors
    /// Too little memory, or faces that are not valid.
    pub fn take(
        &self,
        range: &Range<usize>,
        is_uniform: bool,
        marks: u64,
        options: &ReadOptions,
    ) -> Result<Share, ReadError> {
        match &self.kind {
            Kind::Ply(faces) => {
                let (bytes, vertices) = faces.take(range, is_uniform, options)?;
                let (input, vertices) = (self.part(bytes, options)?, Some(vertices));
                Ok(Share { input, format: Format::Ply, color: None, vertices })
            }
            Kind::Stl(facets) => {
                let input = self.part(facets.take(range, marks, options)?, options)?;
                let color = facets.plain_color(range, marks);
                Ok(Share { input, format: Format::Stl, color, vertices: None })
            }
        }
    }

    /// Bounds, in file coordinates, of one of `of` ranges of the file's vertices, used or not; of STL, all vertices are used,
    /// and this is empty.
    ///
    /// # Errors
    /// Too little memory.
    pub fn coordinates(&self, number: usize, of: usize, options: &ReadOptions) -> Result<Aabb, ReadError> {
        let Kind::Ply(faces) = &self.kind else { return Ok(Aabb::EMPTY) };
        let at = |k: usize| (faces.vertices() as u128 * k as u128 / of as u128) as usize;
        let input = self.part(faces.vertex_rows(at(number)..at(number + 1), options)?, options)?;
        Ok(ply::read(&input, &ReadOptions { progress: None, ..*options })?.coordinates)
    }

    fn part(&self, bytes: Vec<u8>, options: &ReadOptions) -> Result<Input, ReadError> {
        let mut part = Input::from_bytes(&self.input.name, bytes, options)?;
        part.base.clone_from(&self.input.base);
        part.file_bytes = self.input.file_bytes;
        Ok(part)
    }
}

impl Share {
    /// Reads the faces of the share; [`Facts::settle`] is left to the caller.
    ///
    /// # Errors
    /// Any [`ReadError`].
    pub fn read(&self, options: &ReadOptions) -> Result<ReadModel, ReadError> {
        let mut model = match self.format {
            Format::Ply => ply::read(&self.input, options),
            // What a part holds may not be evidence of its format.
            _ => stl::share::read(&self.input, options),
        }?;
        model.report.file_bytes = self.input.file_bytes;
        if let Some(color) = self.color {
            model.mesh.face_colors = Some(vec![color; model.mesh.triangles.len()]);
        }
        Ok(model)
    }
}

/// The error for a file that cannot be shared.
pub(super) fn refusal(input: &Input, what: &str) -> ReadError {
    let what = format!(
        "reading {what} in parts (as binary PLY, binary STL and what tercio prepare writes can be read)"
    );
    ReadError::Unsupported { file: input.name.clone(), place: Place::File, what }
}

#[cfg(test)]
mod tests;
