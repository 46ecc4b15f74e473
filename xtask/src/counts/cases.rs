//! The cases that are counted. All run in one thread and at the AVX2 level, the widest that valgrind supports.

use std::path::Path;

use anyhow::{Context as _, Result};

use super::callgrind;
use crate::models::formats::{self, Writer};

/// A model and what is done with it.
pub enum Case {
    /// A frame of `tercio bench` of a built-in model, in a square picture.
    Frame { model: &'static str, size: u32, aa: &'static str },
    /// From a file of a built-in model, without normals, to a picture so small that reading the file dominates.
    File { model: &'static str, file: &'static str, write: Writer },
    /// From a small built-in model to a PNG.
    Png { model: &'static str, size: &'static str },
}

/// Small triangles, large triangles, many layers; the first two with several samples per pixel; each reader; the PNG writer.
pub const CASES: [Case; 10] = [
    Case::Frame { model: "builtin:sphere@100k", size: 256, aa: "1" },
    Case::Frame { model: "builtin:teapot@2k", size: 512, aa: "1" },
    Case::Frame { model: "builtin:gyroid@100k", size: 256, aa: "1" },
    Case::Frame { model: "builtin:sphere@100k", size: 256, aa: "4" },
    Case::Frame { model: "builtin:teapot@2k", size: 512, aa: "4" },
    Case::File { model: "builtin:gyroid@50k", file: "binary.ply", write: formats::write_ply },
    Case::File { model: "builtin:gyroid@50k", file: "ascii.ply", write: formats::write_ascii_ply },
    Case::File { model: "builtin:gyroid@50k", file: "text.obj", write: formats::write_obj },
    Case::File { model: "builtin:gyroid@50k", file: "binary.stl", write: formats::write_stl },
    Case::Png { model: "builtin:sphere@1k", size: "1280x720" },
];

/// Options that make a run the same each time.
const FIXED: [&str; 5] = ["--threads", "1", "--simd", "avx2", "--quiet"];

impl Case {
    /// Names and instruction counts.
    ///
    /// # Errors
    /// The program does not run.
    pub fn count(&self, tercio: &Path, folder: &Path) -> Result<Vec<(String, u64)>> {
        match *self {
            Self::Frame { model, size, aa } => {
                let samples = if aa == "1" { String::new() } else { format!(", {aa} samples a pixel") };
                let name = format!("{size}x{size} of {model}{samples}");
                let counts = frame(tercio, folder, model, size, aa).with_context(|| name.clone())?;
                Ok(vec![(format!("making {name}"), counts.making), (format!("frame {name}"), counts.frame)])
            }
            Self::File { model, file, write } => {
                let name = format!("reading {file} of {model}");
                let mut mesh = tercio_mesh::builtin::make(model)?;
                mesh.normals = None;
                write(&mesh, &folder.join(file))?;
                let arguments =
                    [&["render", file, "-o", "picture.ppm", "--size", "8x8", "--aa", "1"], &FIXED[..]]
                        .concat();
                Ok(vec![(name.clone(), callgrind::count(tercio, &arguments, folder).context(name)?)])
            }
            Self::Png { model, size } => {
                let name = format!("PNG of {size} of {model}");
                let arguments =
                    [&["render", model, "-o", "picture.png", "--size", size, "--aa", "1"], &FIXED[..]]
                        .concat();
                Ok(vec![(name.clone(), callgrind::count(tercio, &arguments, folder).context(name)?)])
            }
        }
    }
}

struct FrameCounts {
    /// All before the views: loading the model, making its clusters, the first two frames.
    making: u64,
    /// One frame, the mean of several views.
    frame: u64,
}

/// Two runs that differ only in their number of views, so their difference is the cost of the additional views. Both
/// draw the first view.
fn frame(tercio: &Path, folder: &Path, model: &str, size: u32, aa: &str) -> Result<FrameCounts> {
    const VIEWS: u64 = 5;
    let size = format!("{size}x{size}");
    let run = |views: u64| {
        let views = views.to_string();
        let arguments = ["bench", model, "--size", &size, "--frames", &views, "--aa", aa];
        callgrind::count(tercio, &[&arguments, &FIXED[..]].concat(), folder)
    };
    let (making, all) = (run(1)?, run(VIEWS)?);
    Ok(FrameCounts { making, frame: all.saturating_sub(making) / (VIEWS - 1) })
}
