//! Options of the outputs, and the plan that follows from them.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use tercio::image::{Destination, PictureFormat, WEBP_MAX_SIZE};
use tercio::raster::Outputs;

use super::drawing::DrawingArgs;
use super::stereo::StereoArgs;
use crate::mpi;
use crate::output::{Array, Plan};

/// Bits of a colour component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Depth {
    /// 8 bits.
    #[value(name = "8")]
    Eight,
    /// 16 bits.
    #[value(name = "16")]
    Sixteen,
}

/// The outputs.
#[derive(Debug, Args)]
#[command(next_help_heading = "Writing")]
pub struct WritingArgs {
    /// The picture: .png, .ppm or .webp (lossless), or `-` for standard output.
    #[arg(short, long, value_name = "FILE")]
    #[arg(required_unless_present_any = ["output_depth", "output_ids", "output_normals"])]
    output: Option<PathBuf>,
    /// Format of the picture: png, ppm or webp [default: by the extension; png for `-`].
    #[arg(long, value_name = "FORMAT", requires = "output")]
    format: Option<PictureFormat>,
    /// Bits of a colour component; 16 in PNG and PPM only.
    #[arg(long, value_name = "BITS", value_enum, default_value_t = Depth::Eight)]
    depth: Depth,
    /// Distance from the eye along the camera's axis (not along each pixel's ray), NPY float32 (H, W), infinite where
    /// nothing was drawn.
    #[arg(long, value_name = "FILE")]
    output_depth: Option<PathBuf>,
    /// Numbers of the faces that are seen, NPY uint32 (H, W), 4294967295 where nothing was drawn.
    #[arg(long, value_name = "FILE")]
    output_ids: Option<PathBuf>,
    /// World-space unit normals that the picture is lit by, without those of normal and bump maps, on the side that is seen and never pointing away from the
    /// viewer, NPY float32 (H, W, 3), zero where nothing was drawn.
    #[arg(long, value_name = "FILE")]
    output_normals: Option<PathBuf>,
    /// Counters and timings, as JSON; `-` for standard output.
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    /// Writes pictures and arrays even if nothing of the model is visible; without it, that is an error and old files
    /// stay.
    #[arg(long)]
    pub allow_empty: bool,
}

impl WritingArgs {
    /// The outputs and their destinations.
    ///
    /// # Errors
    /// One sentence, if the options contradict each other.
    pub fn plan(&self, drawing: &DrawingArgs, stereo: &StereoArgs) -> Result<Plan, String> {
        let size = stereo.picture_size(drawing.size)?;
        let picture = match &self.output {
            Some(path) => {
                let format =
                    self.picture_format(path, &Destination::from_path(path), size, drawing.is_transparent())?;
                Some((stereo.destinations("--output", path)?, format))
            }
            None => None,
        };
        let arrays = [
            (&self.output_depth, Array::Depth),
            (&self.output_ids, Array::Ids),
            (&self.output_normals, Array::Normals),
        ];
        let arrays = arrays.into_iter().filter_map(|(path, array)| Some((path.as_ref()?, array)));
        let arrays = arrays.map(|(path, array)| Ok((stereo.destinations(array.option(), path)?, array)));
        let plan = Plan {
            outputs: Outputs {
                color: picture.is_some() && self.depth == Depth::Eight,
                color16: picture.is_some() && self.depth == Depth::Sixteen,
                depth: self.output_depth.is_some(),
                ids: self.output_ids.is_some(),
                normals: self.output_normals.is_some(),
                keys: false,
                linear: false,
            },
            picture,
            arrays: arrays.collect::<Result<_, String>>()?,
            stats: self.stats.as_deref().map(Destination::from_path),
        };
        check_terminal(&plan)?;
        Ok(plan)
    }

    fn picture_format(
        &self,
        path: &Path,
        destination: &Destination,
        (width, height): (u32, u32),
        is_transparent: bool,
    ) -> Result<PictureFormat, String> {
        // A link to standard output may have an extension, too.
        let by_name = || match destination {
            Destination::Stdout => Some(PictureFormat::from_path(path).unwrap_or(PictureFormat::Png)),
            Destination::File(path) => PictureFormat::from_path(path),
        };
        let format = self.format.or_else(by_name).ok_or_else(|| {
            format!("{}: the extension must be .png, .ppm or .webp (or give --format)", path.display())
        })?;
        match format {
            PictureFormat::WebP if self.depth == Depth::Sixteen => Err("WebP has no --depth 16".into()),
            PictureFormat::WebP if width.max(height) > WEBP_MAX_SIZE => {
                Err(format!("a WebP picture has at most {WEBP_MAX_SIZE} pixels a side"))
            }
            PictureFormat::Ppm if is_transparent => {
                Err("PPM has no transparency; choose another --background or format".into())
            }
            _ => Ok(format),
        }
    }
}

fn check_terminal(plan: &Plan) -> Result<(), String> {
    let binary = plan.frame_outputs().any(|(_, destination)| *destination == Destination::Stdout);
    // mpirun gives its processes terminals, and passes on what they write.
    let is_in_job = mpi::processes().is_some_and(|processes| processes > 1);
    if binary && !is_in_job && io::stdout().is_terminal() {
        return Err("a picture makes no sense on a terminal; send standard output elsewhere".into());
    }
    Ok(())
}
