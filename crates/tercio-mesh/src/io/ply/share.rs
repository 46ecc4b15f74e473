//! Ranges of the faces of a binary PLY file, with the vertices that they use.

use std::fmt::Write as _;
use std::ops::Range;

use crate::loops::prelude::*;

use super::binary::{Binary, number};
use super::header::{Element, Encoding, Header, Scalar, Shape};
use super::layout::{self, BLOCK, Layout};
use super::plan::{self, INDEX_LISTS};
use super::{Start, malformed, start};
use crate::ReadError;
use crate::error::{Place, expected_vertex};
use crate::io::ReadOptions;
use crate::io::input::Input;
use crate::io::share::refusal;
use crate::normals::members::Members;

/// The faces of a file that has one element of vertices, and one of faces behind it.
pub(in crate::io) struct Faces<'a> {
    input: &'a Input,
    header: Header,
    /// From the line "ply" on.
    bytes: &'a [u8],
    big: bool,
    /// Bytes of a vertex.
    vertex: usize,
    /// Offset of the first face.
    first: usize,
    /// Index of the list of vertex numbers among the properties of a face.
    corners: usize,
}

impl<'a> Faces<'a> {
    /// Reads the header.
    pub fn open(input: &'a Input) -> Result<Self, ReadError> {
        let Start { at, .. } = start(input).unwrap_or(Start { at: 0, lines: 0, warning: None });
        let bytes = input.bytes().get(at..).unwrap_or_default();
        let header = super::header::parse(input, bytes)?;
        let big = match header.encoding {
            Encoding::Ascii => return Err(refusal(input, "an ASCII PLY file")),
            Encoding::LittleEndian => false,
            Encoding::BigEndian => true,
        };
        plan::make(&input.name, &header, bytes, &mut Vec::new())?;
        let [vertices, faces] = &header.elements[..] else {
            return Err(refusal(input, "a PLY file with other elements than vertices and faces"));
        };
        if vertices.name != "vertex" || faces.name != "face" {
            return Err(refusal(input, "a PLY file whose elements are not vertices, then faces"));
        }
        if faces.list(&["texcoord"]).is_some() {
            return Err(refusal(input, "a PLY file with texture coordinates at the corners of faces"));
        }
        let size = |p: &super::header::Property| match p.shape {
            Shape::One(scalar) => Some(scalar.size()),
            Shape::List { .. } => None,
        };
        let vertex = vertices.properties.iter().map(size).sum::<Option<usize>>();
        let Some(vertex) = vertex else {
            return Err(refusal(input, "a PLY file with lists at vertices"));
        };
        let Some(corners) = faces.list(&INDEX_LISTS) else {
            return Err(refusal(input, "a PLY file without faces"));
        };
        let first =
            vertex.checked_mul(vertices.count as usize).and_then(|size| size.checked_add(header.body));
        let first = first.filter(|&first| first <= bytes.len()).ok_or_else(|| {
            let expected = format!("{} vertices of {vertex} bytes", vertices.count);
            let found = format!("{} bytes", bytes.len() - header.body);
            malformed(&input.name, Place::Byte((at + header.body) as u64), expected, found)
        })?;
        Ok(Self { input, bytes, big, vertex, first, corners, header })
    }

    fn element(&self) -> &Element {
        &self.header.elements[1]
    }

    /// Faces of the file.
    pub fn count(&self) -> usize {
        self.element().count as usize
    }

    /// Vertices of the file.
    pub fn vertices(&self) -> usize {
        self.header.elements[0].count as usize
    }

    fn binary(&self) -> Binary<'_> {
        Binary { input: self.input, file: &self.input.name, bytes: self.bytes, big: self.big }
    }

    /// The layout of the first face, and its bytes.
    fn layout_of_first(&self) -> Option<(Vec<usize>, usize)> {
        match layout::uniform(&self.binary(), self.element(), 1, self.first)? {
            (Layout::Uniform { lengths, .. }, stride) => Some((lengths, stride)),
            _ => None,
        }
    }

    /// Do faces take as many bytes as the first one, with lists of the same lengths?
    pub fn is_uniform(&self, range: &Range<usize>) -> bool {
        if range.is_empty() {
            return true;
        }
        let Some((lengths, stride)) = self.layout_of_first() else { return false };
        let Some(at) = stride.checked_mul(range.start).and_then(|at| at.checked_add(self.first)) else {
            return false;
        };
        if at > self.bytes.len() {
            return false;
        }
        match layout::uniform(&self.binary(), self.element(), range.len(), at) {
            Some((Layout::Uniform { lengths: own, .. }, of_own)) => {
                let end = of_own.checked_mul(range.len()).and_then(|size| size.checked_add(at));
                own == lengths && of_own == stride && end.is_some_and(|end| end <= self.bytes.len())
            }
            _ => false,
        }
    }

    /// A file of some faces and their vertices, and the numbers of these vertices.
    pub fn take(
        &self,
        range: &Range<usize>,
        is_uniform: bool,
        options: &ReadOptions,
    ) -> Result<(Vec<u8>, Vec<u32>), ReadError> {
        let place = self.place(range, is_uniform)?;
        let rows = &self.bytes[place.clone()];
        let members = Members::new(self.vertices(), self.corners_of(rows, range, place.start)?.into_iter());
        let vertices = members.list();
        let bytes = rows.len() + vertices.len() * self.vertex;
        options.check_memory(&self.input.name, "a part of the mesh", 2 * bytes as u64)?;
        let mut out = self.head(vertices.len(), range.len()).into_bytes();
        out.reserve_exact(bytes);
        for &v in &vertices {
            let at = self.header.body + v as usize * self.vertex;
            out.extend_from_slice(&self.bytes[at..at + self.vertex]);
        }
        let first = out.len();
        out.extend_from_slice(rows);
        self.input.consumed(bytes);
        self.renumber(&mut out[first..], &members);
        Ok((out, vertices))
    }

    /// A file of some vertices without faces.
    pub fn vertex_rows(&self, range: Range<usize>, options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
        let rows = &self.bytes[self.header.body..self.first];
        let rows = &rows[range.start * self.vertex..range.end * self.vertex];
        options.check_memory(&self.input.name, "a part of the vertices", 2 * rows.len() as u64)?;
        self.input.consumed(rows.len());
        Ok([self.head(range.len(), 0).as_bytes(), rows].concat())
    }

    /// Offsets of the first byte of some faces and of the one behind.
    fn place(&self, range: &Range<usize>, is_uniform: bool) -> Result<Range<usize>, ReadError> {
        if is_uniform {
            let stride = self.layout_of_first().map_or(0, |(_, stride)| stride);
            return Ok(self.first + stride * range.start..self.first + stride * range.end);
        }
        let element = self.element();
        let (layout, end) = layout::find(&self.binary(), element, self.count(), self.first)?;
        let at = |row: usize| match &layout {
            _ if row == self.count() => end,
            Layout::Uniform { stride, .. } => self.first + row * stride,
            Layout::Ragged { starts } => {
                (0..row % BLOCK).fold(starts[row / BLOCK], |at, _| at + self.bytes_of(at))
            }
        };
        Ok(at(range.start)..at(range.end))
    }

    /// Bytes of the face at an offset; its lengths are known to be valid.
    fn bytes_of(&self, at: usize) -> usize {
        let mut bytes = 0;
        self.walk(&self.bytes[at..], |_, size| bytes += size);
        bytes
    }

    /// Calls `visit` with the index and bytes of each property of the face at the front of `row`, in order.
    #[inline]
    fn walk(&self, row: &[u8], mut visit: impl FnMut(usize, usize)) {
        let mut at = 0;
        for (index, property) in self.element().properties.iter().enumerate() {
            let size = match property.shape {
                Shape::One(scalar) => scalar.size(),
                Shape::List { count, item } => {
                    let length = row.get(at..).and_then(|rest| number(count, self.big, rest)).unwrap_or(0.0);
                    count.size() + length as usize * item.size()
                }
            };
            visit(index, size);
            at += size;
        }
    }

    /// Offset in `row` of the list of corners, its count, and bytes of the whole face.
    #[inline]
    fn list_of(&self, row: &[u8]) -> (usize, usize, usize) {
        let (mut at, mut list, mut size_of_list) = (0, 0, 0);
        self.walk(row, |index, size| {
            if index == self.corners {
                (list, size_of_list) = (at, size);
            }
            at += size;
        });
        let (count, item) = self.scalars();
        (list + count.size(), (size_of_list - count.size()) / item.size(), at)
    }

    /// Types of the count and the items of the list of corners.
    fn scalars(&self) -> (Scalar, Scalar) {
        match self.element().properties[self.corners].shape {
            Shape::List { count, item } => (count, item),
            Shape::One(scalar) => (scalar, scalar),
        }
    }

    /// The vertices of all corners of some faces.
    fn corners_of(&self, rows: &[u8], range: &Range<usize>, place: usize) -> Result<Vec<u32>, ReadError> {
        let (_, item) = self.scalars();
        let (mut all, mut at) = (Vec::with_capacity(3 * range.len()), 0);
        while at < rows.len() {
            let (list, count, size) = self.list_of(&rows[at..]);
            for k in 0..count {
                let offset = at + list + k * item.size();
                let value = rows.get(offset..).and_then(|bytes| number(item, self.big, bytes));
                let vertex = value.map_or(u32::MAX, |value| value as u32);
                // The cast saturates: what is not the number of a vertex does not compare equal.
                if value != Some(f64::from(vertex)) || vertex as usize >= self.vertices() {
                    let found = value.map_or("nothing".into(), |value| value.to_string());
                    let byte = Place::Byte((place + offset) as u64);
                    let expected = expected_vertex(self.vertices() as u64);
                    return Err(malformed(&self.input.name, byte, expected, found));
                }
                all.push(vertex);
            }
            at += size;
        }
        Ok(all)
    }

    /// Gives the corners of faces the ranks of their vertices among the members.
    fn renumber(&self, rows: &mut [u8], members: &Members) {
        let (_, item) = self.scalars();
        let big = self.big;
        let write = |bytes: &mut [u8], vertex: u32| {
            macro_rules! store {
                ($t:ty) => {{
                    let value = vertex as $t;
                    bytes.copy_from_slice(&if big { value.to_be_bytes() } else { value.to_le_bytes() });
                }};
            }
            match item {
                Scalar::I8 => store!(i8),
                Scalar::U8 => store!(u8),
                Scalar::I16 => store!(i16),
                Scalar::U16 => store!(u16),
                Scalar::I32 => store!(i32),
                Scalar::U32 => store!(u32),
                Scalar::F32 => store!(f32),
                Scalar::F64 => store!(f64),
            }
        };
        let one = |row: &mut [u8]| {
            let (list, count, size) = self.list_of(row);
            for item_bytes in row[list..list + count * item.size()].chunks_exact_mut(item.size()) {
                if let Some(vertex) = number(item, big, item_bytes) {
                    write(item_bytes, members.rank(vertex as u32));
                }
            }
            size
        };
        let stride = self.layout_of_first().map_or(0, |(_, stride)| stride);
        let all_alike = stride > 0
            && rows.len().is_multiple_of(stride)
            && rows.chunks_exact(stride).all(|row| self.list_of(row).2 == stride);
        if all_alike {
            rows.par_chunks_mut(stride * BLOCK).for_each(|rows| {
                rows.chunks_exact_mut(stride).for_each(|row| {
                    one(row);
                });
            });
            return;
        }
        let mut at = 0;
        while at < rows.len() {
            at += one(&mut rows[at..]);
        }
    }

    /// A header for so many vertices and faces.
    fn head(&self, vertices: usize, faces: usize) -> String {
        let mut head = String::from("ply\n");
        let format = if self.big { "binary_big_endian" } else { "binary_little_endian" };
        // Writing to a string does not fail.
        let _ = writeln!(head, "format {format} 1.0");
        for texture in &self.header.textures {
            let _ = writeln!(head, "comment TextureFile {texture}");
        }
        for (element, count) in self.header.elements.iter().zip([vertices, faces]) {
            let _ = writeln!(head, "element {} {count}", element.name);
            for property in &element.properties {
                let _ = match property.shape {
                    Shape::One(scalar) => writeln!(head, "property {} {}", scalar.name(), property.name),
                    Shape::List { count, item } => {
                        writeln!(head, "property list {} {} {}", count.name(), item.name(), property.name)
                    }
                };
            }
        }
        head + "end_header\n"
    }
}
