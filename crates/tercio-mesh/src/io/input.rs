//! The bytes of a model file: mapped, read, or decompressed.

use std::fs::File;
use std::io::{self, BufRead, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use flate2::bufread::GzDecoder;
use memmap2::Mmap;

use super::{ReadOptions, text};
use crate::ReadError;
use crate::error::counted;

/// The whole content of one file, decompressed.
#[derive(Debug)]
pub struct Input {
    /// The name the user gave, for messages.
    pub name: String,
    /// The folder where companion files are looked for; `None` when there is none (standard input).
    pub base: Option<PathBuf>,
    /// Size of the file on disk.
    pub file_bytes: u64,
    /// Oddities of the file around the content.
    pub warnings: Vec<String>,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Mapped(Mapping),
    Owned(Vec<u8>),
}

/// Bytes of all [`Mapping`]s that count as memory.
static MAPPED: AtomicU64 = AtomicU64::new(0);

/// Resident bytes of mapped model files: pages that the system could reclaim, but that count as memory of the
/// process. For programs that account for their memory.
pub fn mapped_bytes() -> u64 {
    MAPPED.load(Relaxed)
}

/// A mapped file.
///
/// A file that is small compared with the memory limit counts as memory completely. The pages of a larger one are
/// released while it is read, so that a file larger than the limit can be read if its mesh is smaller. Readers that know
/// that they need a part no longer ([`Input::finished`]) have its pages released whatever the size of the file.
#[derive(Debug)]
struct Mapping {
    map: Arc<Mmap>,
    accounted_bytes: AtomicU64,
    /// Bytes that were read since pages were last released; `None` where the whole file counts.
    read: Option<AtomicU64>,
    /// Bytes of each [`REGION`] that are not needed again.
    finished: Vec<AtomicU32>,
}

/// A part of a file whose pages are released together: every release interrupts all processors of the process.
const REGION: usize = 2 << 20;

/// The most that a thread should read before it reports it; pages are released each time.
const RELEASE_STEP: usize = 256 << 10;

/// Reading one byte of a file may load this many: file systems keep files in large pieces.
const READ_AHEAD: u64 = 2 << 20;

impl Mapping {
    fn new(map: Mmap, options: &ReadOptions) -> Self {
        let size = map.len() as u64;
        let is_small = options.memory_limit.is_none_or(|limit| size <= (limit / 16).max(READ_AHEAD));
        let at_a_time = READ_AHEAD * (rayon::current_num_threads() as u64 + 1);
        let accounted = if is_small { size } else { size.min(at_a_time) };
        MAPPED.fetch_add(accounted, Relaxed);
        let accounted_bytes = AtomicU64::new(accounted);
        let finished = (0..map.len().div_ceil(REGION)).map(|_| AtomicU32::new(0)).collect();
        Self { map: Arc::new(map), accounted_bytes, read: (!is_small).then(|| AtomicU64::new(0)), finished }
    }

    /// The whole file counts as memory from now on.
    fn count_all(&self) {
        let size = self.map.len() as u64;
        let more = size.saturating_sub(self.accounted_bytes.swap(size, Relaxed));
        MAPPED.fetch_add(more, Relaxed);
    }

    fn consumed(&self, bytes: u64) {
        let Some(read) = &self.read else { return };
        let before = read.fetch_add(bytes, Relaxed);
        let stretch = RELEASE_STEP as u64;
        if before / stretch != (before + bytes) / stretch {
            self.release_pages(0..self.map.len());
        }
    }

    /// Some bytes of the map are not needed again.
    fn finished(&self, bytes: &[u8]) {
        let Some(first) = bytes.as_ptr().addr().checked_sub(self.map.as_ptr().addr()) else { return };
        let end = (first + bytes.len()).min(self.map.len());
        for (region, finished) in self.finished.iter().enumerate().skip(first / REGION) {
            let here = region * REGION..((region + 1) * REGION).min(self.map.len());
            let part = here.end.min(end).saturating_sub(here.start.max(first));
            if part == 0 {
                break;
            }
            if finished.fetch_add(part as u32, Relaxed) as usize + part == here.len() {
                self.release_pages(here);
            }
        }
    }

    #[cfg(unix)]
    fn release_pages(&self, bytes: Range<usize>) {
        let what = memmap2::UncheckedAdvice::DontNeed;
        // SAFETY: the map is of a file and only read, so pages that other threads read meanwhile are loaded from the
        // file again.
        let _ = unsafe { self.map.unchecked_advise_range(what, bytes.start, bytes.len()) };
    }

    #[cfg(not(unix))]
    fn release_pages(&self, _: Range<usize>) {}
}

/// Bytes of a file piece by piece, from either end; each piece is reported as consumed.
fn pieces<'a>(bytes: &'a [u8], mapping: Option<&'a Mapping>) -> impl DoubleEndedIterator<Item = &'a [u8]> {
    bytes.chunks(RELEASE_STEP).inspect(move |piece| {
        if let Some(mapping) = mapping {
            mapping.consumed(piece.len() as u64);
        }
    })
}

impl Drop for Mapping {
    fn drop(&mut self) {
        MAPPED.fetch_sub(self.accounted_bytes.load(Relaxed), Relaxed);
    }
}

impl Input {
    /// Bytes that are in memory already, gzip-compressed or not.
    ///
    /// # Errors
    /// A damaged gzip stream, or content over the memory limit.
    pub fn from_bytes(name: &str, bytes: Vec<u8>, options: &ReadOptions) -> Result<Self, ReadError> {
        let file_bytes = bytes.len() as u64;
        let mut warnings = Vec::new();
        let bytes = if is_gzip(&bytes) {
            inflate(name, Compressed { rest: &bytes, mapping: None }, options, &mut warnings)?
        } else {
            bytes
        };
        Ok(Self { name: name.into(), base: None, file_bytes, warnings, content: Content::Owned(bytes) })
    }

    /// The content.
    pub fn bytes(&self) -> &[u8] {
        match &self.content {
            Content::Mapped(mapping) => &mapping.map,
            Content::Owned(bytes) => bytes,
        }
    }

    /// The map, if the content is a mapped file. It may outlive this input.
    pub(crate) fn map(&self) -> Option<&Arc<Mmap>> {
        self.mapping().map(|mapping| &mapping.map)
    }

    /// Bytes of memory that the content takes; for a mapped file that is large compared with the memory limit, those
    /// that are resident at a time.
    pub fn held_bytes(&self) -> u64 {
        match &self.content {
            Content::Mapped(mapping) => mapping.accounted_bytes.load(Relaxed),
            Content::Owned(bytes) => bytes.len() as u64,
        }
    }

    /// Reports that this many bytes were read, anywhere in the content: their memory may be released. Readers call it
    /// about every [`Input::stretch`] bytes, in every pass.
    pub fn consumed(&self, bytes: usize) {
        if let Some(mapping) = self.mapping() {
            mapping.consumed(bytes as u64);
        }
    }

    /// Reports that some bytes of the content will not be read again, so that their pages are not kept beside what was made
    /// of them. Precondition: no byte is reported twice; otherwise pages are released too early, and read again.
    pub fn finished(&self, bytes: &[u8]) {
        if let Some(mapping) = self.mapping() {
            mapping.finished(bytes);
        }
    }

    fn mapping(&self) -> Option<&Mapping> {
        match &self.content {
            Content::Mapped(mapping) => Some(mapping),
            Content::Owned(_) => None,
        }
    }

    /// Does `holds` return true for all of these bytes of the content? They are reported as consumed.
    pub fn all(&self, bytes: &[u8], holds: impl Fn(u8) -> bool) -> bool {
        pieces(bytes, self.mapping()).all(|piece| piece.iter().all(|&b| holds(b)))
    }

    /// Index of the first of these bytes of the content for which `is` is true; those before it are reported as
    /// consumed.
    pub fn position(&self, bytes: &[u8], is: impl Fn(u8) -> bool) -> Option<usize> {
        text::find(is, bytes, |searched| self.consumed(searched))
    }

    /// Number of these bytes of the content for which `is` is true; all are reported as consumed.
    pub fn count(&self, bytes: &[u8], is: impl Fn(u8) -> bool) -> u64 {
        pieces(bytes, self.mapping()).map(|piece| piece.iter().filter(|&&b| is(b)).count() as u64).sum()
    }

    /// The bytes without trailing zeros, which tapes and block devices leave there; those are reported as consumed.
    pub fn unpadded<'b>(&self, bytes: &'b [u8]) -> &'b [u8] {
        let mut length = bytes.len();
        // Pieces are aligned to the front, so the first one from the end may be short.
        for piece in pieces(bytes, self.mapping()).rev() {
            length -= piece.len();
            if let Some(last) = piece.iter().rposition(|&b| b != 0) {
                length += last + 1;
                break;
            }
        }
        bytes.get(..length).unwrap_or_default()
    }

    /// Reports that a sample was read, `apart` bytes from the next one: the system may have loaded the bytes around
    /// it, too.
    pub fn looked_at(&self, apart: usize) {
        self.consumed(apart.min(READ_AHEAD as usize));
    }

    /// All of the content will be in memory at once: it counts as memory from now on.
    pub fn count_all(&self) {
        if let Some(mapping) = self.mapping() {
            mapping.count_all();
        }
    }

    /// Makes sure that a task reads no more than it should at a time; where a part is longer, all of the content
    /// counts as memory.
    ///
    /// # Errors
    /// [`ReadError::MemoryLimit`] if that is too much.
    pub fn check_chunk_lengths(&self, parts: &[&[u8]], options: &ReadOptions) -> Result<(), ReadError> {
        if parts.iter().any(|part| part.len() > self.stretch(part.len()).saturating_mul(4)) {
            self.count_all();
            options.check_memory(&self.name, "its long lines", self.held_bytes())?;
        }
        Ok(())
    }

    /// The most bytes that a task should read at a time, at most `wanted`.
    pub fn stretch(&self, wanted: usize) -> usize {
        match &self.content {
            Content::Mapped(Mapping { read: Some(_), .. }) => wanted.min(RELEASE_STEP),
            _ => wanted,
        }
    }
}

/// ENOMEM, which has the same value on all systems.
const OUT_OF_MEMORY: i32 = 12;

fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Opens a file, or standard input for `-`.
///
/// # Errors
/// The system's reason, a damaged gzip stream, or content over the memory limit.
pub fn open(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Input, ReadError> {
    open_path(path.as_ref(), options)
}

fn open_path(path: &Path, options: &ReadOptions) -> Result<Input, ReadError> {
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
    // SAFETY: the map is only read. If another process truncates the file meanwhile, this process gets SIGBUS, as
    // every program that maps files; no other memory is affected.
    let map = unsafe { Mmap::map(&file) }.map_err(|error| {
        io_error(if error.raw_os_error() == Some(OUT_OF_MEMORY) {
            let reason =
                format!("the file needs {file_bytes} bytes of the address space, which has fewer left");
            io::Error::new(io::ErrorKind::OutOfMemory, reason + " (see ulimit -v)")
        } else {
            error
        })
    })?;
    let mut warnings = Vec::new();
    let mapping = Mapping::new(map, options);
    let content = if is_gzip(&mapping.map) {
        let compressed = Compressed { rest: &mapping.map, mapping: Some(&mapping) };
        Content::Owned(inflate(&name, compressed, options, &mut warnings)?)
    } else {
        Content::Mapped(mapping)
    };
    Ok(Input { name, base, file_bytes, warnings, content })
}

/// Compressed bytes as a stream.
struct Compressed<'a> {
    rest: &'a [u8],
    /// Receives the number of bytes read.
    mapping: Option<&'a Mapping>,
}

impl BufRead for Compressed<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(&self.rest[..self.rest.len().min(RELEASE_STEP)])
    }

    fn consume(&mut self, count: usize) {
        self.rest = &self.rest[count..];
        if let Some(mapping) = self.mapping {
            mapping.consumed(count as u64);
        }
    }
}

impl Read for Compressed<'_> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.rest.read(to)?;
        if let Some(mapping) = self.mapping {
            mapping.consumed(count as u64);
        }
        Ok(count)
    }
}

/// Reads a stream to its end in steps, so that the memory limit holds for streams of unknown length.
fn read_all(name: &str, stream: impl Read, options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    read_on(name, stream, options, &mut bytes, |source, _| ReadError::Io { file: name.into(), source })?;
    Ok(bytes)
}

/// Appends the rest of a stream; `fail` makes the error of one that breaks off after this many bytes.
fn read_on(
    name: &str,
    mut stream: impl Read,
    options: &ReadOptions,
    bytes: &mut Vec<u8>,
    fail: impl Fn(io::Error, usize) -> ReadError,
) -> Result<(), ReadError> {
    loop {
        // In steps of a quarter, because the whole capacity of a vector counts as taken.
        let step = (bytes.len() / 4).clamp(1 << 16, 1 << 26);
        // A little more than is read, so that detecting the end needs no reallocation.
        bytes.reserve_exact(step + 64);
        let got =
            stream.by_ref().take(step as u64).read_to_end(bytes).map_err(|error| fail(error, bytes.len()))?;
        if got == 0 {
            return Ok(());
        }
        options.check_memory(name, "the content", bytes.len() as u64)?;
        if let Some(p) = options.progress {
            p.advance(got as u64);
        }
    }
}

/// Decompresses gzip: one member after the other, until something else follows. That is ignored with a warning,
/// because tapes and block devices append zeros to a file.
fn inflate(
    name: &str,
    compressed: Compressed,
    options: &ReadOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<u8>, ReadError> {
    if let Some(p) = options.progress {
        p.begin("decompressing", 0);
    }
    let (mut bytes, mut left) = (Vec::new(), compressed);
    while is_gzip(left.rest) {
        let mut member = GzDecoder::new(left);
        read_on(name, &mut member, options, &mut bytes, |error, held| broken_gzip(name, &error, held))?;
        left = member.into_inner();
    }
    let rest = left.rest;
    if !rest.is_empty() {
        let is_zero = pieces(rest, left.mapping).all(|piece| piece.iter().all(|&b| b == 0));
        let what = if is_zero { "zero byte" } else { "byte" };
        warnings.push(format!("ignored {} after the gzip data", counted(rest.len() as u64, what)));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scans_in_pieces_equal_scans_of_the_whole() {
        let options = ReadOptions { memory_limit: Some(1), progress: None, ..ReadOptions::default() };
        for length in [0, 1, RELEASE_STEP - 1, RELEASE_STEP, RELEASE_STEP + 1, 12 * RELEASE_STEP + 7] {
            for marked in [None, Some(0), Some(length / 2), length.checked_sub(1)] {
                let mut bytes = vec![0; length];
                let marked = marked.filter(|&at| at < length);
                marked.into_iter().for_each(|at| bytes[at] = 7);
                let file = tempfile::NamedTempFile::new().unwrap();
                std::fs::write(file.path(), &bytes).unwrap();
                let input = open(file.path(), &options).unwrap();
                let held = input.bytes();
                assert_eq!(input.all(held, |b| b == 0), marked.is_none());
                assert_eq!(input.position(held, |b| b == 7), marked);
                assert_eq!(input.count(held, |b| b == 7), u64::from(marked.is_some()));
                assert_eq!(input.unpadded(held).len(), marked.map_or(0, |at| at + 1));
            }
        }
    }

    #[test]
    fn finished_parts_add_up_to_their_regions() {
        let bytes: Vec<u8> = (0..2 * REGION + REGION / 2 + 5).map(|i| (i % 251) as u8).collect();
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        let input = open(file.path(), &ReadOptions::default()).unwrap();
        let counters = || -> Vec<usize> {
            let mapping = input.mapping().unwrap();
            mapping.finished.iter().map(|n| n.load(Relaxed) as usize).collect()
        };
        let held = input.bytes();
        input.finished(&[]);
        input.finished(&bytes);
        assert_eq!(counters(), [0, 0, 0], "what is not of the file does not count");
        let pieces: Vec<_> = held.chunks(100_003).collect();
        assert_eq!(held, bytes);
        std::thread::scope(|scope| {
            for part in pieces.chunks(pieces.len().div_ceil(3)) {
                scope.spawn(|| part.iter().for_each(|piece| input.finished(piece)));
            }
        });
        assert_eq!(counters(), [REGION, REGION, REGION / 2 + 5]);
        assert_eq!(input.bytes(), bytes, "released pages are read again");
    }
}
