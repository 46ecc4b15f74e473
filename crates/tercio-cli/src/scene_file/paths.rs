//! Names of files in files of settings: relative to these.

use std::path::{Component, Path, PathBuf};

use tercio::scene::color_map::ColorMap;
use tercio::scene_file::Value;

use super::definition::Definition;
use crate::args::color_list::color_list;

/// Options whose values are names of files.
const FILES: [&str; 8] =
    ["output", "output-depth", "output-ids", "output-normals", "stats", "trace", "camera-path", "save-scene"];

/// Whether the value of an option names a file.
pub fn is_file(option: &str, text: &str) -> bool {
    match option {
        "environment" => text != "gradient" && !text.starts_with("gradient:"),
        "colormap" => ColorMap::named(text).is_none() && color_list(text).is_none(),
        _ => FILES.contains(&option),
    }
}

/// Whether a name is one of the file system, not of a stream or a built-in model.
fn is_relative(name: &str) -> bool {
    name != "-" && !name.starts_with("builtin:") && Path::new(name).is_relative()
}

/// A model that a file in `folder` names.
pub fn model(name: &str, folder: &Path) -> PathBuf {
    if is_relative(name) { folder.join(name) } else { name.into() }
}

/// The value of a setting of a file in `folder`.
pub fn resolved(option: &str, value: &Value, folder: &Path, definition: &Definition) -> Value {
    let long = definition.find(option).and_then(|option| option.get_long()).unwrap_or(option);
    match value {
        Value::Text(text) if is_file(long, text) => {
            Value::Text(model(text, folder).to_string_lossy().into_owned())
        }
        other => other.clone(),
    }
}

/// The name of a file for files in `folder`, both relative to the current folder.
pub fn relative(path: &Path, folder: &Path) -> PathBuf {
    let is_name = path.to_str().is_some_and(|name| !is_relative(name));
    if is_name || folder.as_os_str().is_empty() {
        return path.into();
    }
    let (Ok(path_from_root), Ok(folder)) = (std::path::absolute(path), std::path::absolute(folder)) else {
        return path.into();
    };
    let parts = |path: &Path| -> Option<Vec<std::ffi::OsString>> {
        let mut parts: Vec<std::ffi::OsString> = Vec::new();
        for component in path.components() {
            match component {
                Component::ParentDir => {
                    // From a link, .. leads elsewhere.
                    let folder: PathBuf = parts.iter().collect();
                    if std::fs::symlink_metadata(folder).is_ok_and(|m| m.file_type().is_symlink()) {
                        return None;
                    }
                    parts.pop();
                }
                Component::CurDir => {}
                other => parts.push(other.as_os_str().to_owned()),
            }
        }
        Some(parts)
    };
    let (Some(to), Some(from)) = (parts(&path_from_root), parts(&folder)) else { return path_from_root };
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let is_link = std::fs::symlink_metadata(&folder).is_ok_and(|m| m.file_type().is_symlink());
    if common < 2 || is_link && common < from.len() {
        // Nothing but the root, or drive, in common.
        return path_from_root;
    }
    let up = std::iter::repeat_n("..".into(), from.len() - common);
    up.chain(to[common..].iter().cloned()).collect::<PathBuf>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_relative_to_the_file_where_that_is_possible() {
        let check = |path: &str, folder: &str, expected: &str| {
            assert_eq!(
                relative(path.as_ref(), folder.as_ref()),
                PathBuf::from(expected),
                "{path} in {folder}"
            );
        };
        check("a.ply", "", "a.ply");
        check("a.ply", "scenes", "../a.ply");
        check("scenes/a.ply", "scenes", "a.ply");
        check("./scenes/x/a.ply", "scenes", "x/a.ply");
        check("./scenes/../b/a.ply", "b", "a.ply");
        check("scenes/../a.ply", "scenes", "../a.ply");
        check("builtin:teapot@1k", "scenes", "builtin:teapot@1k");
        check("-", "scenes", "-");
        check("/data/a.ply", "scenes", "/data/a.ply");
    }
}
