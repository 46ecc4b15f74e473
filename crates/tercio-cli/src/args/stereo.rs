//! Options of stereo pictures.

use std::path::Path;

use clap::{Args, ValueEnum};
use tercio::image::{Destination, ImageError};
use tercio::raster::Frame;
use tercio::raster::settings::MAX_SIZE;
use tercio::scene::camera::CameraError;
use tercio::scene::{Camera, Stereo};
use tercio::stereo::{anaglyph, over_under, side_by_side};

use super::camera::CameraArgs;
use super::drawing::DrawingArgs;
use super::values;
use crate::output::Plan;

/// How the pictures of two eyes are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StereoName {
    /// One picture of --size for glasses with a red filter on the left and a cyan one on the right.
    Anaglyph,
    /// One picture, twice as wide as --size: the left eye's on the left, the right eye's on the right.
    SideBySide,
    /// One picture, twice as high as --size: the left eye's above, the right eye's below.
    OverUnder,
    /// Two files: NAME.left.EXT and NAME.right.EXT for an output NAME.EXT.
    Pair,
}

/// Pictures for two eyes.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Stereo")]
pub struct StereoArgs {
    /// Draws the model for both eyes, each with all pixels of --size. The eyes look in parallel, and their pictures are
    /// shifted, not turned, so that a point has the same height in both. They are not drawn in bands.
    #[arg(long, value_name = "HOW", value_enum)]
    stereo: Option<StereoName>,
    /// Distance of the eyes, in the units of the model: larger makes it deeper [default: a 30th of --convergence, divided
    /// by --zoom].
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = values::not_negative)]
    #[arg(requires = "stereo")]
    eye_distance: Option<f64>,
    /// Distance from the eyes, along the camera's axis, at which things appear in the plane of the picture; nearer ones
    /// appear before it, farther ones behind it [default: the distance of what the camera looks at].
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = values::positive)]
    #[arg(requires = "stereo")]
    convergence: Option<f64>,
}

/// The cameras of a run: that of the options, and those of the pictures that are drawn.
#[derive(Clone, Debug)]
pub struct Cameras {
    /// The camera in the middle of the eyes; without stereo, the only one.
    pub middle: Camera,
    /// The cameras of the pictures: the left eye's and the right eye's, or the only one.
    pub views: Vec<Camera>,
    /// How the eyes are placed, for a stereo picture.
    pub stereo: Option<Stereo>,
}

impl StereoArgs {
    /// How the pictures of two eyes are written, if there are two.
    pub fn layout(&self) -> Option<StereoName> {
        self.stereo
    }

    /// Width and height of a picture that is written, in pixels, if an eye's picture has this size.
    ///
    /// # Errors
    /// One sentence, if it would be larger than pictures can be.
    pub fn picture_size(&self, (width, height): (u32, u32)) -> Result<(u32, u32), String> {
        let (size, what) = match self.stereo {
            Some(StereoName::SideBySide) => ((2 * width, height), "side-by-side"),
            Some(StereoName::OverUnder) => ((width, 2 * height), "over-under"),
            _ => ((width, height), ""),
        };
        if size.0.max(size.1) > MAX_SIZE {
            let (width, height) = size;
            return Err(format!(
                "--stereo {what} makes a picture of {width}x{height} pixels, the most are {MAX_SIZE} a side: choose a smaller --size"
            ));
        }
        Ok(size)
    }

    /// The files of an output that is named by an option.
    ///
    /// # Errors
    /// One sentence, if two files are needed and the name is that of one.
    pub fn destinations(&self, option: &str, path: &Path) -> Result<Vec<Destination>, String> {
        let whole = Destination::from_path(path);
        if self.stereo != Some(StereoName::Pair) {
            return Ok(vec![whole]);
        }
        let name = path.display();
        let others = "choose side-by-side, over-under or anaglyph, or another name";
        if whole == Destination::Stdout {
            return Err(format!(
                "{option} {name}: --stereo pair writes two files, standard output is one; {others}"
            ));
        }
        // Two files beside a pipe or a device are not meant.
        if path.metadata().is_ok_and(|there| !there.is_file()) {
            return Err(format!(
                "{option} {name}: --stereo pair writes two files, and this is none; {others}"
            ));
        }
        let of_eye = |eye: &str| {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            let extension = path.extension().unwrap_or_default();
            for part in [".", eye, if extension.is_empty() { "" } else { "." }] {
                name.push(part);
            }
            name.push(extension);
            Destination::File(path.with_file_name(name))
        };
        Ok(["left", "right"].map(of_eye).to_vec())
    }

    /// Finds options that make no stereo picture.
    ///
    /// # Errors
    /// One sentence.
    pub fn check(&self, camera: &CameraArgs, drawing: &DrawingArgs, plan: &Plan) -> Result<(), String> {
        if self.stereo.is_none() {
            return Ok(());
        }
        if camera.is_orthographic() {
            return Err("--stereo needs perspective: a parallel projection looks the same to both eyes; leave out --orthographic".into());
        }
        if self.stereo == Some(StereoName::Anaglyph) {
            if let Some((_, array)) = plan.arrays.first() {
                return Err(format!(
                    "{} is not possible with --stereo anaglyph, which shows two surfaces in one pixel; choose pair, side-by-side or over-under",
                    array.option()
                ));
            }
            if drawing.is_transparent() {
                return Err("--stereo anaglyph needs an opaque --background: glasses cannot separate what shines through".into());
            }
        }
        Ok(())
    }

    /// The cameras of the pictures.
    ///
    /// # Errors
    /// [`CameraError`].
    pub fn cameras(&self, middle: Camera, zoom: f64) -> Result<Cameras, CameraError> {
        if self.stereo.is_none() {
            return Ok(Cameras { middle, views: vec![middle], stereo: None });
        }
        let mut stereo = self.convergence.map_or_else(|| Stereo::for_camera(&middle), Stereo::at);
        // Zoom enlarges parallax, too.
        stereo.eye_distance = self.eye_distance.unwrap_or(stereo.eye_distance / zoom);
        Ok(Cameras { middle, views: stereo.cameras(&middle)?.to_vec(), stereo: Some(stereo) })
    }

    /// Number of frames besides that of one eye while the pictures are drawn and put together.
    pub fn further_frames(&self) -> u64 {
        match self.stereo {
            None => 0,
            Some(StereoName::Pair) => 1,
            Some(StereoName::Anaglyph) => 2,
            Some(StereoName::SideBySide | StereoName::OverUnder) => 3,
        }
    }

    /// The frames that are written, from those that were drawn: one for every file of an output.
    ///
    /// # Errors
    /// None for the frames of one run.
    pub fn written(&self, drawn: Vec<Frame>) -> Result<Vec<Frame>, ImageError> {
        Ok(match (self.stereo, &drawn[..]) {
            (Some(StereoName::Anaglyph), [left, right]) => vec![anaglyph(left, right)?],
            (Some(StereoName::SideBySide), [left, right]) => vec![side_by_side(left, right)?],
            (Some(StereoName::OverUnder), [left, right]) => vec![over_under(left, right)?],
            _ => drawn,
        })
    }
}
