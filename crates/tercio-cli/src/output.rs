//! Writes the planned outputs: all files, or none.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;
use std::time::SystemTime;

use anyhow::{Context, Result, bail};
use tercio::Loaded;
use tercio::image::{Destination, ImageError, OutputFile, Picture, PictureFormat, npy};
use tercio::raster::{Frame, FrameStats, Outputs};
use tercio::vector::{Page, VectorFormat};

use crate::args::series::OutputFormat;
use crate::named_files::NamedFiles;
use crate::stdio;

/// The options contradict each other; reported like clap's usage errors.
#[derive(Debug)]
pub struct UsageError(pub String);

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// An array output of a frame.
#[derive(Clone, Copy, Debug)]
pub enum Array {
    /// Distances.
    Depth,
    /// Face numbers.
    Ids,
    /// Normals.
    Normals,
}

impl Array {
    /// Its option.
    pub fn option(self) -> &'static str {
        match self {
            Self::Depth => "--output-depth",
            Self::Ids => "--output-ids",
            Self::Normals => "--output-normals",
        }
    }
}

/// When a file was changed last; `None` of what is no file, or where the system does not say it.
pub fn modified(path: &Path) -> Option<SystemTime> {
    let found = std::fs::metadata(path).ok()?;
    if found.is_file() { found.modified().ok() } else { None }
}

/// Bytes of the planes of a frame.
pub fn frame_bytes(outputs: Outputs, (width, height): (u32, u32)) -> u64 {
    u64::from(width) * u64::from(height) * outputs.pixel_bytes() as u64
}

/// The outputs and their destinations.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The requested planes.
    pub outputs: Outputs,
    /// The picture: one file, or one for each eye.
    pub picture: Option<(Vec<Destination>, PictureFormat)>,
    /// The drawing of lines, in place of a picture.
    pub drawing: Option<(Destination, VectorFormat)>,
    /// The film of all pictures.
    pub film: Option<(Destination, OutputFormat)>,
    /// Arrays of numbers, likewise.
    pub arrays: Vec<(Vec<Destination>, Array)>,
    /// Counts and times.
    pub stats: Option<Destination>,
}

impl Plan {
    /// Destinations of pictures and arrays, with their options.
    pub fn frame_outputs(&self) -> impl Iterator<Item = (&'static str, &Destination)> {
        let film = self.film.iter().map(|(file, _)| ("--output", file));
        film.chain(self.files())
    }

    /// Those of pictures of their own, and of arrays.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &Destination)> {
        let picture = self.picture.iter().map(|(files, _)| ("--output", files));
        let drawing = self.drawing.iter().map(|(file, _)| ("--output", file));
        let all = picture.chain(self.arrays.iter().map(|(files, array)| (array.option(), files)));
        drawing.chain(all.flat_map(|(option, files)| files.iter().map(move |file| (option, file))))
    }

    /// All destinations, for the rule of all commands, added to `files`.
    pub fn named_files(&self, files: NamedFiles) -> NamedFiles {
        let stats = self.stats.iter().map(|destination| ("--stats", destination));
        let all = self.frame_outputs().chain(stats);
        all.fold(files, |files, (option, destination)| files.writes(option, destination))
    }

    /// What happened to the files because nothing was written.
    pub fn left_out(&self) -> String {
        let named: Vec<_> = self.frame_outputs().map(|(_, destination)| destination).collect();
        let is_there = |d: &&Destination| matches!(d, Destination::File(path) if path.is_file());
        match named.iter().copied().find(is_there) {
            Some(old) if named.len() == 1 => format!("{} was left as it is", name(old)),
            Some(_) => "old files were left as they are".into(),
            None => "no picture was written".into(),
        }
    }

    /// Whether the picture is drawn in bands, which are written one after another.
    pub fn is_in_bands(&self, (width, height): (u32, u32)) -> bool {
        let is_png = matches!(self.picture, Some((_, PictureFormat::Png)));
        is_png
            && self.arrays.is_empty()
            // Effects need the whole picture.
            && !self.outputs.linear
            && u64::from(width) * u64::from(height) > tercio::MAX_PIXELS_IN_MEMORY
    }

    /// Writes the picture, which `draw` draws and writes as PNG; returns its statistics. If `draw` writes nothing, no file
    /// appears. If the reader of a pipe closes it, the rest of the picture is drawn, but not written.
    ///
    /// # Errors
    /// A picture that could not be written, or drawn: then for `model`.
    pub fn write_drawn(
        &self,
        model: &str,
        allow_empty: bool,
        draw: impl FnOnce(&mut dyn Write) -> tercio::Result<FrameStats>,
    ) -> Result<FrameStats> {
        let Some([destination, ..]) = self.picture.as_ref().map(|(files, _)| &files[..]) else {
            bail!("there is no picture to write")
        };
        let mut stats = FrameStats::default();
        let mut result = Ok(());
        let file = begin(destination, |out| {
            match draw(&mut UntilClosed { out, is_closed: false }) {
                Ok(drawn) => stats = drawn,
                Err(tercio::Error::Image(error)) => return Err(error),
                Err(error) => result = Err(error).with_context(|| model.to_owned()),
            }
            Ok(())
        })?;
        result?;
        if stats.backend.pixels_visible > 0 || allow_empty {
            finish(file, destination)?;
        }
        Ok(stats)
    }

    /// Writes a drawing.
    ///
    /// # Errors
    /// The system's reason why it could not be written.
    pub fn write_drawing(&self, page: &Page) -> Result<()> {
        let Some((destination, format)) = &self.drawing else { return Ok(()) };
        let file = begin(destination, |out| Ok(page.write(*format, out)?))?;
        finish(file, destination)
    }

    /// Writes picture and arrays, of each frame to a file of its own. Files appear only when all are complete; standard
    /// output, pipes and devices receive the data as it is produced.
    ///
    /// # Errors
    /// The first output that could not be written.
    pub fn write(&self, frames: &[Frame]) -> Result<()> {
        let mut files = Vec::new();
        if let Some((destinations, format)) = &self.picture {
            for (destination, frame) in destinations.iter().zip(frames) {
                files.push(begin(destination, |out| Picture::from_frame(frame).write(*format, out))?);
            }
        }
        for (destinations, array) in &self.arrays {
            for (destination, frame) in destinations.iter().zip(frames) {
                files.push(begin(destination, |out| Ok(write_array(frame, *array, out)?))?);
            }
        }
        let destinations = self.files().map(|(_, destination)| destination);
        files.into_iter().zip(destinations).try_for_each(|(file, destination)| finish(file, destination))
    }
}

/// Writes until the reader of a pipe closes it, and then nothing.
struct UntilClosed<'a> {
    out: &'a mut dyn Write,
    is_closed: bool,
}

impl UntilClosed<'_> {
    fn unless_closed<T>(&mut self, result: io::Result<T>, closed: T) -> io::Result<T> {
        match result {
            Err(error) if is_broken_pipe(&error) => {
                self.is_closed = true;
                Ok(closed)
            }
            other => other,
        }
    }
}

impl Write for UntilClosed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = if self.is_closed { Ok(bytes.len()) } else { self.out.write(bytes) };
        self.unless_closed(written, bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = if self.is_closed { Ok(()) } else { self.out.flush() };
        self.unless_closed(flushed, ())
    }
}

/// Writes a text.
///
/// # Errors
/// The system's reason why it could not be written.
pub fn write_text(destination: &Destination, text: &str) -> Result<()> {
    let file = begin(destination, |out| Ok(out.write_all(text.as_bytes())?))?;
    finish(file, destination)
}

/// Writes a picture.
///
/// # Errors
/// The system's reason why it could not be written; a format that cannot hold it.
pub fn write_picture(destination: &Destination, picture: &Picture, format: PictureFormat) -> Result<()> {
    let file = begin(destination, |out| picture.write(format, out))?;
    finish(file, destination)
}

/// Writes a prepared model; `model` names the original.
///
/// # Errors
/// The system's reason why it could not be written.
pub fn write_prepared(destination: &Destination, loaded: &Loaded, model: &str) -> Result<()> {
    let file = begin(destination, |out| Ok(loaded.write_prepared(model, out)?))?;
    finish(file, destination)
}

/// Checks before the work that an output can be written.
///
/// # Errors
/// A folder that is missing; standard output that is closed.
pub fn check(destination: &Destination) -> Result<()> {
    if *destination == Destination::Stdout && stdio::output_was_closed() {
        bail!("standard output: is closed");
    }
    destination.check().with_context(|| name(destination))
}

/// An output that is filled but not yet visible under its name; `None` if the reader of a pipe has closed it. That is
/// no error, and the other outputs are still written.
fn begin(
    destination: &Destination,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), ImageError>,
) -> Result<Option<OutputFile>> {
    check(destination)?;
    let mut file = OutputFile::create(destination).with_context(|| name(destination))?;
    match fill(&mut file) {
        Err(ImageError::Io(error)) if is_broken_pipe(&error) => Ok(None),
        filled => filled.map(|()| Some(file)).with_context(|| name(destination)),
    }
}

fn finish(file: Option<OutputFile>, destination: &Destination) -> Result<()> {
    match file.map_or(Ok(()), OutputFile::commit) {
        Err(error) if is_broken_pipe(&error) => Ok(()),
        ended => ended.with_context(|| name(destination)),
    }
}

fn is_broken_pipe(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}

fn write_array(frame: &Frame, array: Array, out: &mut dyn Write) -> io::Result<()> {
    let shape = [frame.height as usize, frame.width as usize, 3];
    match array {
        Array::Depth => npy::write(out, &shape[..2], &frame.planes.depth),
        Array::Ids => npy::write(out, &shape[..2], &frame.planes.ids),
        Array::Normals => npy::write(out, &shape, frame.planes.normals.as_flattened()),
    }
}

/// The name of an output in messages.
pub fn name(destination: &Destination) -> String {
    match destination {
        Destination::Stdout => "standard output".into(),
        Destination::File(path) => path.display().to_string(),
    }
}
