//! Options of the outputs, and the plan that follows from them.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use tercio::image::film::FilmFormat;
use tercio::image::{Destination, JPEG_MAX_SIZE, PictureFormat, WEBP_MAX_SIZE};
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
    /// The picture (.png, .jpg, .webp, .ppm), `-` for standard output, a drawing of lines (.svg, .pdf), or a film (.gif, .webp,
    /// .apng, .mp4, .y4m).
    ///
    /// WebP is lossless, and a film for several pictures with one name. SVG and PDF have the lines of --mode hidden-line, wireframe,
    /// edges or contours as vectors, cut where they are hidden. For series {frame} or {:04} in the name stands for the number of a
    /// picture, {view} for its view, {step} for the number of its model, {time} for its time in a collection, and {name} for the name of
    /// its model ({{ and }} are braces, numbers are filled with zeros, as in {:04}, and times have a form as in Python: {time:06.2f},
    /// {time:.1e}, {time:.3g}); a folder that is missing is made for them. Films are .gif, .webp,
    /// .apng, .y4m, and .mp4, .webm, .mkv and
    /// .mov, which need ffmpeg.
    #[arg(short, long, alias = "screenshot", value_name = "FILE")]
    #[arg(required_unless_present_any = ["output_depth", "output_ids", "output_normals"])]
    output: Option<PathBuf>,
    /// Format of the picture (png, ppm, webp or jpeg), drawing (svg or pdf) or film (gif, webp, apng, y4m, rgb, mp4 ...)
    /// [default: by the extension; png for `-`].
    #[arg(long, value_name = "FORMAT", requires = "output")]
    format: Option<OutputFormat>,
    /// Quality of JPEG pictures, 1 to 100. Chroma is never subsampled [default: 90].
    #[arg(long, value_name = "1..100", value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: Option<u8>,
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
    /// The outputs and their destinations; `in_one` if the name is that of several pictures.
    ///
    /// # Errors
    /// One sentence, if the options contradict each other.
    pub fn plan(&self, drawing: &DrawingArgs, stereo: &StereoArgs, in_one: bool) -> Result<Plan, String> {
        let size = stereo.picture_size(drawing.size)?;
        let (mut picture, mut drawn, mut film) = (None, None, None);
        if let Some(path) = &self.output {
            let format =
                self.output_format(path, &Destination::from_path(path), size, drawing.is_transparent())?;
            match format {
                // Several pictures in one file.
                OutputFormat::Picture(PictureFormat::WebP)
                    if in_one && stereo.layout() != Some(StereoName::Pair) =>
                {
                    film = Some((Destination::from_path(path), OutputFormat::Film(FilmFormat::WebP)));
                }
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
                ..Outputs::NONE
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

    /// Those of a picture that is part of a sheet, one of several of its model if there are `several`: it is not written.
    pub fn of_cell(&self, several: bool) -> Self {
        let output = Some(if several { "{frame}.png" } else { "cell.png" }.into());
        let (format, quality, stats) = (None, None, None);
        Self { output, format, quality, stats, ..self.clone() }
    }

    fn outputs(&self) -> impl Iterator<Item = &PathBuf> {
        let outputs = [&self.output, &self.output_depth, &self.output_ids, &self.output_normals];
        outputs.into_iter().flatten()
    }

    /// Checks that there are the placeholders of the outputs' names.
    ///
    /// # Errors
    /// One sentence, with what there is.
    pub fn check_names(&self) -> Result<(), String> {
        self.outputs().try_for_each(|path| pattern::check(path))
    }

    /// Whether an output's name has this placeholder.
    pub fn has_placeholder(&self, name: &str) -> bool {
        self.outputs().any(|path| pattern::has(path, name))
    }

    /// Whether the output is a film.
    pub fn is_film(&self) -> bool {
        let format = self.given_format();
        let is_webp = format == Some(OutputFormat::Picture(PictureFormat::WebP));
        format.is_some_and(OutputFormat::is_film) || (is_webp && !self.is_numbered())
    }

    /// Whether the pictures of a series have names of their own.
    pub fn is_numbered(&self) -> bool {
        let has = |path: &PathBuf| ["", "view", "step"].iter().any(|name| pattern::has(path, name));
        self.output.as_ref().is_some_and(has)
    }

    fn given_format(&self) -> Option<OutputFormat> {
        self.format.or_else(|| self.output.as_deref().and_then(OutputFormat::from_path))
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
                "{}: the extension must be .png, .ppm, .webp, .jpg, .svg or .pdf (or give --format)",
                path.display()
            )
        })?;
        let is_jpeg = matches!(format, OutputFormat::Picture(PictureFormat::Jpeg { .. }));
        if self.quality.is_some() && !is_jpeg {
            return Err("--quality is for JPEG; other pictures are exact".into());
        }
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
            PictureFormat::Ppm | PictureFormat::Jpeg { .. } if is_transparent => {
                let name = of_picture.name().to_uppercase();
                Err(format!("{name} has no transparency; choose another --background or format"))
            }
            PictureFormat::Jpeg { .. } if self.depth == Depth::Sixteen => {
                Err("JPEG has no --depth 16".into())
            }
            PictureFormat::Jpeg { .. } if width.max(height) > JPEG_MAX_SIZE => {
                Err(format!("a JPEG picture has at most {JPEG_MAX_SIZE} pixels a side"))
            }
            PictureFormat::Jpeg { .. } => {
                let quality = self.quality.unwrap_or(PictureFormat::JPEG_QUALITY);
                Ok(OutputFormat::Picture(PictureFormat::Jpeg { quality }))
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
