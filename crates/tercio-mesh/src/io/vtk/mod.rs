//! Files of VTK: legacy and XML, with polygonal data or grids.
//!
//! Polygons and strips become triangles. Of grids and other cells with a volume the surface is drawn: faces that two
//! cells share are dropped ([`surface`]). Lines and points become [strokes](crate::strokes). Data of points follow
//! the vertices, data of cells the triangles of their cell. Face numbers are those of cells as VTK counts them.
//!
//! The readers are tercio's own: `vtkio` (0.7) reads no raw appended data, panics on those that are compressed and
//! on wrong counts, takes indices out of range, and names no place in a file.

mod build;
mod cells;
mod collection;
mod dataset;
mod extents;
mod join;
mod legacy;
mod numbers;
mod part;
mod surface;
#[cfg(test)]
mod tests;
mod xml;

use super::obj::transcode;
use super::{ReadModel, ReadOptions, input::Input};
use crate::ReadError;
use crate::error::counted;
use collection::Found;
use dataset::Job;

/// How much of a file is examined for detecting the format.
const FRONT: usize = 1 << 14;

/// Does the content look like a legacy file?
pub fn looks_like_legacy(bytes: &[u8]) -> bool {
    transcode::front(bytes, FRONT).trim_ascii_start().starts_with(legacy::SIGNATURE)
}

/// Does the content look like an XML file of VTK? Its first element has to be the right one.
pub fn looks_like_xml(bytes: &[u8]) -> bool {
    let front = transcode::front(bytes, FRONT);
    let mut rest = front.trim_ascii_start();
    loop {
        let end: &[u8] = match rest {
            [b'<', b'?', ..] => b"?>",
            [b'<', b'!', b'-', b'-', ..] => b"-->",
            [b'<', b'!', ..] => b">",
            _ => {
                return rest
                    .strip_prefix(b"<VTKFile")
                    .is_some_and(|r| r.first().is_some_and(u8::is_ascii_whitespace));
            }
        };
        match rest.windows(end.len()).position(|w| w == end) {
            Some(at) => rest = rest[at + end.len()..].trim_ascii_start(),
            None => return false,
        }
    }
}

/// Reads an XML file, or the files of a collection.
///
/// # Errors
/// Any [`ReadError`].
pub fn read_xml(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let job = Job::new(input, options);
    let document = xml::tree::parse(&job)?;
    let mut found = Found::default();
    let (parts, format) = match xml::kind(&job, &document)? {
        xml::Kind::Data(kind) => {
            (xml::parts(&job, &document)?, format!("VTK XML, {}, {kind}", xml::encoding_name(&document)))
        }
        xml::Kind::Collection(kind) => {
            let parts = collection::parts(&job, &document, &mut found)?;
            found.settle(&job, &parts)?;
            let format = format!("VTK XML, {kind}, {}", counted(parts.len() as u64, "piece"));
            (parts, format)
        }
    };
    if parts.len() > 1 {
        job.reserve("its pieces as one", join::needed_bytes(&parts))?;
    }
    let mut model = join::join(job.file(), parts, options.origin)?;
    model.report.format = format;
    model.report.companions = found.companions;
    model.report.warnings = job.into_warnings();
    model.report.warnings.extend(found.warnings);
    Ok(model)
}

/// The times of a collection (`.pvd`), each once, in ascending order; none for other files. The files of the collection are not
/// read. [`ReadOptions::step`] chooses one.
///
/// # Errors
/// A file that begins as one of XML and is none.
pub fn times(input: &Input, options: &ReadOptions) -> Result<Vec<f64>, ReadError> {
    if !looks_like_xml(input.bytes()) {
        return Ok(Vec::new());
    }
    let job = Job::new(input, options);
    Ok(collection::times(&xml::tree::parse(&job)?.root))
}

/// Names of the number in a file's field data that is its time: that of VTK and ParaView, and that of VisIt.
const TIME_NAMES: [&str; 2] = ["TimeValue", "TIME"];

/// The time of a file, if its field data have one. The rest of the file is not read.
///
/// # Errors
/// A file that begins as one of VTK and is none.
pub fn time(input: &Input, options: &ReadOptions) -> Result<Option<f64>, ReadError> {
    let job = Job::new(input, options);
    let time = if looks_like_xml(input.bytes()) {
        xml::time(&job, &xml::tree::parse(&job)?)?
    } else if looks_like_legacy(input.bytes()) {
        legacy::time(&job)?
    } else {
        None
    };
    Ok(time.filter(|time| time.is_finite()))
}

/// Reads a legacy file.
///
/// # Errors
/// Any [`ReadError`].
pub fn read_legacy(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    legacy::read(input, options)
}
