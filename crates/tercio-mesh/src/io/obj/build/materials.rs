//! Materials of faces, lines and points, from the libraries that the file names.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use crate::error::counted;
use crate::io::input::Input;
use crate::{FileMaterial, Mesh};

use super::super::lines::join;
use super::super::{mtl, names};
use super::strokes::{Painted, Paints};
use super::{Chunk, Names, faces};

/// Looks up the materials that faces, lines and points use. A material that no library defines causes a warning and gets no number,
/// because an invented colour could be mistaken for one of the file. `None` if lines and points have no material.
pub fn add_materials<'a>(
    input: &Input,
    chunks: &[Chunk<'a>],
    mesh: &mut Mesh,
    companions: &mut Vec<PathBuf>,
    warnings: &mut Vec<String>,
) -> Option<Painted<'a>> {
    let used = Names::join(input, chunks, faces, |c| c.materials.iter().map(|p| (p.face, p.name)));
    let of_segments = |c: &Chunk| c.segments.len() as u64;
    let of_segments =
        Names::join(input, chunks, of_segments, |c| c.materials.iter().map(|p| (p.segment, p.name)));
    let of_dots = |c: &Chunk| c.dots.len() as u64;
    let of_dots = Names::join(input, chunks, of_dots, |c| c.materials.iter().map(|p| (p.dot, p.name)));
    if [&used, &of_segments, &of_dots].iter().all(|used| used.names.is_empty()) {
        // The libraries are not read for this model, but they are files of it nevertheless.
        if let Some(base) = &input.base {
            let (libraries, mut scratch) = (mtl::Libraries::new(base), Vec::new());
            // Each once, in the order of the file.
            let mut noted: HashSet<&[u8]> = HashSet::new();
            for names in chunks.iter().flat_map(|c| &c.libraries).filter(|names| noted.insert(names)) {
                libraries.note_unread(join(names, &mut scratch), companions);
            }
        }
        return None;
    }
    let library = load_libraries(input, chunks, companions, warnings);
    warnings.dedup();
    let mut by_name = HashMap::new();
    for material in library.iter().rev() {
        by_name.insert(material.name.as_str(), material);
    }
    let (mut undefined, mut noted) = (Vec::new(), HashSet::new());
    let mut find = |name: &'a [u8]| {
        let text = names::text(name);
        let material = by_name.get(text.as_str()).copied();
        if material.is_none() && noted.insert(name) {
            undefined.push(format!("\"{text}\""));
        }
        material
    };
    let numbers: Vec<u32> = used
        .names
        .iter()
        .map(|name| match find(name) {
            Some(material) => {
                mesh.materials.push(FileMaterial::clone(material));
                mesh.materials.len() as u32 - 1
            }
            None => Mesh::NO_MATERIAL,
        })
        .collect();
    let mut listed = HashSet::new();
    let names = of_segments.names.iter().chain(&of_dots.names).filter(|name| listed.insert(**name));
    let materials = names.filter_map(|name| find(name).cloned()).collect();
    let [segments, points] = [of_segments, of_dots].map(|used| {
        let colors = used.names.iter().map(|name| find(name).map(FileMaterial::flat_color)).collect();
        Paints { used, colors }
    });
    if !undefined.is_empty() {
        let dots = if undefined.len() > 3 { ", …" } else { "" };
        let first = undefined.iter().take(3).cloned().collect::<Vec<_>>().join(", ");
        warnings.push(format!(
            "found no definition of {}: {first}{dots}",
            counted(undefined.len() as u64, "material")
        ));
    }
    if !mesh.materials.is_empty() {
        let number =
            |n: Option<u32>| n.and_then(|n| numbers.get(n as usize)).copied().unwrap_or(Mesh::NO_MATERIAL);
        mesh.triangle_materials =
            Some(used.spread(mesh.triangles.len(), mesh.face_of_triangle.as_deref(), number));
    }
    let has_color = |paints: &Paints| paints.colors.iter().any(Option::is_some);
    (has_color(&segments) || has_color(&points)).then_some(Painted { segments, points, materials })
}

fn load_libraries(
    input: &Input,
    chunks: &[Chunk],
    companions: &mut Vec<PathBuf>,
    warnings: &mut Vec<String>,
) -> Vec<FileMaterial> {
    let lines = chunks.iter().flat_map(|c| &c.libraries);
    let Some(base) = &input.base else {
        if lines.count() > 0 {
            warnings.push("did not look for material libraries: the model comes without a folder".into());
        }
        return Vec::new();
    };
    let mut libraries = mtl::Libraries::new(base);
    let mut asked = HashSet::new();
    let mut scratch = Vec::new();
    for &names in lines {
        if !asked.insert(names) {
            continue;
        }
        // The line may be continued.
        let names = join(names, &mut scratch);
        match asked.len() {
            ..=MOST_LIBRARIES => libraries.load(names, companions, warnings),
            n => {
                if n == MOST_LIBRARIES + 1 {
                    warnings.push(format!("did not read more than {MOST_LIBRARIES} material libraries"));
                }
                libraries.note_unread(names, companions);
            }
        }
    }
    libraries.materials
}

/// Each takes several file-system queries.
const MOST_LIBRARIES: usize = 256;
