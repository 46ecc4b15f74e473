//! The bytes of a model file: mapped, read, or decompressed.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use memmap2::Mmap;

use super::ReadOptions;
use crate::ReadError;

/// The whole content of one file, decompressed.
#[derive(Debug)]
pub struct Input {
    /// The name the user gave, for messages.
    pub name: String,
    /// The folder where companion files are looked for; `None` when there is none (standard input).
    pub base: Option<PathBuf>,
    /// Size of the file as it lies on disk.
    pub file_bytes: u64,
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
        let bytes = if is_gzip(&bytes) { inflate(name, &bytes[..], options)? } else { bytes };
        Ok(Self { name: name.into(), base: None, file_bytes, content: Content::Owned(bytes) })
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
        return Ok(Input { name, base, file_bytes, content: Content::Owned(Vec::new()) });
    }
    // SAFETY: the map is only read. Another process that shortens the file meanwhile ends this one with
    // SIGBUS, as for every program that maps files; no other memory is touched.
    let map = unsafe { Mmap::map(&file) }.map_err(io_error)?;
    let content =
        if is_gzip(&map) { Content::Owned(inflate(&name, &map[..], options)?) } else { Content::Mapped(map) };
    Ok(Input { name, base, file_bytes, content })
}

/// Reads a stream to its end in steps, so that the memory limit holds for streams of unknown length.
fn read_all(name: &str, mut stream: impl Read, options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    loop {
        let got = stream
            .by_ref()
            .take(1 << 24)
            .read_to_end(&mut bytes)
            .map_err(|source| ReadError::Io { file: name.into(), source })?;
        if got == 0 {
            return Ok(bytes);
        }
        options.check_memory(name, "the content", bytes.len() as u64)?;
        if let Some(p) = options.progress {
            p.advance(got as u64);
        }
    }
}

fn inflate(name: &str, compressed: &[u8], options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
    if let Some(p) = options.progress {
        p.begin("decompressing", 0);
    }
    read_all(name, MultiGzDecoder::new(compressed), options)
}
