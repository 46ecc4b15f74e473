//! The file of a film: written by tercio, or by ffmpeg, which gets the pixels through a pipe.

use std::fmt;
use std::io::{self, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use anyhow::{Context, Result, anyhow, bail};
use tercio::image::film::{EncodedPicture, Film, FilmFormat, FilmWriter};
use tercio::image::{Destination, ImageError, OutputFile, Picture};

use crate::args::series::OutputFormat;
use crate::output::{self, UsageError};

/// Of what ffmpeg says, so many bytes are kept.
const MOST_WORDS: u64 = 1 << 14;

/// A film that is to be written.
#[derive(Clone, Debug)]
pub struct FilmPlan {
    /// Its file.
    pub destination: Destination,
    /// Its format.
    pub format: OutputFormat,
    /// What it is. For ffmpeg, the format of what ffmpeg reads.
    pub film: Film,
}

impl FilmPlan {
    /// Checks that the film can be written.
    ///
    /// # Errors
    /// [`UsageError`]; ffmpeg is needed and not there.
    pub fn check(&self) -> Result<()> {
        self.film.check().map_err(UsageError)?;
        let OutputFormat::Ffmpeg(container) = self.format else { return Ok(()) };
        if self.destination == Destination::Stdout {
            let text = format!(
                "{container} cannot be written to standard output: name a file, or give --format y4m"
            );
            return Err(UsageError(text).into());
        }
        if self.film.width % 2 + self.film.height % 2 > 0 {
            let (width, height) = (self.film.width, self.film.height);
            let text = format!("--size {width}x{height}: {container} needs an even width and height");
            return Err(UsageError(text).into());
        }
        let there = Command::new("ffmpeg")
            .arg("-version")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        match there {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => bail!("{container} is written by ffmpeg, and 'ffmpeg -version' failed ({status})"),
            Err(error) => bail!(
                "{container} is written by ffmpeg, which cannot be started ({error}): install it, or write .gif, .webp, .apng or .y4m"
            ),
        }
    }

    /// Encodes a picture, on any thread.
    ///
    /// # Errors
    /// None for the pictures of one run.
    pub fn encode(&self, picture: &Picture, number: usize) -> Result<EncodedPicture> {
        Ok(self.film.encode(picture, number as u32)?)
    }

    /// Begins the file.
    ///
    /// # Errors
    /// The system's reason why it cannot be written.
    pub fn begin(&self) -> Result<FilmOutput> {
        output::check(&self.destination)?;
        let name = output::name(&self.destination);
        let file = OutputFile::create(&self.destination).with_context(|| name.clone())?;
        let out = match self.format {
            OutputFormat::Ffmpeg(container) => {
                let ffmpeg = Ffmpeg::start(container, &self.film, &file)?;
                Out { target: Target::Ffmpeg(Box::new(ffmpeg), file), is_closed: false }
            }
            _ => Out { target: Target::File(file), is_closed: false },
        };
        let out = Shared(Arc::new(Mutex::new(out)));
        let writer = self.film.begin(out.clone()).with_context(|| name.clone())?;
        Ok(FilmOutput { writer: Mutex::new(writer), out, name, is_closed: AtomicBool::new(false) })
    }
}

/// A film that is being written.
#[derive(Debug)]
pub struct FilmOutput {
    writer: Mutex<FilmWriter<Shared>>,
    out: Shared,
    name: String,
    is_closed: AtomicBool,
}

impl FilmOutput {
    /// Whether the reader of a pipe has closed it: nothing more has to be drawn.
    pub fn is_closed(&self) -> bool {
        self.is_closed.load(Relaxed)
    }

    /// Writes the next picture.
    ///
    /// # Errors
    /// The system's reason; what ffmpeg says.
    pub fn append(&self, picture: &EncodedPicture) -> Result<()> {
        if self.is_closed() {
            return Ok(());
        }
        let mut writer = self.writer.lock().map_err(|_| anyhow!("{}: is broken", self.name))?;
        match writer.append(picture) {
            Err(ImageError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
                // Of ffmpeg, the end says why.
                self.is_closed.store(true, Relaxed);
                Ok(())
            }
            appended => appended.with_context(|| self.name.clone()),
        }
    }

    /// Ends the file, and gives it its name.
    ///
    /// # Errors
    /// The system's reason; what ffmpeg says.
    pub fn finish(self) -> Result<()> {
        let writer = self.writer.into_inner().map_err(|_| anyhow!("{}: is broken", self.name))?;
        let finished = if self.is_closed.into_inner() {
            drop(writer);
            Ok(())
        } else {
            writer.finish()
        };
        match finished {
            Err(ImageError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => {}
            finished => finished.with_context(|| self.name.clone())?,
        }
        let out = Arc::into_inner(self.out.0).ok_or_else(|| anyhow!("{}: is still in use", self.name))?;
        out.into_inner().unwrap_or_else(PoisonError::into_inner).end().with_context(|| self.name.clone())
    }
}

/// Where a film goes, for its writer and for its end.
#[derive(Clone, Debug)]
struct Shared(Arc<Mutex<Out>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}

/// Where the bytes of a film go.
struct Out {
    target: Target,
    is_closed: bool,
}

enum Target {
    File(OutputFile),
    /// The file is written by ffmpeg.
    Ffmpeg(Box<Ffmpeg>, OutputFile),
}

impl fmt::Debug for Out {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Out")
    }
}

impl Out {
    fn end(self) -> Result<()> {
        match self.target {
            Target::File(file) => match file.commit() {
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
                committed => Ok(committed?),
            },
            Target::Ffmpeg(ffmpeg, file) => {
                ffmpeg.end()?;
                Ok(file.commit()?)
            }
        }
    }
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_closed {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let written = match &mut self.target {
            Target::File(file) => file.write(bytes),
            Target::Ffmpeg(ffmpeg, _) => ffmpeg.write(bytes),
        };
        if written.as_ref().is_err_and(|e| e.kind() == io::ErrorKind::BrokenPipe) {
            self.is_closed = true;
            if matches!(self.target, Target::Ffmpeg(..)) {
                // Not the end of a reader who has seen enough: end() says what is wrong.
                return Ok(bytes.len());
            }
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.target {
            _ if self.is_closed => Ok(()),
            Target::File(file) => file.flush(),
            Target::Ffmpeg(ffmpeg, _) => ffmpeg.flush(),
        }
    }
}

/// A running ffmpeg.
struct Ffmpeg {
    child: Child,
    input: Option<ChildStdin>,
    words: Option<JoinHandle<String>>,
}

impl Ffmpeg {
    fn start(container: &str, film: &Film, file: &OutputFile) -> Result<Self> {
        let path = file.temporary_path().ok_or_else(|| {
            anyhow!("{container} needs a file: pipes and devices cannot be written out of order")
        })?;
        let size = format!("{}x{}", film.width, film.height);
        let rate = film.rate.to_string();
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"]);
        command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", &size, "-r", &rate, "-i", "pipe:0"]);
        // Colours as televisions and browsers expect them.
        command.args(["-vf", "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"]);
        command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"]);
        match container {
            "webm" => command.args(["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"]),
            "mkv" => command.args(["-c:v", "libx264", "-crf", "16"]),
            _ => command.args(["-c:v", "libx264", "-crf", "16", "-movflags", "+faststart"]),
        };
        let muxer = if container == "mkv" { "matroska" } else { container };
        command.args(["-f", muxer]).arg(path);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().context("ffmpeg")?;
        let (input, errors) = (child.stdin.take(), child.stderr.take());
        // Read at once, so that ffmpeg never waits for it.
        let words = errors.map(|mut errors| {
            thread::spawn(move || {
                let mut words = Vec::new();
                let _ = errors.by_ref().take(MOST_WORDS).read_to_end(&mut words);
                let _ = io::copy(&mut errors, &mut io::sink());
                String::from_utf8_lossy(&words).into_owned()
            })
        });
        Ok(Self { child, input, words })
    }

    fn end(mut self) -> Result<()> {
        drop(self.input.take());
        let status = self.child.wait().context("ffmpeg")?;
        let words = self.words.take().and_then(|words| words.join().ok()).unwrap_or_default();
        if status.success() {
            return Ok(());
        }
        let words: Vec<&str> = words.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        bail!("ffmpeg failed ({status}): {}", words.join("; "))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        if self.input.take().is_some() {
            // Not ended: the film is not wanted.
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

impl Write for Ffmpeg {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.input.as_mut().map_or_else(|| Err(io::ErrorKind::BrokenPipe.into()), |input| input.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.input.as_mut().map_or(Ok(()), ChildStdin::flush)
    }
}

/// The format in which ffmpeg gets the pictures.
pub const FOR_FFMPEG: FilmFormat = FilmFormat::Rgb;
