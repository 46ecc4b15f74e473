//! Warnings of what is not in the mesh.

use crate::error::{counted, printable};

use super::super::parse::UNKNOWN_KEPT;
use super::Chunk;

/// Says what of the file was ignored or guessed.
pub fn warn_of_ignored(chunks: &[Chunk], warnings: &mut Vec<String>) {
    let small: u64 = chunks.iter().map(|c| c.small_faces).sum();
    if let Some(line) = chunks.iter().find_map(|c| c.first_small_face) {
        warnings.push(format!(
            "ignored {} with fewer than three corners, the first in line {line}",
            counted(small, "face")
        ));
    }
    let pointless: u64 = chunks.iter().map(|c| c.corners.pointless).sum();
    if pointless > 0 {
        let indices = if pointless == 1 { "index" } else { "indices" };
        warnings.push(format!(
            "ignored {pointless} {indices} of texture coordinates or normals that the file does not hold"
        ));
    }
    let odd: u64 = chunks.iter().map(|c| c.odd_numbers).sum();
    if odd > 0 {
        warnings.push(format!("guessed {} written in a way that OBJ does not know", counted(odd, "number")));
    }
    let lines: u64 = chunks.iter().map(|c| c.unknown_lines).sum();
    if lines > 0 {
        let mut unknown: Vec<&[u8]> = Vec::new();
        for keyword in chunks.iter().flat_map(|c| &c.unknown) {
            if unknown.len() < UNKNOWN_KEPT && !unknown.contains(keyword) {
                unknown.push(keyword);
            }
        }
        let shown = unknown.iter().map(|k| printable(k)).collect::<Vec<_>>().join(", ");
        let begin = if lines == 1 { "begins" } else { "begin" };
        warnings
            .push(format!("ignored {} that {begin} with an unknown word: {shown}", counted(lines, "line")));
    }
}
