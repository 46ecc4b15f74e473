//! `cargo xtask beside`: tercio's pictures beside those of a ray tracer, POV-Ray.
//!
//! Both draw the same scenes ([`scenes`]) with the same formulas for light ([`povray`] says how), so that what differs
//! is the work of rasterization: interpolation, filters, shadow maps, blending.

mod measure;
mod meshes;
mod povray;
mod scenes;
mod sheet;
mod tercio;

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Context as _, Result, bail, ensure};
use tercio_testkit::workspace_root;

use crate::{packages, process};
use measure::Measured;
use scenes::SCENES;

/// Arguments of `cargo xtask beside`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Draw these scenes only
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// The program to compare, instead of one built from this checkout
    #[arg(long, value_name = "PROGRAM")]
    tercio: Option<PathBuf>,
    /// Folder of the scenes and whole pictures [default: beside/ in cargo's target folder]
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
    /// Write the table and the small pictures into docs, too
    #[arg(long, conflicts_with = "only")]
    accept: bool,
}

/// Pixels of the pictures.
const SIZE: (u32, u32) = (640, 480);
/// The page that has the table, and the lines between which it is.
const PAGE: &str = "docs/beside-a-ray-tracer.md";
const MARKS: [&str; 2] =
    ["<!-- The table of `cargo xtask beside --accept`: -->\n", "<!-- End of the table -->\n"];

/// Draws all scenes with both programs, compares the pictures, and writes them side by side.
///
/// # Errors
/// POV-Ray is missing, a program fails, or a name is not that of a scene.
pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(name) = arguments.only.iter().find(|name| SCENES.iter().all(|(scene, _)| scene != name)) {
        let names: Vec<_> = SCENES.iter().map(|(name, _)| *name).collect();
        bail!("there is no scene {name}; there are {}", names.join(", "));
    }
    packages::provide(packages::RAY_TRACER);
    let version = povray::version().context("POV-Ray is needed (Debian's package povray)")?;
    let program = match &arguments.tercio {
        Some(program) => program.clone(),
        None => process::tercio()?,
    };
    let folder = match &arguments.folder {
        Some(folder) => folder.clone(),
        None => process::target_folder()?.join("beside"),
    };
    std::fs::create_dir_all(&folder)?;

    let mut table = Measured::heading();
    for (name, make) in SCENES {
        if !arguments.only.is_empty() && !arguments.only.iter().any(|only| only == name) {
            continue;
        }
        let scene = make();
        let files = scene.write(name, &folder).with_context(|| format!("writing the scene {name}"))?;
        let ours = tercio::draw(&program, &scene, &files)?;
        let theirs = povray::draw(&scene, &files)?;
        let measured = Measured::new(&ours, &theirs, scene.background)?;
        eprintln!("{name}: {measured}");
        let _ = writeln!(table, "{}", measured.row(scene.title));
        let sheet = sheet::side_by_side(&ours, &theirs.encoded());
        sheet.write(folder.join(format!("{name}.png")))?;
        if arguments.accept && scene.is_shown {
            sheet::halved(&sheet).write(workspace_root().join(format!("docs/images/beside-{name}.png")))?;
        }
    }
    let _ = writeln!(table, "\n{version}, {}x{} pixels.", SIZE.0, SIZE.1);
    println!("{table}");
    println!("written: {}", folder.display());
    if arguments.accept { accept(&table) } else { Ok(()) }
}

/// Replaces the table of the page.
fn accept(table: &str) -> Result<()> {
    let page = workspace_root().join(PAGE);
    let text = std::fs::read_to_string(&page).with_context(|| format!("reading {PAGE}"))?;
    let parts =
        text.split_once(MARKS[0]).and_then(|(before, rest)| Some((before, rest.split_once(MARKS[1])?.1)));
    ensure!(parts.is_some(), "{PAGE} has no place for the table");
    let (before, after) = parts.unwrap_or_default();
    Ok(std::fs::write(page, format!("{before}{}\n{table}\n{}{after}", MARKS[0], MARKS[1]))?)
}

/// Linear light as a level of sRGB.
fn level(light: f64) -> u8 {
    (tercio_scene::color::linear_to_srgb(light.clamp(0.0, 1.0)) * 255.0).round() as u8
}
