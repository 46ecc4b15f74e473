//! Arrays of numbers: as text, or as bytes in place, in base64, or compressed.

use std::borrow::Cow;

use crate::loops::prelude::*;

use super::base64::{characters, decode};
use super::compress::{Compressor, decompress};
use super::tree::Element;
use crate::ReadError;
use crate::error::{Place, counted, printable};
use crate::io::text::{Cursor, is_space};
use crate::io::vtk::dataset::Job;
use crate::io::vtk::numbers::{Numbers, Scalar, Source, Word};

/// How a file holds arrays.
pub struct Encoding {
    pub big_endian: bool,
    /// Bytes of a number in the heads of arrays.
    pub word: usize,
    pub compressor: Option<Compressor>,
    /// Where appended data begin, and whether they are base64.
    pub appended: Option<(usize, bool)>,
}

/// Text that a task parses at a time.
const TEXT: usize = 1 << 17;

/// Type of an array in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    Numbers(Scalar),
    /// Eight to a byte, except in text.
    Bits,
    Text,
}

/// The type of an array.
///
/// # Errors
/// A type that VTK does not have.
pub fn kind(job: &Job, element: &Element) -> Result<Type, ReadError> {
    Ok(Type::Numbers(match element.attribute("type").unwrap_or("") {
        "Int8" => Scalar::I8,
        "UInt8" => Scalar::U8,
        "Int16" => Scalar::I16,
        "UInt16" => Scalar::U16,
        "Int32" => Scalar::I32,
        "UInt32" => Scalar::U32,
        "Int64" | "vtkIdType" => Scalar::I64,
        "UInt64" => Scalar::U64,
        "Float32" => Scalar::F32,
        "Float64" => Scalar::F64,
        "Bit" => return Ok(Type::Bits),
        "String" => return Ok(Type::Text),
        other => {
            let expected = "the type of an array (Int8 to UInt64, Float32, Float64)";
            return Err(job.malformed(job.line(element.at), expected, format!("{other:?}")));
        }
    }))
}

/// So many bits of an array as numbers 0 and 1.
///
/// # Errors
/// As of [`numbers`].
pub fn bits<'a>(
    job: &Job<'a>,
    encoding: &Encoding,
    element: &Element,
    count: u64,
) -> Result<Numbers<'a>, ReadError> {
    let packed = numbers(job, encoding, element, Scalar::U8)?;
    if matches!(packed.source, Source::Text(..)) {
        return Ok(packed);
    }
    if packed.len() as u64 != count.div_ceil(8) {
        let name = element.attribute("Name").unwrap_or("without a name");
        let expected = format!("array {name:?}, {} in {} bytes", counted(count, "bit"), count.div_ceil(8));
        return Err(job.malformed(packed.place(0), expected, counted(packed.len() as u64, "byte")));
    }
    job.reserve("an array of bits", count)?;
    job.input.consumed(packed.len());
    Ok(packed.bits(count as usize))
}

/// The numbers of an array.
///
/// # Errors
/// Numbers that are not there or not valid, and too little memory.
pub fn numbers<'a>(
    job: &Job<'a>,
    encoding: &Encoding,
    element: &Element,
    scalar: Scalar,
) -> Result<Numbers<'a>, ReadError> {
    let bytes = job.input.bytes();
    let name = element.attribute("Name").unwrap_or("without a name");
    let text = bytes.get(element.text.clone()).unwrap_or_default();
    let is_raw = encoding.compressor.is_none() && encoding.appended.is_some_and(|(_, base64)| !base64);
    if !is_raw || !text.is_empty() {
        // Longer parts than may be in memory are decoded at once.
        job.count_all()?;
    }
    let (bytes, place) = match element.attribute("format").unwrap_or("ascii") {
        "ascii" => return ascii(job, text, element, scalar),
        "binary" => {
            let place = job.line(element.text.start);
            if text.is_empty() {
                // Writers leave empty arrays out.
                (Cow::Borrowed(&[][..]), place)
            } else {
                let trimmed = text.trim_ascii();
                let clean: Cow<[u8]> = if trimmed.iter().any(u8::is_ascii_whitespace) {
                    job.reserve("an array", trimmed.len() as u64)?;
                    trimmed.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect::<Vec<_>>().into()
                } else {
                    trimmed.into()
                };
                (from_base64(job, encoding, &clean, place, name)?.into(), place)
            }
        }
        "appended" => {
            let offset = element.attribute("offset").and_then(|o| o.trim().parse::<u64>().ok());
            let (Some(offset), Some((start, base64))) = (offset, encoding.appended) else {
                let expected = format!("an offset into appended data for array {name:?}");
                return Err(job.malformed(job.line(element.at), expected, "none"));
            };
            let at = (start as u64).saturating_add(offset);
            let place = Place::Byte(at);
            let Some(rest) = usize::try_from(at).ok().and_then(|at| bytes.get(at..)) else {
                let expected = format!("array {name:?} at offset {offset} of the appended data");
                let length = counted((bytes.len() - start) as u64, "byte");
                return Err(job.malformed(job.line(element.at), expected, format!("{length} of them")));
            };
            if base64 {
                (from_base64(job, encoding, rest, place, name)?.into(), place)
            } else if let Some(compressor) = encoding.compressor {
                (blocks(job, encoding, compressor, rest, place, name)?.into(), place)
            } else {
                let length = word(encoding, rest, 0).filter(|&n| n <= (rest.len() - encoding.word) as u64);
                let Some(length) = length else { return Err(too_short(job, encoding, rest, place, name)) };
                let data = rest.get(encoding.word..encoding.word + length as usize).unwrap_or_default();
                let source = Source::Raw(at + encoding.word as u64);
                check_length(job, data.len(), scalar, place, name)?;
                let (big_endian, input) = (encoding.big_endian, Some(job.input));
                return Ok(Numbers { bytes: data.into(), scalar, big_endian, source, input });
            }
        }
        other => {
            let expected = "format=\"ascii\", \"binary\" or \"appended\"";
            return Err(job.malformed(job.line(element.at), expected, format!("{other:?}")));
        }
    };
    check_length(job, bytes.len(), scalar, place, name)?;
    let source = Source::Encoded(place);
    Ok(Numbers { bytes, scalar, big_endian: encoding.big_endian, source, input: None })
}

fn check_length(job: &Job, length: usize, scalar: Scalar, place: Place, name: &str) -> Result<(), ReadError> {
    if length.is_multiple_of(scalar.bytes()) {
        return Ok(());
    }
    let expected = format!("numbers of {} bytes each in array {name:?}", scalar.bytes());
    Err(job.malformed(place, expected, counted(length as u64, "byte")))
}

/// A number of the head of an array.
fn word(encoding: &Encoding, bytes: &[u8], index: usize) -> Option<u64> {
    let bytes = bytes.get(index.checked_mul(encoding.word)?..)?;
    let narrow = |b: [u8; 4]| if encoding.big_endian { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) };
    let wide = |b: [u8; 8]| if encoding.big_endian { u64::from_be_bytes(b) } else { u64::from_le_bytes(b) };
    match encoding.word {
        4 => bytes.first_chunk().map(|&b| narrow(b).into()),
        _ => bytes.first_chunk().map(|&b| wide(b)),
    }
}

#[cold]
fn too_short(job: &Job, encoding: &Encoding, rest: &[u8], place: Place, name: &str) -> ReadError {
    let length = word(encoding, rest, 0).map_or("its length".into(), |n| format!("{n} bytes"));
    let found = format!("{} up to the end of the file", counted(rest.len() as u64, "byte"));
    job.malformed(place, format!("array {name:?}, {length}"), found)
}

/// An array in base64: the head, and the data in the same or in another run of characters.
fn from_base64(
    job: &Job,
    encoding: &Encoding,
    text: &[u8],
    place: Place,
    name: &str,
) -> Result<Vec<u8>, ReadError> {
    let part = |from: usize, bytes: usize| -> Result<Vec<u8>, ReadError> {
        let Some(text) = text.get(from..).and_then(|t| t.get(..characters(bytes)?)) else {
            let expected = format!("array {name:?}, {bytes} bytes in base64");
            let found = counted(text.len().saturating_sub(from) as u64, "character");
            return Err(job.malformed(place, expected, found));
        };
        job.reserve("an array", 2 * bytes as u64)?;
        decode(text).ok_or_else(|| {
            let odd =
                text.iter().position(|b| !b.is_ascii_alphanumeric() && !b"+/=".contains(b)).unwrap_or(0);
            let found = printable(text.get(odd..(odd + 8).min(text.len())).unwrap_or_default());
            job.malformed(place, format!("array {name:?} in base64"), found)
        })
    };
    let size = |n: u64| usize::try_from(n).ok().filter(|&n| n < usize::MAX / 4);
    let too_long = || job.malformed(place, format!("array {name:?} in base64"), "a length that no file has");
    if let Some(compressor) = encoding.compressor {
        let front = part(0, 3 * encoding.word)?;
        let count = word(encoding, &front, 0).and_then(size).ok_or_else(too_long)?;
        let head = count.checked_add(3).and_then(|n| n.checked_mul(encoding.word)).ok_or_else(too_long)?;
        let mut bytes = if count == 0 { front } else { part(0, head)? };
        bytes.truncate(head);
        let sizes = (0..count).filter_map(|block| word(encoding, &bytes, 3 + block));
        let all = size(sizes.fold(0, u64::saturating_add)).ok_or_else(too_long)?;
        let from = characters(head).ok_or_else(too_long)?;
        bytes.extend(part(from, all)?);
        return blocks(job, encoding, compressor, &bytes, place, name);
    }
    let front = part(0, encoding.word)?;
    let length = word(encoding, &front, 0).and_then(size).ok_or_else(too_long)?;
    let head = characters(encoding.word).unwrap_or(0);
    // Some writers end the head with padding: one of 4 bytes with two characters of it, one of 8 bytes with one.
    let padding: &[u8] = if encoding.word == 4 { b"==" } else { b"=" };
    if text.get(..head).is_some_and(|t| t.ends_with(padding)) && text.len() > head {
        let mut bytes = part(head, length)?;
        bytes.truncate(length);
        return Ok(bytes);
    }
    let mut bytes = part(0, encoding.word + length)?;
    bytes.drain(..encoding.word);
    bytes.truncate(length);
    Ok(bytes)
}

/// Compressed blocks after a head: their number, the size of each before compression, that of the last one if it is
/// smaller, and the compressed sizes.
fn blocks(
    job: &Job,
    encoding: &Encoding,
    compressor: Compressor,
    bytes: &[u8],
    place: Place,
    name: &str,
) -> Result<Vec<u8>, ReadError> {
    let too_short = || too_short(job, encoding, bytes, place, name);
    let head = |index| word(encoding, bytes, index).ok_or_else(too_short);
    let count = head(0)?;
    if count == 0 {
        return Ok(Vec::new());
    }
    let (block, last) = (head(1)?, head(2)?);
    if count > (bytes.len() / encoding.word) as u64 {
        return Err(too_short());
    }
    let mut at = (3 + count as usize) * encoding.word;
    let mut compressed = Vec::with_capacity(count as usize);
    for index in 0..count as usize {
        let size = head(3 + index)?;
        let end = usize::try_from(size).ok().and_then(|n| at.checked_add(n));
        let Some(part) = end.and_then(|end| bytes.get(at..end)) else {
            let expected = format!("{size} bytes of block {index} of {count} of array {name:?}");
            let found = format!("{} up to the end", counted(bytes.len().saturating_sub(at) as u64, "byte"));
            return Err(job.malformed(place, expected, found));
        };
        compressed.push(part);
        at += part.len();
    }
    let last = if last == 0 { block } else { last };
    let all = block.saturating_mul(count - 1).saturating_add(last);
    if last > block || block == 0 || all / compressor.most_ratio() > at as u64 {
        let expected = format!("sizes of the blocks of array {name:?} that {at} compressed bytes can have");
        return Err(job.malformed(place, expected, format!("{count} of {block} bytes, the last of {last}")));
    }
    job.reserve("a decompressed array", all)?;
    job.input.consumed(at);
    let mut data = vec![0; all as usize];
    let wrong = data.par_chunks_mut(block as usize).zip(&compressed).enumerate().find_map_first(
        |(index, (to, from))| decompress(compressor, from, to).err().map(|error| (index, error)),
    );
    match wrong {
        None => Ok(data),
        Some((index, error)) => {
            let expected =
                format!("block {index} of {count} of array {name:?}, compressed by {}", compressor.name());
            Err(job.malformed(place, expected, error))
        }
    }
}

fn ascii<'a>(
    job: &Job<'a>,
    text: &'a [u8],
    element: &Element,
    scalar: Scalar,
) -> Result<Numbers<'a>, ReadError> {
    // Pieces end before a blank.
    let mut pieces = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let step = rest.len().min(TEXT);
        let end = rest[step..].iter().position(|&b| is_space(b)).map_or(rest.len(), |n| step + n);
        let (piece, tail) = rest.split_at(end);
        pieces.push(piece);
        rest = tail;
    }
    let words = |piece: &&[u8]| piece.split(|&b| is_space(b)).filter(|w| !w.is_empty()).count() as u64;
    let count: u64 = pieces.par_iter().map(words).sum();
    job.reserve("an array", 2 * count * scalar.bytes() as u64)?;
    let parsed: Vec<Result<Vec<u8>, usize>> = pieces
        .par_iter()
        .map(|piece| {
            let mut cursor = Cursor::new(piece, 1);
            let mut bytes = Vec::new();
            loop {
                cursor.skip_space();
                if cursor.is_at_end() {
                    return Ok(bytes);
                }
                let whole = if scalar.is_real() { None } else { cursor.integer().map(Word::Whole) };
                match whole.or_else(|| cursor.float().map(Word::Real)) {
                    Some(value) => scalar.push(value, &mut bytes),
                    None if cursor.clone().word().eq_ignore_ascii_case(b"-nan") => {
                        cursor.word();
                        scalar.push(Word::Real(f64::NAN), &mut bytes);
                    }
                    None => return Err(piece.as_ptr().addr() - text.as_ptr().addr() + cursor.offset()),
                }
            }
        })
        .collect();
    let mut bytes = Vec::with_capacity((count * scalar.bytes() as u64) as usize);
    for piece in parsed {
        match piece {
            Ok(piece) => bytes.extend(piece),
            Err(at) => {
                let word = Cursor::new(&text[at..], 1).word();
                let name = element.attribute("Name").unwrap_or("without a name");
                let place = job.line(element.text.start + at);
                return Err(job.malformed(place, format!("a number of array {name:?}"), printable(word)));
            }
        }
    }
    let Place::Line(first) = job.line(element.text.start) else {
        return Err(job.malformed(Place::File, "", ""));
    };
    let (source, big_endian) = (Source::Text(text, first), cfg!(target_endian = "big"));
    Ok(Numbers { bytes: bytes.into(), scalar, big_endian, source, input: None })
}
