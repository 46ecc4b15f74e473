//! `tercio lab simulate`: a workload on a published machine, one file a machine.

mod hybris;
mod mcmanus;
mod ortega;
mod parks;
mod ring;
mod sorting;

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use tercio::image::Destination;
use tercio_lab::workloads::{BoxScene, PolygonScene};

use crate::named_files::NamedFiles;
use crate::output::write_text;

/// Simulates a workload exactly on a published machine.
#[derive(Debug, Args)]
pub struct Simulate {
    #[command(subcommand)]
    machine: Machine,
}

#[derive(Debug, Subcommand)]
enum Machine {
    Ring(ring::Ring),
    Sorting(sorting::Sorting),
    Hybris(hybris::Hybris),
    Parks(parks::Parks),
    Mcmanus(mcmanus::McManus),
    Ortega(ortega::Ortega),
}

impl Machine {
    /// The input files.
    fn files(&self) -> NamedFiles {
        let scene = |scene: &Path| NamedFiles::default().reads("the scene", scene);
        match self {
            Self::Ring(ring) => {
                ring.map.iter().fold(scene(&ring.scene), |files, map| files.reads("--map", map))
            }
            Self::Sorting(sorting) => scene(&sorting.scene).reads_machine(&sorting.machine),
            Self::Hybris(hybris) => {
                NamedFiles::default().reads_model(&hybris.model.model).reads_machine(&hybris.machine)
            }
            Self::Parks(parks) => scene(&parks.scene),
            Self::Mcmanus(mcmanus) => scene(&mcmanus.scene),
            Self::Ortega(ortega) => scene(&ortega.scene),
        }
    }
}

impl Simulate {
    /// Runs the subcommand.
    ///
    /// # Errors
    /// What went wrong.
    pub fn run(&self) -> Result<ExitCode> {
        let files = self.machine.files().prints();
        files.ready()?;
        let text = match &self.machine {
            Machine::Ring(machine) => machine.run()?,
            Machine::Sorting(machine) => machine.run()?,
            Machine::Hybris(machine) => machine.run(&files)?,
            Machine::Parks(machine) => machine.run()?,
            Machine::Mcmanus(machine) => machine.run()?,
            Machine::Ortega(machine) => machine.run()?,
        };
        write_text(&Destination::Stdout, &text)?;
        Ok(ExitCode::SUCCESS)
    }
}

fn is_polygons(file: &Path) -> bool {
    file.extension().is_some_and(|e| e == "polygons")
}

/// Reads boxes; from a polygon file, the polygons' bounding boxes.
fn boxes(file: &Path) -> Result<BoxScene> {
    if is_polygons(file) { Ok(PolygonScene::read(file)?.boxes()) } else { Ok(BoxScene::read(file)?) }
}

/// Reads polygons.
fn polygons(file: &Path) -> Result<PolygonScene> {
    if file.extension().is_some_and(|e| e == "boxes") {
        bail!("{}: this machine needs whole polygons, not boxes (a file .polygons)", file.display());
    }
    Ok(PolygonScene::read(file)?)
}
