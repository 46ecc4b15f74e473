//! Material libraries (MTL): names, diffuse colours, opacities and diffuse textures.
//!
//! Nothing in a material library prevents a model from being drawn, so errors become warnings.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::io::companions::{self, absolute, relative};
use crate::mesh::FileMaterial;

use super::lines::{Lines, join};
use super::transcode;

/// A larger file is not read: it is not a material library.
const MAX_BYTES: u64 = 1 << 28;

/// Statements other than `map_Kd` that name a texture: those of the manual, and those that programs have added.
const OTHER_TEXTURES: [&[u8]; 16] = [
    b"map_Ka",
    b"map_Ks",
    b"map_Ke",
    b"map_Ns",
    b"map_d",
    b"map_Tr",
    b"map_Bump",
    b"bump",
    b"disp",
    b"decal",
    b"refl",
    b"norm",
    b"map_Pr",
    b"map_Pm",
    b"map_Ps",
    b"map_RMA",
];

/// Diffuse colour of a material that does not state one.
const DIFFUSE: [f32; 3] = [0.8; 3];

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
                let textures = self.materials[before..].iter();
                let textures = textures.flat_map(|m| m.diffuse_texture.iter().chain(&m.other_textures));
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

/// A material that is being read.
struct Draft {
    material: FileMaterial,
    /// Whether `d` was found in the file: it takes precedence over `Tr`, whose meaning exporters do not agree on.
    has_d: bool,
}

/// Parses a library and appends its materials; if a name exists already, its first definition is kept.
pub fn parse(library: &str, text: &[u8], materials: &mut Vec<FileMaterial>, warnings: &mut Vec<String>) {
    let mut broken = Vec::new();
    let mut draft: Option<Draft> = None;
    let mut scratch = Vec::new();
    for line in Lines::new(text, 1) {
        let text = if line.continued { join(line.text, &mut scratch) } else { line.text }.trim_ascii();
        let keyword = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let value = text.get(keyword.len()..).unwrap_or_default().trim_ascii();
        if keyword == b"newmtl" {
            materials.extend(draft.take().map(|d| d.material));
            draft = Some(Draft {
                material: FileMaterial {
                    name: String::from_utf8_lossy(value).into_owned(),
                    diffuse: DIFFUSE,
                    opacity: 1.0,
                    diffuse_texture: None,
                    other_textures: Vec::new(),
                },
                has_d: false,
            });
            continue;
        }
        if let Some(draft) = draft.as_mut().filter(|d| d.material.other_textures.len() < companions::MOST)
            && OTHER_TEXTURES.iter().any(|k| keyword.eq_ignore_ascii_case(k))
        {
            draft.material.other_textures.extend(texture_name(&String::from_utf8_lossy(value)));
            continue;
        }
        let understood = match (keyword, &mut draft) {
            (b"Kd" | b"d" | b"Tr" | b"map_Kd", Some(draft)) => statement(draft, keyword, value),
            (b"Kd" | b"d" | b"Tr" | b"map_Kd", None) => false,
            _ => true,
        };
        if !understood {
            broken.push(line.number);
        }
    }
    materials.extend(draft.map(|d| d.material));
    if let Some(first) = broken.first() {
        let more = match broken.len() - 1 {
            0 => String::new(),
            n => format!(" and in {n} more"),
        };
        warnings.push(format!(
            "did not understand the value in line {first} of the material library \"{library}\"{more}"
        ));
    }
}

/// Applies one statement; false if its value is invalid.
fn statement(draft: &mut Draft, keyword: &[u8], value: &[u8]) -> bool {
    let material = &mut draft.material;
    let unit = |x: f32| x.clamp(0.0, 1.0);
    match keyword {
        b"Kd" => match numbers(value) {
            Some(rgb) => match rgb[..] {
                [r, g, b, ..] => material.diffuse = [r, g, b].map(unit),
                [grey] => material.diffuse = [unit(grey); 3],
                _ => return false,
            },
            None => return false,
        },
        b"d" | b"Tr" => {
            let value = value.strip_prefix(b"-halo").unwrap_or(value);
            let Some(&[x, ..]) = numbers(value).as_deref() else { return false };
            if keyword == b"d" {
                material.opacity = unit(x);
                draft.has_d = true;
            } else if !draft.has_d {
                // An invisible material makes no sense: programs that write 1, such as MeshLab, mean opaque.
                material.opacity = if x >= 1.0 { 1.0 } else { unit(1.0 - x) };
            }
        }
        _ => match texture_name(&String::from_utf8_lossy(value)) {
            Some(name) => material.diffuse_texture = Some(name),
            None => return false,
        },
    }
    true
}

/// All words as finite numbers, or none.
fn numbers(value: &[u8]) -> Option<Vec<f32>> {
    value
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
        .take_while(|w| !w.starts_with(b"#"))
        .map(|w| fast_float2::parse::<f32, _>(w).ok().filter(|x| x.is_finite()))
        .collect()
}

/// The file name after the options of a texture statement; it may hold blanks.
fn texture_name(value: &str) -> Option<String> {
    let is_number = |word: &str| fast_float2::parse::<f32, _>(word).is_ok();
    let mut rest = value.trim();
    while let Some((option, after)) = rest.split_once(char::is_whitespace).filter(|(o, _)| o.starts_with('-'))
    {
        // How many words follow, and whether fewer are allowed if they are not numbers.
        let (most, numeric) = match option.to_ascii_lowercase().as_str() {
            "-o" | "-s" | "-t" => (3, true),
            "-mm" => (2, true),
            "-bm" | "-boost" | "-texres" => (1, true),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-type" | "-colorspace" => (1, false),
            // No option: a file name that begins with a minus sign.
            _ => break,
        };
        rest = after.trim_start();
        for _ in 0..most {
            match rest.split_once(char::is_whitespace) {
                Some((word, after)) if !numeric || is_number(word) => rest = after.trim_start(),
                _ => break,
            }
        }
    }
    (!rest.is_empty()).then(|| rest.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (Vec<FileMaterial>, Vec<String>) {
        let (mut materials, mut warnings) = (Vec::new(), Vec::new());
        parse("a.mtl", text.as_bytes(), &mut materials, &mut warnings);
        (materials, warnings)
    }

    #[test]
    fn colours_opacities_and_textures_are_read() {
        let (m, w) = parsed(
            "# c\nnewmtl red paint\nKd 1 0.5 0\nd 0.25\nTr 0.9\nmap_Kd -s 1 1 1 -o 0.5 -clamp on my tex.png\n\
             newmtl b\r\nTr 0.25\r\nKd 0.5\r\nNs 3\nmap_Kd -type sphere a.jpg",
        );
        assert_eq!(w, [""; 0]);
        assert_eq!(m[0].name, "red paint");
        assert_eq!(m[0].diffuse, [1.0, 0.5, 0.0]);
        assert_eq!(m[0].opacity, 0.25);
        assert_eq!(m[0].diffuse_texture.as_deref(), Some("my tex.png"));
        assert_eq!((m[1].opacity, m[1].diffuse), (0.75, [0.5; 3]));
        assert_eq!(m[1].diffuse_texture.as_deref(), Some("a.jpg"));
    }

    #[test]
    fn a_transparency_of_one_means_opaque() {
        let (m, _) =
            parsed("newmtl a\nTr 1.000000\nnewmtl b\nTr 0\nnewmtl c\nTr 0.75\nnewmtl d\nd 0\nTr 1\n");
        assert_eq!(m.iter().map(|m| m.opacity).collect::<Vec<_>>(), [1.0, 1.0, 0.25, 0.0]);
    }

    #[test]
    fn all_textures_are_recorded() {
        let (m, w) = parsed(
            "newmtl a\nmap_Kd a.png\nmap_Bump -bm 0.5 b b.png\nrefl -type sphere c.png\nmap_d\nnorm d.png\n",
        );
        assert_eq!((m[0].diffuse_texture.as_deref(), w.len()), (Some("a.png"), 0));
        assert_eq!(m[0].other_textures, ["b b.png", "c.png", "d.png"]);
    }

    #[test]
    fn broken_values_are_reported_once_and_change_nothing() {
        let (m, w) = parsed("Kd 1 1 1\nnewmtl a\nKd x 0 0\nKd nan 0 0\nd\nmap_Kd\n");
        assert_eq!(m[0].diffuse, DIFFUSE);
        assert_eq!(w.len(), 1);
        assert!(w[0].contains("line 1 of") && w[0].contains("4 more"), "{w:?}");
    }

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
