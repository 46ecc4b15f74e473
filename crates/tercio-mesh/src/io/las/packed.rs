//! Compressed points. What the compressed data say of themselves is checked before anything is reserved for it: numbers of
//! chunks, their places, and the sizes of layers.

use std::io::Cursor;

use crate::loops::prelude::*;
use laz::las::{v3, v4};
use laz::laszip::ChunkTable;
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{LazItem, LazItemType, LazVlr};

use super::columns::Columns;
use super::header::{Header, u16_at, u32_at, u64_at};
use super::skipped::Skipped;
use crate::ReadError;
use crate::error::{Place, counted};
use crate::guard::guarded;
use crate::io::input::Input;

const DAMAGED: &str = "damaged data";

/// Items of a point: its own, time, colours, waves, and more bytes. Each has a decompressor, whatever its size.
const MOST_ITEMS: usize = 8;

/// Bytes of tables that the decompressor of an extra byte in layers has: 4 models of 256 symbols.
const TABLES_OF_A_BYTE: u64 = 10_000;

/// Bytes of the tables for extra bytes, of all threads.
pub fn bytes_of_tables(header: &Header) -> u64 {
    let chunks = header.points.min(rayon::current_num_threads() as u64);
    TABLES_OF_A_BYTE * header.extra.bytes() as u64 * chunks
}

/// A part that is compressed by itself.
struct Chunk<'a> {
    /// Where it is in the file.
    at: usize,
    bytes: &'a [u8],
    points: usize,
}

/// Reads compressed points.
pub fn read<'a>(
    input: &Input,
    header: &'a Header,
    columns: &mut Columns<'a>,
    advance: impl Fn(usize) + Sync,
) -> Result<(), ReadError> {
    let bytes = input.bytes();
    let wrong = |at: usize, expected: &str, found: String| ReadError::Malformed {
        file: input.name.clone(),
        place: Place::Byte(at as u64),
        expected: expected.into(),
        found,
    };
    let (from, to) = header.laszip.unwrap_or_default();
    let record = bytes.get(from..to).unwrap_or_default();
    let vlr = LazVlr::from_buffer(record);
    let vlr = vlr.map_err(|error| wrong(from, "a record of LASzip", error.to_string()))?;
    if vlr.items().len() > MOST_ITEMS {
        let found = vlr.items().len().to_string();
        return Err(wrong(from, &format!("at most {MOST_ITEMS} items of a point"), found));
    }
    let size: u64 = vlr.items().iter().map(|item| u64::from(item.size())).sum();
    if vlr.items().is_empty() || size != header.record as u64 {
        let expected = format!("items of {} bytes", header.record);
        return Err(wrong(from, &expected, counted(size, "byte")));
    }
    let kind = u16_at(record, 0).unwrap_or(0);
    let data = bytes.get(header.begin..).unwrap_or_default();
    let is_layered = kind == 3;
    let chunks = match kind {
        _ if header.points == 0 => Vec::new(),
        1 => vec![Chunk { at: header.begin, bytes: data, points: header.points as usize }],
        2 | 3 => {
            let mistaken = |(at, expected, found): Mistake| wrong(at, &expected, found);
            // So has the reader of the table.
            let damaged = wrong(header.begin, "compressed points with a table of chunks", DAMAGED.into());
            guarded(damaged, || chunks(bytes, header, &vlr).map_err(mistaken))?
        }
        _ => return Err(wrong(from, "compression 1, 2 or 3", kind.to_string())),
    };
    let group = rayon::current_num_threads() * 4;
    for group in chunks.chunks(group) {
        let read = |chunk: &Chunk| {
            let mut own = Columns::new(header);
            let expected = counted(chunk.points as u64, "compressed point");
            let damaged = |found: String| wrong(chunk.at, &expected, found);
            // The decompressor has no checks of its own for every damage.
            let result = guarded(damaged(DAMAGED.into()), || {
                chunk.unpack(vlr.items(), is_layered, header, &mut own).map_err(damaged)
            });
            advance(chunk.points);
            input.consumed(chunk.bytes.len());
            result.map(|()| own)
        };
        let pieces: Vec<Result<Columns, ReadError>> = group.par_iter().map(read).collect();
        for piece in pieces {
            columns.append(piece?);
        }
    }
    Ok(())
}

type Mistake = (usize, String, String);

/// The chunks, from their table.
fn chunks<'a>(bytes: &'a [u8], header: &Header, vlr: &LazVlr) -> Result<Vec<Chunk<'a>>, Mistake> {
    let end = |at: usize, expected: &str| (at, expected.to_owned(), "the end of the file".to_owned());
    let first = header.begin + 8;
    let place = |at: usize| u64_at(bytes, at).and_then(|at| usize::try_from(at).ok());
    let is_place = |at: &usize| *at >= first && *at < bytes.len();
    // Writers that could not go back have put it at the end.
    let last = bytes.len().checked_sub(8).and_then(place);
    let table = place(header.begin).filter(is_place).or_else(|| last.filter(is_place));
    let Some(table) = table else {
        return Err(end(header.begin, "the place of the table of chunks"));
    };
    let count = u32_at(bytes, table + 4).ok_or_else(|| end(table, "the number of chunks"))?;
    let size = if vlr.uses_variable_size_chunks() { 1 } else { u64::from(vlr.chunk_size().max(1)) };
    // Of chunks of variable size some may be empty; not most of them.
    let most = match vlr.uses_variable_size_chunks() {
        true => header.points.saturating_add(1024),
        false => header.points.div_ceil(size),
    };
    if u64::from(count) > most || u64::from(count) > bytes.len() as u64 {
        return Err((table + 4, format!("at most {most} chunks"), count.to_string()));
    }
    let mut source = Cursor::new(bytes.get(table..).unwrap_or_default());
    let is_variable = vlr.uses_variable_size_chunks();
    let entries = ChunkTable::read(&mut source, is_variable)
        .map_err(|error| (table, format!("a table of {count} chunks"), error.to_string()))?;
    let mut chunks = Vec::new();
    let (mut at, mut left) = (first, header.points);
    for entry in entries.as_ref() {
        let points = if is_variable { entry.point_count } else { size.min(left) };
        let end = usize::try_from(entry.byte_count).ok().and_then(|length| at.checked_add(length));
        let part = end.and_then(|end| bytes.get(at..end.min(table.max(at))).filter(|p| at + p.len() == end));
        let Some(part) = part else {
            let expected = format!("a chunk of {}", counted(entry.byte_count, "byte"));
            return Err((at, expected, format!("{} up to the table of chunks", table.saturating_sub(at))));
        };
        if points > left {
            return Err((table, counted(header.points, "point"), "more in the chunks".into()));
        }
        left -= points;
        if points > 0 {
            chunks.push(Chunk { at, bytes: part, points: points as usize });
        }
        at += part.len();
    }
    if left > 0 {
        let found = format!("{} in the chunks", header.points - left);
        return Err((table, counted(header.points, "point"), found));
    }
    Ok(chunks)
}

impl Chunk<'_> {
    /// Decompresses all points.
    fn unpack(
        &self,
        items: &Vec<LazItem>,
        is_layered: bool,
        header: &Header,
        columns: &mut Columns,
    ) -> Result<(), String> {
        let record = header.record;
        let source = Cursor::new(self.bytes);
        let mut decompressor: Box<dyn RecordDecompressor<Cursor<&[u8]>>> = if is_layered {
            self.check_layers(items, record)?;
            let mut layered = LayeredPointRecordDecompressor::new(source);
            for item in items {
                match item.item_type() {
                    // Layers of other versions are refused below. Each byte has a layer and models of its own, so that bytes next to
                    // each other can have different decompressors.
                    LazItemType::Byte14(count) if matches!(item.version(), 3 | 4) => {
                        for (bytes, is_described) in header.extra.runs(layered.record_size(), count.into()) {
                            match (is_described, item.version()) {
                                (false, _) => layered.add_field_decompressor(Skipped::new(bytes)),
                                (_, 3) => {
                                    layered.add_field_decompressor(v3::LasExtraByteDecompressor::new(bytes))
                                }
                                _ => layered.add_field_decompressor(v4::LasExtraByteDecompressor::new(bytes)),
                            }
                        }
                    }
                    _ => layered.set_fields_from(&vec![*item]).map_err(|error| error.to_string())?,
                }
            }
            Box::new(layered)
        } else {
            let mut sequential = SequentialPointRecordDecompressor::new(source);
            sequential.set_fields_from(items).map_err(|error| error.to_string())?;
            Box::new(sequential)
        };
        if decompressor.record_size() != record {
            return Err(format!(
                "{} a point, not {record}",
                counted(decompressor.record_size() as u64, "byte")
            ));
        }
        let mut point = vec![0; record];
        for _ in 0..self.points {
            decompressor.decompress_next(&mut point).map_err(|error| error.to_string())?;
            columns.add(&point);
        }
        Ok(())
    }

    /// Are the layers as long as the chunk says? The first point, and how many there are, come before their sizes.
    fn check_layers(&self, items: &[LazItem], record: usize) -> Result<(), String> {
        let layers: usize = items
            .iter()
            .map(|item| match item.item_type() {
                LazItemType::Point14 => 9,
                LazItemType::RGBNIR14 => 2,
                LazItemType::Byte14(count) => usize::from(count),
                _ => 1,
            })
            .sum();
        let sizes = record + 4;
        let begin = sizes + 4 * layers;
        let all: Option<u64> = (0..layers).map(|k| u32_at(self.bytes, sizes + 4 * k).map(u64::from)).sum();
        match all {
            Some(all) if all <= self.bytes.len().saturating_sub(begin) as u64 => Ok(()),
            Some(all) => Err(format!("layers of {all} bytes in a chunk of {}", self.bytes.len())),
            None => Err("the end of the chunk".into()),
        }
    }
}
