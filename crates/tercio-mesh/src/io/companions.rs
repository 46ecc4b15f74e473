//! Other files that a model names: material libraries and textures.

use std::path::{Path, PathBuf};

/// Most texture files that are remembered by name.
pub const MOST: usize = 1 << 12;

/// The path as seen from the model, with the separators of this system. An absolute path comes from another
/// machine: only its last part means something here.
pub fn relative(name: &str) -> String {
    let name = name.trim_matches('"').replace('\\', "/");
    let absolute = name.starts_with('/') || name.get(1..2) == Some(":");
    match name.rsplit_once('/') {
        Some((_, last)) if absolute => last.into(),
        _ => name,
    }
}

/// Notes the textures that a file in `folder` names.
pub fn note<'n>(companions: &mut Vec<PathBuf>, folder: &Path, names: impl Iterator<Item = &'n String>) {
    let room = MOST.saturating_sub(companions.len());
    companions.extend(names.take(room).map(|name| folder.join(relative(name))));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_other_machines_lead_to_their_last_part() {
        assert_eq!(relative("C:\\models\\a b.mtl"), "a b.mtl");
        assert_eq!(relative("/etc/passwd"), "passwd");
        assert_eq!(relative("..\\m\\a.mtl"), "../m/a.mtl");
    }
}
