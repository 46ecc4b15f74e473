//! Other files that a model refers to: material libraries and textures.

use std::path::{Path, PathBuf};

/// Most file names that are remembered.
pub const MOST: usize = 1 << 12;

/// The path relative to the model, with the separators of this system. An absolute path comes from another machine:
/// only its last component is used.
pub fn relative(name: &str) -> String {
    let name = name.trim_matches('"').replace('\\', "/");
    let absolute = name.starts_with('/') || name.get(1..2) == Some(":");
    match name.rsplit_once('/') {
        Some((_, last)) if absolute => last.into(),
        _ => name,
    }
}

/// The existing file of this machine that an absolute path names, if any. It is not read, but an output must not
/// overwrite it.
pub fn absolute(name: &str) -> Option<PathBuf> {
    let path = Path::new(name.trim_matches('"'));
    (path.is_absolute() && path.is_file()).then(|| path.into())
}

/// Records the files that a file in `folder` names: where they would be looked for, and those that an absolute path
/// names.
pub fn note<'n>(companions: &mut Vec<PathBuf>, folder: &Path, names: impl Iterator<Item = &'n String>) {
    let room = MOST.saturating_sub(companions.len());
    let places = |name: &String| [Some(folder.join(relative(name))), absolute(name)].into_iter().flatten();
    companions.extend(names.take(room).flat_map(places).take(room));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_paths_of_existing_files_are_recorded() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let there = elsewhere.path().join("t.png");
        std::fs::write(&there, "").unwrap();
        let names = [&there, &elsewhere.path().join("no.png")].map(|p| p.to_str().unwrap().to_owned());
        let mut noted = Vec::new();
        note(&mut noted, folder.path(), names.iter());
        assert_eq!(noted, [folder.path().join("t.png"), there, folder.path().join("no.png")]);
    }

    #[test]
    fn paths_of_other_machines_are_reduced_to_their_last_component() {
        assert_eq!(relative("C:\\models\\a b.mtl"), "a b.mtl");
        assert_eq!(relative("/etc/passwd"), "passwd");
        assert_eq!(relative("..\\m\\a.mtl"), "../m/a.mtl");
    }
}
