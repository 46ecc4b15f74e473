//! Names that apply from one face, line or point up to the next name: materials, groups, objects.

use std::collections::HashMap;

use super::parse::{Chunk, NameFrom};
use crate::io::input::Input;

/// Names of all elements of the file of one kind: faces, segments or points.
#[derive(Debug, Default)]
pub struct Names<'a> {
    /// Different names in the order of their first use.
    pub names: Vec<&'a [u8]>,
    /// First element and number of the name (`None` for no name); elements strictly increase.
    runs: Vec<(u64, Option<u32>)>,
    elements: u64,
}

impl<'a> Names<'a> {
    /// Joins the names of the chunks, of which each has some `count` of elements. Names that no element uses are left out.
    pub fn join<'c, N: IntoIterator<Item = NameFrom<'a>>>(
        input: &Input,
        chunks: &'c [Chunk<'a>],
        count: impl Fn(&'c Chunk<'a>) -> u64,
        of: impl Fn(&'c Chunk<'a>) -> N,
    ) -> Self
    where
        'a: 'c,
    {
        let mut all: Vec<(u64, Option<&'a [u8]>)> = vec![(0, None)];
        let mut elements = 0;
        for chunk in chunks {
            let mut has_names = false;
            for (element, name) in of(chunk) {
                has_names = true;
                let element = elements + u64::from(element);
                // A name that is replaced before the next element is used by none.
                if all.last().is_some_and(|&(e, _)| e == element) {
                    all.pop();
                }
                if all.last().is_none_or(|&(_, n)| n != Some(name)) {
                    all.push((element, Some(name)));
                }
            }
            elements += count(chunk);
            // The names are slices of the file: comparing them reads its pages.
            if has_names {
                input.consumed(input.stretch(usize::MAX).min(1 << 20));
            }
        }
        all.retain(|&(element, _)| element < elements);
        let mut numbers = HashMap::new();
        let mut joined = Self { elements, ..Self::default() };
        for (element, name) in all {
            let number = name.map(|name| {
                *numbers.entry(name).or_insert_with(|| {
                    joined.names.push(name);
                    joined.names.len() as u32 - 1
                })
            });
            joined.runs.push((element, number));
        }
        joined
    }

    /// The number of the name of an element.
    pub fn of(&self, element: usize) -> Option<u32> {
        let after = self.runs.partition_point(|&(first, _)| first <= element as u64);
        self.runs[..after].last()?.1
    }

    /// True if elements differ in their name.
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
        let ends = self.runs.iter().skip(1).map(|&(face, _)| face).chain([self.elements]);
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
