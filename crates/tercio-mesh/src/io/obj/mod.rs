//! Wavefront OBJ with its material libraries (MTL).
//!
//! The text is split into chunks at line ends. A first pass counts vertices and faces, so that every chunk knows the
//! offset of its own ([`lines`]); a second parses all chunks in parallel ([`parse`], [`faces`]); then corners become
//! vertices ([`unify`]) and faces triangles ([`build`]).
//!
//! Source: the appendix "Object Files (.obj)" of the Advanced Visualizer manual; free-form curves and
//! surfaces are not drawn.

mod build;
mod evidence;
mod faces;
mod lines;
mod mtl;
mod names;
mod parse;
pub(super) mod transcode;
mod unify;

use crate::loops::prelude::*;

use crate::mesh::MAX_ELEMENTS;

use super::{ReadModel, ReadOptions, input::Input};
use crate::{OctNormal, ReadError};
pub use evidence::{holds_nothing_but, looks_like};
use lines::Counts;
use parse::{Chunk, Context, Slots};

/// Reads OBJ.
///
/// # Errors
/// Any [`ReadError`].
pub fn read(input: &Input, options: &ReadOptions) -> Result<ReadModel, ReadError> {
    let mut odd = Vec::new();
    let text = transcode::text(input, options, &mut odd)?;
    // Small enough to share the work evenly, large enough that the overhead of a chunk's arrays does not matter.
    let step = (text.len() / (8 * rayon::current_num_threads())).clamp(1 << 16, 1 << 22);
    let step = input.stretch(step);
    let parts = lines::split(&text, step, |bytes| input.consumed(bytes));
    input.check_chunk_lengths(&parts, options)?;
    let mut model = read_chunks(input, options, &parts)?;
    model.report.warnings.splice(0..0, odd);
    Ok(model)
}

fn read_chunks(input: &Input, options: &ReadOptions, parts: &[&[u8]]) -> Result<ReadModel, ReadError> {
    let bytes = parts.iter().map(|p| p.len() as u64).sum();
    if let Some(p) = options.progress {
        p.begin("parsing", bytes);
    }
    let counts: Vec<Counts> = parts
        .par_iter()
        .map(|part| {
            let counts = Counts::of(part);
            input.consumed(part.len());
            counts
        })
        .collect();
    let total = counts.iter().fold(Counts::default(), |sum, &c| sum.plus(c));
    check_counts(input, options, &total)?;

    let mut positions = vec![[0.0f64; 3]; total.vertices as usize];
    let mut texcoords = vec![[0.0f32; 2]; total.texcoords as usize];
    let mut normals = vec![OctNormal::NONE; total.normals as usize];
    let mut jobs = Vec::with_capacity(parts.len());
    let mut before = Counts::default();
    let (mut p, mut t, mut n) = (&mut positions[..], &mut texcoords[..], &mut normals[..]);
    for (&part, &count) in parts.iter().zip(&counts) {
        let slots = Slots {
            positions: take(&mut p, count.vertices),
            texcoords: take(&mut t, count.texcoords),
            normals: take(&mut n, count.normals),
        };
        jobs.push((part, Context { file: &input.name, before, total }, slots));
        before = before.plus(count);
    }
    let parsed: Vec<Result<Chunk, ReadError>> = jobs
        .into_par_iter()
        .map(|(part, context, slots)| {
            let chunk = parse::parse(part, &context, slots);
            input.consumed(part.len());
            if let Some(p) = options.progress {
                p.advance(part.len() as u64);
            }
            chunk
        })
        .collect();
    // In the order of the file, so that the first error is the one that is reported.
    let chunks = parsed.into_iter().collect::<Result<Vec<_>, _>>()?;
    build::build(input, options, build::Parsed { positions, texcoords, normals, chunks })
}

/// Splits the first `count` elements off a slice.
fn take<'s, T>(slice: &mut &'s mut [T], count: u64) -> &'s mut [T] {
    let (head, tail) = std::mem::take(slice).split_at_mut(count as usize);
    *slice = tail;
    head
}

fn check_counts(input: &Input, options: &ReadOptions, total: &Counts) -> Result<(), ReadError> {
    let all = [
        ("vertices", total.vertices),
        ("texture coordinates", total.texcoords),
        ("normals", total.normals),
        ("faces", total.faces),
    ];
    for (what, count) in all {
        if count > MAX_ELEMENTS {
            return Err(ReadError::TooMany { file: input.name.clone(), what, count });
        }
    }
    // Positions in f64 and f32; normals and texture coordinates as parsed and as stored; corners and triangles.
    let needed = total.vertices * 36 + total.texcoords * 16 + total.normals * 16 + total.faces * 24;
    options.check_memory(&input.name, "vertices and faces", input.held_bytes() + needed)
}

#[cfg(test)]
mod tests;
