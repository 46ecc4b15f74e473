//! Options of series of pictures: views, turntables, camera paths, films.

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use tercio::CameraPath;
use tercio::camera_path::{self, FileKeyframe};
use tercio::glam::DVec3;
use tercio::image::PictureFormat;
use tercio::image::film::{FilmFormat, FrameRate};
use tercio::scene::Keyframe;
use tercio::vector::VectorFormat;

use super::camera::{CameraArgs, NamedView};
use super::{Moment, values};
use crate::named_files::NamedFiles;
use crate::output::UsageError;

/// The most pictures of a series.
pub const MOST_PICTURES: u32 = 100_000;
/// The largest file of keyframes.
const LARGEST_PATH: u64 = 64 << 20;

/// Several pictures of a model, which is loaded once.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Series of pictures")]
pub struct SeriesArgs {
    /// Draws N pictures of one full turn of the camera round the model.
    ///
    /// The camera turns in equal steps round the up axis through what it looks at, and the model stays in the picture all round. The
    /// output is a film, or has a number in its name: frame_{:04}.png.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PICTURES)))]
    turntable: Option<u32>,
    /// Moves the camera smoothly through the keyframes of a CSV, JSON or TOML file.
    ///
    /// Columns or keys are time in seconds, eye (eye_x, eye_y, eye_z in CSV) and, if they are not those of the other options,
    /// target, up and fov. A path whose last keyframe has the camera of the first is closed.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["turntable", "view", "azimuth", "elevation", "camera_direction", "eye", "target"])]
    camera_path: Option<PathBuf>,
    /// Number of pictures of --camera-path [default: one for each frame of --fps].
    #[arg(long, value_name = "N", requires = "camera_path")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PICTURES)))]
    frames: Option<u32>,
    /// Pictures a second of films and camera paths, such as 25, 12.5 or 30000/1001.
    #[arg(long, value_name = "RATE", default_value = "25")]
    fps: FrameRate,
    /// How often a GIF, WebP or APNG is shown; 0 for ever [default: 0].
    #[arg(long = "loop", value_name = "TIMES")]
    plays: Option<u16>,
    /// Which of the times of a collection (.pvd) is drawn, by its number, counted from 0; without this, a film or numbered pictures
    /// show all of them.
    #[arg(long, value_name = "N", conflicts_with = "time")]
    step: Option<usize>,
    /// Which of the times of a collection (.pvd) is drawn: the one nearest to T.
    #[arg(long, alias = "animation-time", value_name = "T", allow_hyphen_values = true, value_parser = values::number)]
    time: Option<f64>,
    /// Which models of a series the camera frames: all of them, which are read before the first one is drawn, so that none leaves the
    /// picture; or only the first one.
    #[arg(long, value_name = "STEPS", value_enum, default_value_t = FrameOver::All)]
    frame_over: FrameOver,
    /// Draws only the pictures of a series whose files are not there, not whole, or older than a file that they are drawn from (models,
    /// scene file, camera path ...), after an interrupted run of the same command. Other options are not noticed.
    #[arg(long)]
    pub resume: bool,
    /// Draws again whenever a file changes that the picture is made of (models, material libraries, textures, colour maps, scene file ...),
    /// until the program is interrupted.
    #[arg(long, conflicts_with = "resume")]
    pub watch: bool,
}

/// `--frame-over`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FrameOver {
    /// All models.
    All,
    /// The first one.
    First,
}

/// A format of the output: of one picture, or of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// A picture.
    Picture(PictureFormat),
    /// A drawing of lines.
    Vector(VectorFormat),
    /// A film that tercio writes.
    Film(FilmFormat),
    /// A film that ffmpeg makes, in a container of this name.
    Ffmpeg(&'static str),
}

/// The containers that ffmpeg is asked for.
const CONTAINERS: [&str; 4] = ["mp4", "webm", "mkv", "mov"];

impl OutputFormat {
    /// The format of a file name, by its extension in any case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        // Raw numbers are asked for by name.
        extension.parse().ok().filter(|format| *format != Self::Film(FilmFormat::Rgb))
    }

    /// Whether it is one of films.
    pub fn is_film(self) -> bool {
        !matches!(self, Self::Picture(_) | Self::Vector(_))
    }
}

impl FromStr for OutputFormat {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let film = || s.parse().ok().map(Self::Film);
        let container = || CONTAINERS.into_iter().find(|c| *c == s).map(Self::Ffmpeg);
        let drawing = || s.parse().ok().map(Self::Vector);
        let picture = s.parse().ok().map(Self::Picture);
        picture.or_else(drawing).or_else(film).or_else(container).ok_or_else(|| {
            let pictures = PictureFormat::ALL.map(PictureFormat::name).join(", ");
            let films = FilmFormat::ALL.map(FilmFormat::name).join(", ");
            let drawings = VectorFormat::ALL.map(VectorFormat::name).join(", ");
            format!("expected {pictures}, of drawings of lines {drawings}, or of films {films}, {}, found \"{s}\"", CONTAINERS.join(", "))
        })
    }
}

/// How the camera differs from picture to picture.
#[derive(Clone, Debug)]
pub enum Motion {
    /// There is one picture.
    Still,
    /// One picture a view, several.
    Views(Vec<NamedView>),
    /// A full turn in so many steps.
    Turntable(u32),
    /// Along keyframes, in so many pictures.
    Path(Vec<FileKeyframe>, u32),
}

impl Motion {
    /// The number of pictures.
    pub fn count(&self) -> usize {
        match self {
            Self::Still => 1,
            Self::Views(views) => views.len(),
            Self::Turntable(count) | Self::Path(_, count) => *count as usize,
        }
    }

    /// Whether there may be several pictures.
    pub fn is_series(&self) -> bool {
        !matches!(self, Self::Still)
    }

    /// The keyframes of a path, where `target`, `up` and `fov` stand for what the file does not say.
    pub fn path(keys: &[FileKeyframe], target: DVec3, up: DVec3, fov: f64) -> Result<CameraPath, String> {
        let full = |key: &FileKeyframe| Keyframe {
            time: key.time,
            eye: key.eye,
            target: key.target.unwrap_or(target),
            up: key.up.unwrap_or(up),
            fov_y: key.fov.unwrap_or(fov),
        };
        CameraPath::new(keys.iter().map(full).collect()).map_err(|error| error.to_string())
    }
}

impl SeriesArgs {
    /// How the camera moves.
    ///
    /// # Errors
    /// A file of keyframes that cannot be read; options that contradict each other.
    pub fn motion(&self, camera: &CameraArgs) -> anyhow::Result<Motion> {
        let views = camera.views();
        if let Some(path) = &self.camera_path {
            return self.path_motion(path);
        }
        match self.turntable {
            Some(_) if views.len() > 1 => Err(UsageError(
                "--turntable turns one view: give one --view, or --azimuth and --elevation".into(),
            )
            .into()),
            Some(count) => Ok(Motion::Turntable(count)),
            None if views.len() > 1 => Ok(Motion::Views(views.to_vec())),
            None => Ok(Motion::Still),
        }
    }

    fn path_motion(&self, path: &Path) -> anyhow::Result<Motion> {
        use anyhow::Context as _;
        let name = || path.display().to_string();
        let length = fs::metadata(path).with_context(name)?.len();
        if length > LARGEST_PATH {
            anyhow::bail!("{}: {length} bytes are no file of keyframes, the limit is {LARGEST_PATH}", name());
        }
        let bytes = fs::read(path).with_context(name)?;
        let keys = camera_path::read(&bytes).with_context(name)?;
        // Checked now, with anything for what only the model knows.
        let path = Motion::path(&keys, DVec3::ZERO, DVec3::Y, 30.0)
            .map_err(anyhow::Error::msg)
            .with_context(name)?;
        let frames = path.duration() * self.fps.per_second();
        let count = match self.frames {
            Some(frames) => frames,
            None if frames < f64::from(MOST_PICTURES) => (frames.round() as u32 + 1).max(2),
            None => {
                let fps = self.fps;
                return Err(UsageError(format!(
                    "{}: {} s at {fps} pictures a second are more than {MOST_PICTURES} pictures: give --frames",
                    name(),
                    path.duration()
                ))
                .into());
            }
        };
        Ok(Motion::Path(keys, count))
    }

    /// Whether the camera of a series of models is placed so that it frames all of them.
    pub fn frames_all(&self) -> bool {
        self.frame_over == FrameOver::All && self.camera_path.is_none()
    }

    /// Whether the camera moves round one model.
    pub fn moves_camera(&self) -> bool {
        self.turntable.is_some() || self.camera_path.is_some()
    }

    /// Whether one of the times of a collection is chosen.
    pub fn chooses_time(&self) -> bool {
        self.step.is_some() || self.time.is_some()
    }

    /// The chosen one of these times of a model.
    ///
    /// # Errors
    /// One sentence: there are no times, or not so many.
    pub fn chosen(&self, model: &Path, times: &[f64]) -> Result<Option<Moment>, String> {
        if !self.chooses_time() {
            return Ok(None);
        }
        let name = model.display();
        let [first, .., last] = times else {
            return match times {
                [time] => Ok(Some(Moment { number: 0, time: *time })),
                _ => Err(format!(
                    "{name}: --step and --time choose one of the times of a collection (.pvd), and it has none"
                )),
            };
        };
        let number = match (self.step, self.time) {
            (Some(step), _) if step >= times.len() => {
                let most = times.len() - 1;
                return Err(format!(
                    "{name}: --step {step}: its steps are 0 to {most} (times {first} to {last})"
                ));
            }
            (Some(step), _) => step,
            (None, time) => {
                let distance = |number: &usize| (times[*number] - time.unwrap_or(0.0)).abs();
                (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
            }
        };
        Ok(Some(Moment { number, time: times[number] }))
    }

    /// The message if the chosen time is not exactly the one that is asked for.
    pub fn other_time(&self, moment: Moment) -> Option<String> {
        let asked = self.time.filter(|asked| (asked - moment.time).abs() > 1e-9 * asked.abs().max(1e-300))?;
        Some(format!("has no time {asked}; the nearest is {}, step {}", moment.time, moment.number))
    }

    /// Adds the files that these options name.
    pub fn named_files(&self, files: NamedFiles) -> NamedFiles {
        match &self.camera_path {
            Some(path) => files.reads("the camera path", path),
            None => files,
        }
    }

    /// Pictures a second.
    pub fn rate(&self) -> FrameRate {
        self.fps
    }

    /// How often a film is shown, 0 for ever.
    pub fn plays(&self) -> u16 {
        self.plays.unwrap_or(0)
    }

    /// Finds options that have no effect.
    ///
    /// # Errors
    /// One sentence.
    pub fn check(&self, is_series: bool, film: Option<OutputFormat>) -> Result<(), String> {
        if self.resume && film.is_some() {
            return Err(
                "--resume continues series of files; a film is one file, and is drawn as a whole".into()
            );
        }
        if self.resume && !is_series {
            return Err(
                "--resume continues a series: give --turntable, --camera-path or several views".into()
            );
        }
        let may_loop =
            matches!(film, Some(OutputFormat::Film(FilmFormat::Gif | FilmFormat::Apng | FilmFormat::WebP)));
        if self.plays.is_some() && !may_loop {
            return Err("--loop is for GIF, WebP and APNG".into());
        }
        Ok(())
    }
}
