//! Material libraries and textures of several models.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::{Error, Result, anyhow};
use tercio::mesh::io::{self, ReadReport};
use tercio::{LoadOptions, texture_folders};

use super::{Loaded, Render};
use crate::named_files::NamedFiles;
use crate::output::modified;

impl Render {
    /// Checks, before any picture of several models is written, that none replaces a file of a model that is read later. The models
    /// are read for that only if outputs replace files at all.
    ///
    /// # Errors
    /// A usage error with both names.
    pub(super) fn check_companions(&self, files: &NamedFiles, models: &[PathBuf]) -> Result<()> {
        if !files.replaces_any() {
            return Ok(());
        }
        let options = LoadOptions { memory_limit: self.running.memory_limit(), ..LoadOptions::default() };
        for model in models {
            files.check_companions(&model.display().to_string(), &companions(model, &options))?;
        }
        Ok(())
    }
}

impl Loaded {
    /// When a file that the models name was changed last.
    pub(super) fn newest_companion(&self) -> Option<SystemTime> {
        let companions = self.reports.iter().flat_map(|model| &model.report.read.companions);
        companions.filter_map(|file| modified(file)).max()
    }
}

/// The other files of a model; of one that cannot be read, which is reported when it is drawn, those found so far.
fn companions(model: &Path, options: &LoadOptions) -> Vec<PathBuf> {
    let mut found = Vec::new();
    // A prepared model has no report of them, but its materials, and is loaded at once. Others are not loaded, only read.
    let accept = |read: &ReadReport| {
        found.clone_from(&read.companions);
        if is_prepared(model) { Ok(()) } else { Err(anyhow!("read")) }
    };
    let loaded: Result<_, Error> = options.load_if(model, accept);
    let mut folders: Vec<PathBuf> = model.parent().map(Path::to_path_buf).into_iter().collect();
    if let Ok(loaded) = loaded {
        folders = texture_folders(model, &loaded.report);
        let names = loaded.mesh.materials.iter().flat_map(|material| material.texture_files());
        let names: Vec<String> = names.map(|name| io::relative(name)).collect();
        found.extend(folders.iter().flat_map(|folder| names.iter().map(|name| folder.join(name))));
    }
    // What is not there is looked for by its last name, too.
    let missing = found.iter().filter(|path| !path.is_file()).filter_map(|path| path.file_name());
    let beside: Vec<PathBuf> = missing.flat_map(|name| folders.iter().map(move |f| f.join(name))).collect();
    found.extend(beside);
    found
}

fn is_prepared(model: &Path) -> bool {
    let read = || -> std::io::Result<bool> {
        let mut head = [0; 16];
        let mut file = std::fs::File::open(model)?;
        std::io::Read::read_exact(&mut file, &mut head)?;
        Ok(io::prepared::is_prepared(&head))
    };
    read().unwrap_or(false)
}
