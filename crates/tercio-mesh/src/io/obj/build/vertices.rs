//! What vertices have besides their positions.

use crate::error::counted;
use crate::loops::prelude::*;

use super::{Chunk, NONE};

/// Says of how many corners the texture coordinates are missing.
pub fn warn_of_missing_texcoords(chunks: &[Chunk], warnings: &mut Vec<String>) {
    let missing: u64 = chunks
        .par_iter()
        .map(|c| {
            let without = if c.corners.vt.is_empty() { c.corners.v.len() } else { 0 };
            (without + c.corners.vt.iter().filter(|&&i| i == NONE).count()) as u64
        })
        .sum();
    if missing > 0 {
        warnings.push(format!(
            "set the texture coordinates of {} without any to 0, 0",
            counted(missing, "corner")
        ));
    }
}

/// Colours that follow the positions: 0 to 1, or 0 to 255 as some programs write them.
pub fn vertex_colors(chunks: &[Chunk], count: usize, warnings: &mut Vec<String>) -> Option<Vec<[u8; 4]>> {
    if chunks.iter().all(|c| c.colors.is_empty()) {
        return None;
    }
    let largest_of = |c: &Chunk| {
        c.colors.iter().flat_map(|c| &c[..3]).filter(|x| x.is_finite()).fold(0.0f32, |a, &b| a.max(b))
    };
    let largest = chunks.par_iter().map(largest_of).reduce(|| 0.0, f32::max);
    // Colours computed in floating point may exceed 1 by a little.
    let is_bytes = largest > 2.0;
    if is_bytes {
        warnings.push("took vertex colours as 0 to 255, because some are far above 1".into());
    }
    let scale = if is_bytes { 1.0 } else { 255.0 };
    let byte = |x: f32| (x * scale).round() as u8;
    let mut colors = Vec::with_capacity(count);
    let mut without = 0;
    for chunk in chunks {
        colors.extend(chunk.colors.iter().map(|&[r, g, b, a]| {
            if !(r.is_finite() && g.is_finite() && b.is_finite()) {
                without += 1;
                return [255; 4];
            }
            // A missing alpha is stored as 1 in either range.
            let alpha = if a == 1.0 || !a.is_finite() { 255 } else { byte(a) };
            [byte(r), byte(g), byte(b), alpha]
        }));
        let held = chunk.vertices as usize - chunk.colors.len();
        without += held;
        colors.resize(colors.len() + held, [255; 4]);
    }
    if without > 0 {
        warnings
            .push(format!("set the colour of vertices without a finite one to white: {without} of {count}"));
    }
    Some(colors)
}
