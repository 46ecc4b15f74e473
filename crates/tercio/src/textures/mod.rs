//! Materials and textures of a model: from what its files state to what a renderer draws.
//!
//! [`find`] looks for the pictures that a model names, [`decode`] reads them, [`picture`] decides what their numbers
//! mean, [`bump`] makes normals from heights, [`wanted`] knows which textures are made of a picture, [`material`] converts the
//! materials, and [`load`] does it all.

mod bump;
mod decode;
mod find;
mod load;
mod material;
mod picture;
mod wanted;

use std::path::{Path, PathBuf};

pub use decode::{PanoramaFileError, TextureError, panorama_from_file, texture_from_bytes};
pub use load::{TextureOptions, TextureReport};

use crate::LoadReport;
use crate::image::StandardStream;

/// The folders in which textures of a model are looked for: that of the model; for a prepared model also that of the model
/// that it was made from, if that still exists. None for a model that is built in or comes from standard input.
pub fn texture_folders(model: impl AsRef<Path>, report: &LoadReport) -> Vec<PathBuf> {
    let model = model.as_ref();
    let is_builtin = model.to_str().is_some_and(|name| name.starts_with("builtin:"));
    if is_builtin || model.as_os_str() == "-" || StandardStream::from_path(model).is_some() {
        return Vec::new();
    }
    let origin =
        report.prepared.as_ref().map(|origin| Path::new(&origin.model)).filter(|path| path.is_file());
    let mut folders: Vec<PathBuf> = Vec::new();
    for folder in [Some(model), origin].into_iter().flatten().filter_map(Path::parent) {
        if !folders.iter().any(|known| known == folder) {
            folders.push(folder.into());
        }
    }
    folders
}
