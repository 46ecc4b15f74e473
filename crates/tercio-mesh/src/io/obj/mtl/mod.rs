//! Material libraries (MTL): colours, opacities, highlights and textures.
//!
//! Nothing in a material library prevents a model from being drawn, so errors become warnings.

mod ignored;
mod statements;
mod texture;

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::transcode;
use crate::FileMaterial;
use crate::io::companions::{self, absolute, relative};
use statements::parse;

/// A larger file is not read: it is not a material library.
const MAX_BYTES: u64 = 1 << 28;

/// No file system allows longer names.
const LONGEST_NAME: usize = 4096;

/// Most file-system queries for one model; each takes as long as parsing a hundred lines.
const MAX_FILE_QUERIES: usize = 8192;

/// The libraries of one model.
pub struct Libraries<'a> {
    base: &'a Path,
    /// The libraries that are loaded already, by their canonical paths.
    loaded: HashSet<PathBuf>,
    queries_left: usize,
    /// Their materials.
    pub materials: Vec<FileMaterial>,
}

impl<'a> Libraries<'a> {
    /// No libraries yet; names are relative to the folder `base`.
    pub fn new(base: &'a Path) -> Self {
        Self { base, loaded: HashSet::new(), queries_left: MAX_FILE_QUERIES, materials: Vec::new() }
    }

    /// Loads the libraries that one `mtllib` line names.
    ///
    /// Several names are separated by blanks, but names may hold blanks too, so the longest run of words that is a
    /// file wins. Only files in `base` or reached from it by a relative path are opened.
    ///
    /// The libraries and the textures that they name are recorded in `companions`.
    pub fn load(&mut self, names: &[u8], companions: &mut Vec<PathBuf>, warnings: &mut Vec<String>) {
        // Each run of words is looked up in the file system; the limit keeps a hostile line from causing millions of
        // look-ups.
        const MOST_WORDS: usize = 64;
        let names = String::from_utf8_lossy(names);
        let words: Vec<&str> = names.split_whitespace().take(MOST_WORDS).collect();
        let mut first = 0;
        while first < words.len() {
            let mut length = 0;
            let ends = (first + 1..=words.len()).take_while(|&end| {
                length += words[end - 1].len() + 1;
                length <= LONGEST_NAME
            });
            let ends: Vec<usize> = ends.collect();
            let run = ends.into_iter().rev().find_map(|end| {
                let name = words[first..end].join(" ");
                self.is_file(&name).then_some((name, end))
            });
            match run {
                Some((name, end)) => {
                    self.load_one(&name, companions, warnings);
                    first = end;
                }
                None => {
                    let len = words[first..].iter().position(|w| w.to_ascii_lowercase().ends_with(".mtl"));
                    let end = len.map_or(words.len(), |n| first + n + 1);
                    let name = words[first..end].join(" ");
                    companions.extend(absolute(&name));
                    warnings.push(format!("found no material library \"{}\"", shortened(name)));
                    first = end;
                }
            }
        }
    }

    /// Records the files that one `mtllib` line names in `companions` without reading them.
    pub fn note_unread(&self, names: &[u8], companions: &mut Vec<PathBuf>) {
        if names.len() > LONGEST_NAME {
            return;
        }
        let names = String::from_utf8_lossy(names);
        let words: Vec<String> = names.split_whitespace().map(str::to_owned).collect();
        // It is not checked which of them are files, so the line may be one name or several.
        let whole = words.join(" ");
        let single = if words.len() > 1 { &words[..] } else { &[] };
        companions::note(companions, self.base, std::iter::once(&whole).chain(single));
    }

    fn is_file(&mut self, name: &str) -> bool {
        if self.queries_left == 0 {
            return false;
        }
        self.queries_left -= 1;
        fs::metadata(self.base.join(relative(name))).is_ok_and(|m| m.is_file())
    }

    fn load_one(&mut self, name: &str, companions: &mut Vec<PathBuf>, warnings: &mut Vec<String>) {
        let path = self.base.join(relative(name));
        let elsewhere = absolute(name);
        // A library that was loaded already, under whatever name, adds nothing.
        if let Ok(place) = fs::canonicalize(&path)
            && !self.loaded.insert(place)
        {
            companions.extend(elsewhere);
            return;
        }
        // Also one that is not read: an output must not replace it.
        companions.push(path.clone());
        companions.extend(elsewhere);
        match fs::metadata(&path) {
            Ok(m) if m.len() > MAX_BYTES => {
                warnings.push(format!("did not read the material library \"{name}\": it is too large"));
                return;
            }
            _ => {}
        }
        match fs::read(&path) {
            Ok(bytes) => {
                let before = self.materials.len();
                parse(name, &transcode::convert(&bytes), &mut self.materials, warnings);
                let folder =
                    relative(name).rsplit_once('/').map_or(String::new(), |(folder, _)| folder.into());
                let new = &mut self.materials[before..];
                new.iter_mut().for_each(|material| material.folder.clone_from(&folder));
                let textures = new.iter().flat_map(FileMaterial::texture_files);
                companions::note(companions, path.parent().unwrap_or(self.base), textures);
            }
            Err(e) => warnings.push(format!("did not read the material library \"{name}\": {e}")),
        }
    }
}

/// Shortens a name for a message.
fn shortened(name: String) -> String {
    const MOST: usize = 200;
    match name.char_indices().nth(MOST) {
        Some((at, _)) => format!("{}…", &name[..at]),
        None => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_that_are_not_read_are_recorded() {
        let folder = tempfile::tempdir().unwrap();
        let large = fs::File::create(folder.path().join("large.mtl")).unwrap();
        // A sparse file, which takes no room on the disk.
        large.set_len(MAX_BYTES + 1).unwrap();
        let mut libraries = Libraries::new(folder.path());
        let (mut companions, mut warnings) = (Vec::new(), Vec::new());
        libraries.load(b"large.mtl", &mut companions, &mut warnings);
        assert!(warnings[0].ends_with("it is too large"), "{warnings:?}");
        assert_eq!(companions, [folder.path().join("large.mtl")]);
        companions.clear();
        libraries.note_unread(b"a.mtl  b.mtl", &mut companions);
        assert_eq!(companions, ["a.mtl b.mtl", "a.mtl", "b.mtl"].map(|name| folder.path().join(name)));
    }

    #[test]
    fn textures_and_libraries_with_absolute_names_are_recorded() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let there = |name: &str| elsewhere.path().join(name);
        for name in ["t.png", "a.mtl", "b.mtl"] {
            fs::write(there(name), "").unwrap();
        }
        let library = format!("newmtl a\nmap_Kd {}\n", there("t.png").display());
        fs::write(folder.path().join("a.mtl"), library).unwrap();
        let mut libraries = Libraries::new(folder.path());
        let mut companions = Vec::new();
        for name in ["a.mtl", "b.mtl"] {
            libraries.load(there(name).to_str().unwrap().as_bytes(), &mut companions, &mut Vec::new());
        }
        let here = |name: &str| folder.path().join(name);
        let expected = [here("a.mtl"), there("a.mtl"), here("t.png"), there("t.png"), there("b.mtl")];
        assert_eq!(companions, expected);
    }

    #[test]
    fn a_library_is_read_once_whatever_it_is_called() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a b.mtl"), "newmtl red\n").unwrap();
        let mut libraries = Libraries::new(folder.path());
        let mut warnings = Vec::new();
        for names in ["a b.mtl", "./a b.mtl ././a b.mtl", "a b.mtl a b.mtl", &"./a b.mtl ".repeat(2000)] {
            libraries.load(names.as_bytes(), &mut Vec::new(), &mut warnings);
        }
        assert_eq!((libraries.materials.len(), warnings.len()), (1, 0));
        let queries = MAX_FILE_QUERIES - libraries.queries_left;
        assert!(queries < 3000, "{queries} queries");
        // A word of a megabyte is not a name; trying all runs of such words would copy gigabytes.
        libraries.load(&vec![b'a'; 1 << 20], &mut Vec::new(), &mut warnings);
        assert!(warnings[0].len() < 300, "{} bytes", warnings[0].len());
        assert_eq!(MAX_FILE_QUERIES - libraries.queries_left, queries);
        for _ in 0..MAX_FILE_QUERIES {
            libraries.load(b"missing.mtl", &mut Vec::new(), &mut warnings);
        }
        assert_eq!(libraries.queries_left, 0);
    }
}
