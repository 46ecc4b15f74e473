//! Options of the outputs, and the plan that follows from them.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use tercio::image::{Destination, PictureFormat, WEBP_MAX_SIZE};
use tercio::raster::Outputs;

use super::drawing::DrawingArgs;
use super::series::OutputFormat;
use super::stereo::{StereoArgs, StereoName};
use crate::mpi;
use crate::output::{Array, Plan};
use crate::series::pattern::{self, Names};

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
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Writing")]
pub struct WritingArgs {
    /// The picture (.png, .ppm, .webp), `-` for standard output, a drawing of lines (.svg, .pdf), or a film (.gif, .apng, .y4m,
    /// .mp4).
    ///
    /// WebP is lossless. SVG and PDF have the lines of --mode hidden-line, wireframe, edges or contours as vectors, cut where they are
    /// hidden. For series {frame} or {:04} in the name stands for the number of a picture, {view} for its view, {step}
    /// for the number of its model, and {name} for the name of its model. Films are .gif, .apng, .y4m, and .mp4, .webm, .mkv and
    /// .mov, which need ffmpeg.
    #[arg(short, long, value_name = "FILE")]
    #[arg(required_unless_present_any = ["output_depth", "output_ids", "output_normals"])]
    output: Option<PathBuf>,
    /// Format of the picture (png, ppm or webp), drawing (svg or pdf) or film (gif, apng, y4m, rgb, mp4 ...) [default: by the extension; png for
    /// `-`].
    #[arg(long, value_name = "FORMAT", requires = "output")]
    format: Option<OutputFormat>,
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
        let (mut picture, mut drawn, mut film) = (None, None, None);
        if let Some(path) = &self.output {
            match self.output_format(path, &Destination::from_path(path), size, drawing.is_transparent())? {
                OutputFormat::Picture(format) => {
                    picture = Some((stereo.destinations("--output", path)?, format));
                }
                OutputFormat::Vector(_) if stereo.layout().is_some() => {
                    return Err("--stereo makes pictures of pixels: an SVG or PDF has one camera".into());
                }
                OutputFormat::Vector(format) => drawn = Some((Destination::from_path(path), format)),
                _ if stereo.layout() == Some(StereoName::Pair) => {
                    return Err("--stereo pair makes two pictures of each; for a film choose side-by-side, over-under or anaglyph".into());
                }
                format => film = Some((Destination::from_path(path), format)),
            }
        }
        let is_drawn = picture.is_some() || film.is_some();
        let arrays = [
            (&self.output_depth, Array::Depth),
            (&self.output_ids, Array::Ids),
            (&self.output_normals, Array::Normals),
        ];
        let arrays = arrays.into_iter().filter_map(|(path, array)| Some((path.as_ref()?, array)));
        let arrays = arrays.map(|(path, array)| Ok((stereo.destinations(array.option(), path)?, array)));
        let plan = Plan {
            outputs: Outputs {
                color: is_drawn && self.depth == Depth::Eight,
                color16: is_drawn && self.depth == Depth::Sixteen,
                depth: self.output_depth.is_some(),
                ids: self.output_ids.is_some(),
                normals: self.output_normals.is_some(),
                keys: false,
                linear: false,
            },
            picture,
            drawing: drawn,
            film,
            arrays: arrays.collect::<Result<_, String>>()?,
            stats: self.stats.as_deref().map(Destination::from_path),
        };
        check_terminal(&plan)?;
        Ok(plan)
    }

    /// These options, with the placeholders of their names filled in.
    ///
    /// # Errors
    /// One sentence, for a placeholder that is not known.
    pub fn named(&self, names: &Names, is_last: bool) -> Result<Self, String> {
        let fill = |path: &Option<PathBuf>| -> Result<Option<PathBuf>, String> {
            path.as_ref().map(|path| pattern::expand(path, names, is_last)).transpose()
        };
        // There is one file of statistics, not one a picture.
        let of_model = Names { frame: None, view: None, step: None, ..names.clone() };
        let stats = self.stats.as_ref().map(|path| pattern::expand(path, &of_model, is_last)).transpose()?;
        Ok(Self {
            output: fill(&self.output)?,
            output_depth: fill(&self.output_depth)?,
            output_ids: fill(&self.output_ids)?,
            output_normals: fill(&self.output_normals)?,
            stats,
            ..self.clone()
        })
    }

    /// Whether an output's name has this placeholder.
    pub fn has_placeholder(&self, name: &str) -> bool {
        let outputs = [&self.output, &self.output_depth, &self.output_ids, &self.output_normals];
        outputs.into_iter().flatten().any(|path| pattern::has(path, name))
    }

    /// Whether the output is a film.
    pub fn is_film(&self) -> bool {
        let by_name = || self.output.as_deref().and_then(OutputFormat::from_path);
        self.format.or_else(by_name).is_some_and(OutputFormat::is_film)
    }

    fn output_format(
        &self,
        path: &Path,
        destination: &Destination,
        (width, height): (u32, u32),
        is_transparent: bool,
    ) -> Result<OutputFormat, String> {
        // A link to standard output may have an extension, too.
        let by_name = || match destination {
            Destination::Stdout => {
                Some(OutputFormat::from_path(path).unwrap_or(OutputFormat::Picture(PictureFormat::Png)))
            }
            Destination::File(path) => OutputFormat::from_path(path),
        };
        let format = self.format.or_else(by_name).ok_or_else(|| {
            format!(
                "{}: the extension must be .png, .ppm, .webp, .svg or .pdf (or give --format)",
                path.display()
            )
        })?;
        let OutputFormat::Picture(of_picture) = format else {
            return match self.depth {
                Depth::Sixteen => Err("films and drawings of lines have no --depth 16".into()),
                Depth::Eight => Ok(format),
            };
        };
        match of_picture {
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
