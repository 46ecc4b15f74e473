//! Reading: everything is verified before anything is used.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::AnyBitPattern;
use glam::DVec3;
use memmap2::Mmap;

use super::check;
use super::format::{ALIGNMENT, Description, Header, Kind, MAGIC, Part, VERSION};
use crate::ReadError;
use crate::checksum;
use crate::cluster::{Buffer, ClusteredMesh, Whole};
use crate::error::{Place, printable};
use crate::io::ReadOptions;
use crate::io::input::Input;

/// A mesh from a file, and the information that the program that made the file stored with it.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The mesh.
    pub mesh: ClusteredMesh,
    /// The `about` bytes given to [`super::write`].
    pub about: Vec<u8>,
}

/// Does a file begin like a prepared model?
pub fn is_prepared(bytes: &[u8]) -> bool {
    // Also true if line ends were changed, so that the error can say so.
    bytes.starts_with(&MAGIC[..7])
}

/// Reads a prepared model. From a mapped file nothing is copied: the mesh keeps the map, and its pages do not count
/// as memory taken. Other content is copied.
///
/// # Errors
/// A file that is not a prepared model of this version, that was shortened or altered, or whose copy would exceed the
/// memory limit.
pub fn read(input: &Input, options: &ReadOptions) -> Result<Prepared, ReadError> {
    let all = Parts::open(input, options)?;
    let hashes = all.hashes(0, 1);
    Ok(all.take(0, 1, &hashes)?.0)
}

/// A prepared model of which several ranks read a part each. All bytes are verified: those of the clusters once by all ranks
/// together, everything else by each.
pub struct Parts<'a> {
    input: &'a Input,
    file: File<'a>,
    header: Header,
    parts: Vec<Range<usize>>,
    mesh: ClusteredMesh,
}

impl<'a> Parts<'a> {
    /// Reads and verifies everything but the clusters.
    ///
    /// # Errors
    /// As [`read`].
    pub fn open(input: &'a Input, options: &ReadOptions) -> Result<Self, ReadError> {
        let file = File { name: &input.name, bytes: input.bytes(), map: input.map() };
        if file.map.is_none() {
            let copied = file.bytes.len() as u64;
            options.check_memory(file.name, "the prepared model and its copy", 2 * copied)?;
        }
        let header = file.header()?;
        let parts = file.parts(&header)?;
        for kind in Kind::ALL.into_iter().filter(|kind| *kind != Kind::Lines) {
            let part = &header.parts[kind as usize];
            if !checksum::matches(&file.bytes[parts[kind as usize].clone()], part.checksum) {
                return Err(file.altered(kind, part));
            }
        }
        let part = |kind: Kind| &parts[kind as usize];
        let description: Description = serde_json::from_slice(&file.bytes[part(Kind::Description).clone()])
            .map_err(|error| {
            let at = header.parts[Kind::Description as usize].offset;
            file.broken(at, "a description of the mesh", error)
        })?;
        let faces: Buffer<u32> = file.array(part(Kind::Faces), Kind::Faces)?;
        let mut mesh = ClusteredMesh {
            origin: DVec3::from_array(description.origin),
            exponent: description.exponent,
            materials: description.materials,
            layout: description.layout,
            clusters: file.array(part(Kind::Heads), Kind::Heads)?,
            starts: file.array(part(Kind::Starts), Kind::Starts)?,
            face_of_triangle: (!faces.is_empty()).then_some(faces),
            lines: file.array(part(Kind::Lines), Kind::Lines)?,
            ..ClusteredMesh::default()
        };
        check::sizes(&mesh).map_err(|wrong| file.wrong(&header, wrong))?;
        mesh.sum_up();
        Ok(Self { input, file, header, parts, mesh })
    }

    /// The hashes of the clusters' bytes that one of `of` ranks verifies; those of all ranks, in order, are what
    /// [`Parts::take`] needs.
    ///
    /// # Panics
    /// If there is no such rank.
    pub fn hashes(&self, rank: usize, of: usize) -> Vec<u64> {
        assert!(rank < of, "a rank of {of}");
        let bytes = &self.file.bytes[self.parts[Kind::Lines as usize].clone()];
        let chunks = bytes.len().div_ceil(checksum::CHUNK);
        let at = |rank: usize| (chunks * rank / of * checksum::CHUNK).min(bytes.len());
        let whole = of == 1;
        // Another rank draws from these bytes, or this one, which maps them again.
        checksum::of_each_chunk(&bytes[at(rank)..at(rank + 1)], |chunk| {
            if !whole {
                self.input.finished(chunk);
            }
        })
    }

    /// The clusters of one of `of` ranks, and what describes the whole model. `hashes` are those of all ranks.
    ///
    /// # Errors
    /// As [`read`].
    ///
    /// # Panics
    /// If there is no such rank.
    pub fn take(self, rank: usize, of: usize, hashes: &[u64]) -> Result<(Prepared, Whole), ReadError> {
        assert!(rank < of, "a rank of {of}");
        let Self { file, header, parts, mut mesh, .. } = self;
        let lines = &header.parts[Kind::Lines as usize];
        if !cfg!(fuzzing) && checksum::of_chunks(hashes) != lines.checksum {
            return Err(file.altered(Kind::Lines, lines));
        }
        let whole =
            Whole { bounds: mesh.bounds, translucent: mesh.is_translucent(), checksum: header.checksum };
        if of > 1 {
            let count = mesh.clusters.len();
            let own = count * rank / of..count * (rank + 1) / of;
            let triangles = mesh.triangles;
            mesh.clusters = mesh.clusters.part(own.clone());
            mesh.starts = mesh.starts.part(own.start..own.end + 1);
            mesh.sum_up();
            check::clusters(&mesh, triangles).map_err(|wrong| file.wrong(&header, wrong))?;
            mesh = mesh.as_part_of(&whole);
        } else {
            check::clusters(&mesh, mesh.triangles).map_err(|wrong| file.wrong(&header, wrong))?;
        }
        let about = file.bytes[parts[Kind::About as usize].clone()].to_vec();
        Ok((Prepared { mesh, about }, whole))
    }

    /// Triangles of the whole model.
    pub fn triangles(&self) -> u64 {
        self.mesh.triangles
    }

    /// Input faces of the whole model.
    pub fn faces(&self) -> u64 {
        let last = self
            .mesh
            .face_of_triangle
            .as_deref()
            .map(|faces| faces.last().map_or(0, |&last| u64::from(last) + 1));
        last.unwrap_or(self.mesh.triangles)
    }
}

/// A file that is being read.
struct File<'a> {
    name: &'a str,
    bytes: &'a [u8],
    map: Option<&'a Arc<Mmap>>,
}

impl File<'_> {
    /// The error for a part whose bytes do not have their checksum.
    fn altered(&self, kind: Kind, part: &Part) -> ReadError {
        self.broken(part.offset, format!("{} as they were written", kind.name()), "other bytes")
    }

    /// The error for a mesh that is not valid.
    fn wrong(&self, header: &Header, (kind, expected, found): check::Wrong) -> ReadError {
        self.broken(header.parts[kind as usize].offset, expected, found)
    }

    fn broken(&self, byte: u64, expected: impl ToString, found: impl ToString) -> ReadError {
        ReadError::Malformed {
            file: self.name.into(),
            place: Place::Byte(byte),
            expected: expected.to_string(),
            found: found.to_string(),
        }
    }

    /// The header, if it was written by this version and the file has the length that it states.
    fn header(&self) -> Result<Header, ReadError> {
        if cfg!(target_endian = "big") {
            let what = "a prepared model on a big-endian machine".into();
            return Err(ReadError::Unsupported { file: self.name.into(), place: Place::File, what });
        }
        let Some(bytes) = self.bytes.get(..size_of::<Header>()) else {
            let found = format!("{} bytes", self.bytes.len());
            return Err(self.broken(0, format!("the {} bytes of a header", size_of::<Header>()), found));
        };
        let header: Header = bytemuck::pod_read_unaligned(bytes);
        if header.magic != MAGIC {
            let found = printable(&bytes[..MAGIC.len()]);
            return Err(self.broken(0, format!("the bytes {}", printable(&MAGIC)), found));
        }
        if header.version != VERSION {
            let what =
                format!("version {} of prepared models (this program has version {VERSION})", header.version);
            return Err(ReadError::Unsupported { file: self.name.into(), place: Place::Byte(12), what });
        }
        if !checksum::matches(&bytes[..Header::CHECKED], header.checksum) {
            return Err(self.broken(0, "the header as it was written", "other bytes"));
        }
        if header.file_bytes != self.bytes.len() as u64 {
            let expected = format!("{} bytes in the file", header.file_bytes);
            return Err(self.broken(
                self.bytes.len() as u64,
                expected,
                format!("{} bytes", self.bytes.len()),
            ));
        }
        Ok(header)
    }

    /// The bytes of all parts.
    fn parts(&self, header: &Header) -> Result<Vec<Range<usize>>, ReadError> {
        let range = |part: &Part| {
            let end = part.offset.checked_add(part.bytes).filter(|&end| end <= header.file_bytes)?;
            let aligned = part.offset.is_multiple_of(ALIGNMENT);
            aligned.then_some(part.offset as usize..end as usize)
        };
        let all: Option<Vec<_>> = header.parts.iter().map(range).collect();
        all.ok_or_else(|| self.broken(24, "parts inside of the file", "one that reaches out of it"))
    }

    /// The elements of a part.
    fn array<T: AnyBitPattern>(&self, part: &Range<usize>, kind: Kind) -> Result<Buffer<T>, ReadError> {
        let (bytes, size) = (part.len(), size_of::<T>());
        if !bytes.is_multiple_of(size) {
            let expected = format!("{} of {size} bytes each", kind.name());
            return Err(self.broken(part.start as u64, expected, format!("{bytes} bytes")));
        }
        if let Some(mapped) = self.map.and_then(|map| Buffer::mapped(map, part.clone())) {
            return Ok(mapped);
        }
        let elements = self.bytes[part.clone()].chunks_exact(size);
        Ok(elements.map(bytemuck::pod_read_unaligned).collect::<Vec<T>>().into())
    }
}
