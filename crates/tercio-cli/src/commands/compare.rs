//! `tercio compare`: how much two pictures differ.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Args;
use tercio::image::{Destination, Difference, Picture, PictureFormat, compare};

use crate::args::values;
use crate::output::{UsageError, write_text};
use crate::report::grouped;
use crate::{memory, threads};

/// Tells how much two pictures differ.
#[derive(Debug, Args)]
#[command(after_help = "\
Differences are counted in steps of 8-bit components, 0 to 255, between 16-bit pictures in fractions
of them. A picture without transparency counts as opaque.

Examples:
  tercio compare before.png after.png
  tercio compare a.png b.png --threshold 2 --diff diff.png

Exit code: 0 if no component differs by more than the threshold, 1 if one does, 2 on errors (also for
pictures of different sizes).")]
pub struct Compare {
    /// A picture: PNG, PPM or WebP.
    a: PathBuf,
    /// Another one of the same size.
    b: PathBuf,
    /// Largest difference of a component that still counts as the same.
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true, value_parser = values::not_negative, default_value = "0")]
    threshold: f64,
    /// Writes a picture of the differences: black where there is none, white where it is largest.
    #[arg(long, value_name = "FILE")]
    diff: Option<PathBuf>,
    /// Say nothing but errors; the exit code tells.
    #[arg(short, long)]
    quiet: bool,
}

impl Compare {
    /// Runs the command.
    ///
    /// # Errors
    /// Pictures that cannot be read or compared.
    pub fn run(&self) -> Result<ExitCode> {
        memory::prepare(None);
        let pool = threads::pool(None)?;
        memory::limit(None, pool.current_num_threads());
        pool.install(|| self.compare())
    }

    fn compare(&self) -> Result<ExitCode> {
        if let Some(path) = &self.diff {
            let name = || path.display().to_string();
            if PictureFormat::of_path(path).is_none() {
                let text = format!("{}: the extension must be .png, .ppm or .webp", name());
                return Err(UsageError(text).into());
            }
            Destination::File(path.clone()).check().with_context(name)?;
        }
        let (a, b) = (read(&self.a)?, read(&self.b)?);
        let names = || format!("{}, {}", self.a.display(), self.b.display());
        let (difference, picture) = compare(&a, &b).with_context(names)?;
        if let Some(path) = &self.diff {
            picture.save(path).with_context(|| path.display().to_string())?;
        }
        let same = difference.largest_of_all() <= self.threshold;
        if !self.quiet {
            write_text(&Destination::Stdout, &text(&difference))?;
        }
        Ok(if same { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn read(path: &Path) -> Result<Picture<'static>> {
    let name = || path.display().to_string();
    let bytes = fs::read(path).with_context(name)?;
    Picture::read(&bytes).with_context(name)
}

fn text(d: &Difference) -> String {
    let percent = d.differing as f64 * 100.0 / d.pixels.max(1) as f64;
    let channels = |v: [f64; 4]| {
        format!("(red {}, green {}, blue {}, alpha {})", short(v[0]), short(v[1]), short(v[2]), short(v[3]))
    };
    format!(
        "differing pixels    {} of {} ({} %)\nlargest difference  {} {}\nmean difference     {} {}\n",
        grouped(d.differing),
        grouped(d.pixels),
        short(percent),
        short(d.largest_of_all()),
        channels(d.largest),
        short(d.mean_of_all()),
        channels(d.mean),
    )
}

/// Four digits behind the point, zeros at the end left out; never 0 for something that is not.
fn short(value: f64) -> String {
    if value > 0.0 && value < 1e-4 {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
