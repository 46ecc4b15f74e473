//! `tercio compare`: how much two pictures differ.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use tercio::image::{Destination, Difference, Picture, PictureFormat, Similarity, compare, similarity};

use crate::args::values;
use crate::named_files::NamedFiles;
use crate::output::{UsageError, write_picture, write_text};
use crate::report::grouped;
use crate::{memory, threads};

/// Reports how much two pictures differ.
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
    /// A picture: PNG, PPM, WebP or JPEG; `-` for standard input.
    a: PathBuf,
    /// Another one of the same size.
    b: PathBuf,
    /// Largest difference of a component that still counts as the same, 0 to 255; 0.5 is half a step.
    #[arg(long, value_name = "STEPS", allow_negative_numbers = true, value_parser = values::steps, default_value = "0")]
    threshold: f64,
    /// Writes a picture of the differences: black where there is none, white where it is largest.
    #[arg(long, value_name = "FILE")]
    diff: Option<PathBuf>,
    /// Writes JSON with stable keys: psnr_db is null for equal pictures, ssim for pictures below 11 x 11 pixels.
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
    /// Print errors only; the exit code has the result.
    #[arg(short, long)]
    quiet: bool,
}

impl Compare {
    /// Runs the command.
    ///
    /// # Errors
    /// Pictures that cannot be read or compared.
    pub fn run(&self) -> Result<ExitCode> {
        let stdin = Path::new("-");
        if self.a == stdin && self.b == stdin {
            return Err(UsageError("standard input holds one picture only: name a file".into()).into());
        }
        memory::prepare(None);
        let pool = threads::pool(None)?;
        memory::limit(None, pool.current_num_threads());
        pool.install(|| self.compare())
    }

    fn compare(&self) -> Result<ExitCode> {
        let mut files = NamedFiles::default().reads("the picture", &self.a).reads("the picture", &self.b);
        let mut diff = None;
        if let Some(path) = &self.diff {
            let format = PictureFormat::from_path(path).ok_or_else(|| {
                UsageError(format!("{}: the extension must be .png, .ppm, .webp or .jpg", path.display()))
            })?;
            let destination = Destination::File(path.clone());
            files = files.writes("--diff", &destination);
            diff = Some((destination, format));
        }
        let files = if self.quiet { files } else { files.prints() };
        files.ready()?;
        let (a, b) = (read(&self.a)?, read(&self.b)?);
        let names = || format!("{}, {}", self.a.display(), self.b.display());
        let (difference, picture) = compare(&a, &b).with_context(names)?;
        if let Some((destination, format)) = diff {
            write_picture(&destination, &picture, format)?;
        }
        let same = difference.largest_of_all() <= self.threshold;
        if !self.quiet {
            let similarity = similarity(&a, &b).with_context(names)?;
            let text =
                if self.json { json(&difference, &similarity, same) } else { text(&difference, &similarity) };
            write_text(&Destination::Stdout, &text)?;
        }
        Ok(if same { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn read(path: &Path) -> Result<Picture<'static>> {
    let stdin = path == Path::new("-");
    let name = || if stdin { "standard input".into() } else { path.display().to_string() };
    let bytes = if stdin {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
    } else {
        fs::read(path)
    };
    Picture::from_bytes(&bytes.with_context(name)?).with_context(name)
}

fn json(d: &Difference, similarity: &Similarity, same: bool) -> String {
    let channels = |[red, green, blue, alpha]: [f64; 4]| json!({ "red": red, "green": green, "blue": blue, "alpha": alpha });
    let value = json!({
        "same": same,
        "pixels": d.pixels,
        "differing_pixels": d.differing,
        "largest_difference": d.largest_of_all(),
        "largest_differences": channels(d.largest),
        "mean_difference": d.mean_of_all(),
        "mean_differences": channels(d.mean),
        // JSON has no infinity.
        "psnr_db": similarity.psnr.is_finite().then_some(similarity.psnr),
        "ssim": similarity.ssim,
    });
    format!("{value:#}\n")
}

fn text(d: &Difference, similarity: &Similarity) -> String {
    let percent = d.differing as f64 * 100.0 / d.pixels.max(1) as f64;
    let channels = |v: [f64; 4]| {
        format!("(red {}, green {}, blue {}, alpha {})", short(v[0]), short(v[1]), short(v[2]), short(v[3]))
    };
    format!(
        "differing pixels    {} of {} ({} %)\nlargest difference  {} {}\nmean difference     {} {}\nPSNR                {}\nSSIM                {}\n",
        grouped(d.differing),
        grouped(d.pixels),
        short(percent),
        short(d.largest_of_all()),
        channels(d.largest),
        short(d.mean_of_all()),
        channels(d.mean),
        if similarity.psnr.is_finite() { format!("{:.2} dB", similarity.psnr) } else { "infinite".into() },
        similarity
            .ssim
            .map_or_else(|| "not defined below 11 x 11 pixels".into(), |ssim| format!("{ssim:.6}")),
    )
}

/// Four significant digits after the point, without trailing zeros; never 0 for a value that is not 0.
fn short(value: f64) -> String {
    if value > 0.0 && value < 1e-4 {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
