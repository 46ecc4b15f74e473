//! `cargo xtask models`: the models and scenes that `cargo xtask bench` draws, as files for any program.
//!
//! The bench runs this command as a process of its own: making the largest model takes gigabytes, and the measured peak
//! memory of a process includes that of the process that started it.

pub mod formats;
mod index;
mod scenes;
mod sources;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result, bail};
use tercio_mesh::Mesh;

pub use index::{Index, Model};
pub use scenes::EDGE as PLANE_EDGE;
use sources::Sources;

use crate::process;

/// Arguments of `cargo xtask models`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of the files; created if it does not exist
    folder: PathBuf,
    /// Write these files only
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
}

/// The part of a mesh that is written.
enum Content {
    /// Binary PLY of positions and normals: what every program of the bench draws.
    Drawn(fn(&Sources) -> Result<Option<Mesh>>),
    /// Positions and triangles as in the scanned file, in a format of the first-picture table.
    Scanned(fn(&Sources) -> Result<Option<Mesh>>, formats::Writer),
}

use Content::{Drawn, Scanned};

/// The files of the folder, by the names that the bench uses.
const FILES: [(&str, Content); 15] = [
    ("bunny.ply", Drawn(Sources::bunny)),
    ("dragon.ply", Drawn(|s| s.dragon())),
    ("dragon-split-twice.ply", Drawn(|s| s.dragon_split_twice())),
    ("gyroid.ply", Drawn(|_| scenes::builtin("builtin:gyroid@5.4M"))),
    ("first/dragon-split-twice.ply", Scanned(|s| s.scanned_dragon_split_twice(), formats::write_ply)),
    ("first/dragon.ply", Scanned(|s| s.scanned_dragon(), formats::write_ply)),
    ("first/dragon-ascii.ply", Scanned(|s| s.scanned_dragon(), formats::write_ascii_ply)),
    ("first/dragon.obj", Scanned(|s| s.scanned_dragon(), formats::write_obj)),
    ("first/dragon.stl", Scanned(|s| s.scanned_dragon(), formats::write_stl)),
    ("layers-back-to-front.ply", Drawn(|_| Ok(Some(scenes::layers(false))))),
    ("layers-front-to-back.ply", Drawn(|_| Ok(Some(scenes::layers(true))))),
    ("slivers.ply", Drawn(|_| Ok(Some(scenes::slivers())))),
    ("dragon-shuffled.ply", Drawn(|s| Ok(s.dragon()?.map(scenes::shuffled)))),
    ("one-a-tile.ply", Drawn(|_| Ok(Some(scenes::one_a_cell())))),
    ("sphere.ply", Drawn(|_| scenes::builtin("builtin:sphere@1k"))),
];

/// Writes the files and their index. Files that need a scanned model are skipped where `../shared` is absent.
///
/// # Errors
/// A name that is not known, a model that cannot be read, or a file that cannot be written.
pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(name) = arguments.only.iter().find(|name| FILES.iter().all(|(file, _)| file != name)) {
        let names: Vec<_> = FILES.iter().map(|(file, _)| *file).collect();
        bail!("there is no file {name}; there are {}", names.join(", "));
    }
    std::fs::create_dir_all(arguments.folder.join("first"))?;
    let sources = Sources::find();
    let mut index = Index::default();
    for (name, content) in &FILES {
        if !arguments.only.is_empty() && !arguments.only.iter().any(|only| only == name) {
            continue;
        }
        let path = arguments.folder.join(name);
        let (mesh, write) = match content {
            Drawn(make) => (make(&sources)?, formats::write_ply as formats::Writer),
            Scanned(make, write) => (make(&sources)?, *write),
        };
        let Some(mesh) = mesh else {
            eprintln!("{name}: skipped, its model is in ../shared, which is absent");
            continue;
        };
        write(&mesh, &path).with_context(|| format!("writing {}", path.display()))?;
        index.add(name, &path, &mesh)?;
    }
    index.write(&arguments.folder)
}

/// Runs a process of its own that writes these files into a folder.
///
/// # Errors
/// As [`run`].
pub fn prepare(folder: &Path, names: &[&str]) -> Result<Index> {
    let mut command = Command::new(std::env::current_exe()?);
    process::run(command.arg("models").arg(folder).arg("--only").arg(names.join(",")))?;
    Index::read(folder)
}
