//! Files of other kinds are never taken for a model.

mod common_shared;

use std::path::{Path, PathBuf};

use common_shared::data;
use tercio_mesh::ReadError;
use tercio_mesh::io::input::Input;
use tercio_mesh::io::{ReadOptions, read, read_input};

/// Extensions of models, compressed or not.
const MODELS: [&str; 15] = [
    "ply", "obj", "stl", "off", "ply.gz", "obj.gz", "stl.gz", "off.gz", "pcd", "vtk", "vtp", "vtu", "vti",
    "vts", "vtr",
];

/// All files under a folder without an extension of a model.
fn others(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        // Fuzzing writes models without an extension.
        let is_made = ["target", ".git", "corpus", "artifacts"].contains(&&*name);
        if path.is_symlink() || is_made {
            continue;
        } else if path.is_dir() {
            others(&path, found);
        } else if !MODELS.iter().any(|m| name.ends_with(&format!(".{m}"))) {
            found.push(path);
        }
    }
}

/// Reads all of them; returns for how many the error names the format.
fn assert_rejected(files: &[PathBuf]) -> usize {
    let mut named = 0;
    let mut taken = Vec::new();
    for file in files {
        match read(file, &ReadOptions::default()) {
            Ok(model) => taken.push(format!("{}: {:?}", file.display(), model.report)),
            Err(error) => named += usize::from(matches!(error, ReadError::Unread { .. })),
        }
    }
    assert!(taken.is_empty(), "{}", taken.join("\n"));
    named
}

#[test]
fn no_volume_scene_picture_or_text_is_taken_for_a_model() {
    let Some(data) = data() else { return };
    let mut files = Vec::new();
    others(&data, &mut files);
    assert!(files.len() > 1000, "{}", files.len());
    let named = assert_rejected(&files);
    assert!(10 * named > 8 * files.len(), "only {named} of {} are named", files.len());
}

#[test]
fn no_file_of_this_repository_is_taken_for_a_model() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = vec![std::env::current_exe().unwrap()];
    others(&root, &mut files);
    assert!(files.len() > 300, "{}", files.len());
    assert_rejected(&files);
}

/// With any number in the place where STL has its facet count.
#[test]
fn no_part_of_another_file_is_taken_for_stl() {
    let Some(data) = data() else { return };
    let mut files = Vec::new();
    others(&data.join("volumes"), &mut files);
    let options = ReadOptions::default();
    let mut tried = 0;
    for file in files.iter().filter(|f| std::fs::metadata(f).unwrap().len() < 1 << 19) {
        let bytes = std::fs::read(file).unwrap();
        for facets in [0usize, 1, 7, 100].into_iter().filter(|n| 84 + 50 * n <= bytes.len()) {
            for start in (0..bytes.len() - 84 - 50 * facets + 1).step_by(4099) {
                let mut part = bytes[start..start + 84 + 50 * facets].to_vec();
                for count in [None, Some(0), Some(1), Some(facets + 1)] {
                    // A count that fits is a different case: hardly a file has one by chance.
                    if count == Some(facets) {
                        continue;
                    }
                    if let Some(count) = count {
                        part[80..84].copy_from_slice(&(count as u32).to_le_bytes());
                    }
                    let Ok(input) = Input::from_bytes("part", part.clone(), &options) else { continue };
                    let result = read_input(&input, &options);
                    assert!(result.is_err(), "{} from {start}: {count:?}, {facets} facets", file.display());
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 1000, "{tried}");
}
