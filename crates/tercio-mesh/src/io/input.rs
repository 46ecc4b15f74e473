//! The bytes of a model file: mapped, read, or decompressed.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::GzDecoder;
use memmap2::Mmap;

use super::ReadOptions;
use crate::ReadError;
use crate::error::counted;

/// The whole content of one file, decompressed.
#[derive(Debug)]
pub struct Input {
    /// The name the user gave, for messages.
    pub name: String,
    /// The folder where companion files are looked for; `None` when there is none (standard input).
    pub base: Option<PathBuf>,
    /// Size of the file as it lies on disk.
    pub file_bytes: u64,
    /// What was odd about the file round the content.
    pub warnings: Vec<String>,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Mapped(Mmap),
    Owned(Vec<u8>),
}

impl Input {
    /// Bytes that are in memory already, gzip-compressed or not.
    ///
    /// # Errors
    /// A damaged gzip stream, or content over the memory limit.
    pub fn from_bytes(name: &str, bytes: Vec<u8>, options: &ReadOptions) -> Result<Self, ReadError> {
        let file_bytes = bytes.len() as u64;
        let mut warnings = Vec::new();
        let bytes = if is_gzip(&bytes) { inflate(name, &bytes, options, &mut warnings)? } else { bytes };
        Ok(Self { name: name.into(), base: None, file_bytes, warnings, content: Content::Owned(bytes) })
    }

    /// The content.
    pub fn bytes(&self) -> &[u8] {
        match &self.content {
            Content::Mapped(map) => map,
            Content::Owned(bytes) => bytes,
        }
    }

    /// Bytes of memory that the content holds; a mapped file holds none that the system could not take back.
    pub fn held_bytes(&self) -> u64 {
        match &self.content {
            Content::Mapped(_) => 0,
            Content::Owned(bytes) => bytes.len() as u64,
        }
    }
}

fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Opens a file, or standard input for `-`.
///
/// # Errors
/// The system's reason, a damaged gzip stream, or content over the memory limit.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Input, ReadError> {
    let name = path.display().to_string();
    let io_error = |source| ReadError::Io { file: name.clone(), source };
    if path.as_os_str() == "-" {
        let bytes = read_all("standard input", io::stdin().lock(), options)?;
        return Input::from_bytes("standard input", bytes, options);
    }
    let file = File::open(path).map_err(io_error)?;
    let metadata = file.metadata().map_err(io_error)?;
    if metadata.is_dir() {
        return Err(io_error(io::ErrorKind::IsADirectory.into()));
    }
    let base = path.parent().map(Path::to_path_buf);
    if !metadata.is_file() {
        // Pipes and devices have no size and cannot be mapped.
        let bytes = read_all(&name, file, options)?;
        return Ok(Input { base, ..Input::from_bytes(&name, bytes, options)? });
    }
    let file_bytes = metadata.len();
    if file_bytes == 0 {
        let content = Content::Owned(Vec::new());
        return Ok(Input { name, base, file_bytes, warnings: Vec::new(), content });
    }
    // SAFETY: the map is only read. Another process that shortens the file meanwhile ends this one with
    // SIGBUS, as for every program that maps files; no other memory is touched.
    let map = unsafe { Mmap::map(&file) }.map_err(io_error)?;
    let mut warnings = Vec::new();
    let content = match is_gzip(&map) {
        true => Content::Owned(inflate(&name, &map, options, &mut warnings)?),
        false => Content::Mapped(map),
    };
    Ok(Input { name, base, file_bytes, warnings, content })
}

/// Reads a stream to its end in steps, so that the memory limit holds for streams of unknown length.
fn read_all(name: &str, stream: impl Read, options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    read_on(name, stream, options, &mut bytes, |source, _| ReadError::Io { file: name.into(), source })?;
    Ok(bytes)
}

/// Appends the rest of a stream; `fail` makes the error of one that breaks off behind so many bytes.
fn read_on(
    name: &str,
    mut stream: impl Read,
    options: &ReadOptions,
    bytes: &mut Vec<u8>,
    fail: impl Fn(io::Error, usize) -> ReadError,
) -> Result<(), ReadError> {
    loop {
        let got =
            stream.by_ref().take(1 << 24).read_to_end(bytes).map_err(|error| fail(error, bytes.len()))?;
        if got == 0 {
            return Ok(());
        }
        options.check_memory(name, "the content", bytes.len() as u64)?;
        if let Some(p) = options.progress {
            p.advance(got as u64);
        }
    }
}

/// Undoes gzip: one member after the other, until something else follows, which is left out with a warning, as
/// tapes and block devices put zeros behind a file.
fn inflate(
    name: &str,
    compressed: &[u8],
    options: &ReadOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<u8>, ReadError> {
    if let Some(p) = options.progress {
        p.begin("decompressing", 0);
    }
    let (mut bytes, mut rest) = (Vec::new(), compressed);
    while is_gzip(rest) {
        let mut member = GzDecoder::new(rest);
        read_on(name, &mut member, options, &mut bytes, |error, held| broken_gzip(name, &error, held))?;
        rest = member.into_inner();
    }
    if !rest.is_empty() {
        let what = if rest.iter().all(|&b| b == 0) { "zero byte" } else { "byte" };
        warnings.push(format!("ignored {} behind the gzip data", counted(rest.len() as u64, what)));
    }
    Ok(bytes)
}

#[cold]
fn broken_gzip(file: &str, error: &io::Error, held: usize) -> ReadError {
    let what = match error.kind() {
        io::ErrorKind::UnexpectedEof => {
            format!("truncated gzip data: they end after {held} bytes of content")
        }
        _ => format!("damaged gzip data ({error}) after {held} bytes of content"),
    };
    ReadError::Compressed { file: file.into(), what }
}
