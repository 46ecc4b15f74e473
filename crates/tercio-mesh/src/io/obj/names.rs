//! Names that apply from one face up to the next name: materials, groups, objects.

use std::collections::HashMap;

use super::parse::{Chunk, NameFrom};
use crate::io::input::Input;

/// Names of all faces of the file.
#[derive(Debug, Default)]
pub struct Names<'a> {
    /// Different names in the order of their first use.
    pub names: Vec<&'a [u8]>,
    /// First face and number of the name (`None` for no name); faces strictly increase.
    runs: Vec<(u64, Option<u32>)>,
    faces: u64,
}

impl<'a> Names<'a> {
    /// Joins the names of the chunks. Names that no face uses are left out.
    pub fn join<'c>(
        input: &Input,
        chunks: &'c [Chunk<'a>],
        of: impl Fn(&'c Chunk<'a>) -> &'c [NameFrom<'a>],
    ) -> Self
    where
        'a: 'c,
    {
        let mut all: Vec<(u64, Option<&'a [u8]>)> = vec![(0, None)];
        let mut faces = 0;
        for chunk in chunks {
            for &(face, name) in of(chunk) {
                let face = faces + u64::from(face);
                // A name that is replaced before the next face is used by none.
                if all.last().is_some_and(|&(f, _)| f == face) {
                    all.pop();
                }
                if all.last().is_none_or(|&(_, n)| n != Some(name)) {
                    all.push((face, Some(name)));
                }
            }
            faces += u64::from(chunk.corners.faces());
            // The names are slices of the file: comparing them reads its pages.
            if !of(chunk).is_empty() {
                input.consumed(input.stretch(usize::MAX).min(1 << 20));
            }
        }
        all.retain(|&(face, _)| face < faces);
        let mut numbers = HashMap::new();
        let mut joined = Self { faces, ..Self::default() };
        for (face, name) in all {
            let number = name.map(|name| {
                *numbers.entry(name).or_insert_with(|| {
                    joined.names.push(name);
                    joined.names.len() as u32 - 1
                })
            });
            joined.runs.push((face, number));
        }
        joined
    }

    /// True if faces differ in their name.
    pub fn differ(&self) -> bool {
        self.runs.len() > 1
    }

    /// A value for every triangle, made from the number of its face's name.
    pub fn spread<T: Copy>(
        &self,
        triangles: usize,
        face_of_triangle: Option<&[u32]>,
        value: impl Fn(Option<u32>) -> T,
    ) -> Vec<T> {
        let mut values = Vec::with_capacity(triangles);
        let ends = self.runs.iter().skip(1).map(|&(face, _)| face).chain([self.faces]);
        for (&(_, number), end) in self.runs.iter().zip(ends) {
            let end = match face_of_triangle {
                Some(faces) => faces.partition_point(|&f| u64::from(f) < end),
                None => (end as usize).min(triangles),
            };
            values.resize(end.max(values.len()), value(number));
        }
        values.resize(triangles, value(None));
        values
    }
}

/// A name as text; a line continuation inside it counts as a blank.
pub fn text(name: &[u8]) -> String {
    let text = String::from_utf8_lossy(name);
    if text.contains('\n') {
        text.replace('\\', " ").split_whitespace().collect::<Vec<_>>().join(" ")
    } else {
        text.into()
    }
}
