//! Output that replaces an existing file only when the new one is complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::identity::FileIdentity;
use super::partial::{self, Listed};
use super::stream::{OpenFile, StandardStream};

/// Where output is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// Standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl Destination {
    /// `-` is standard output, and so are the names of its [`StandardStream`]; everything else is a file.
    pub fn from_path(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref();
        if path.as_os_str() == "-" || StandardStream::from_path(path) == Some(StandardStream::Output) {
            Self::Stdout
        } else {
            Self::File(path.into())
        }
    }

    /// Reports early, before work is done, what will certainly fail later.
    ///
    /// # Errors
    /// If the folder does not exist, or there is a folder of the file's name.
    pub fn check(&self) -> io::Result<()> {
        let Self::File(path) = self else { return Ok(()) };
        if path.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder"));
        }
        let path = resolve(path);
        let folder = folder_of(&path);
        match fs::metadata(folder) {
            Ok(m) if m.is_dir() => Ok(()),
            Ok(_) => Err(io::Error::new(
                io::ErrorKind::NotADirectory,
                format!("{} is not a folder", folder.display()),
            )),
            Err(e) => Err(io::Error::new(e.kind(), format!("folder {}: {e}", folder.display()))),
        }
    }
}

/// A file being written, or standard output.
///
/// The bytes go to a temporary file in the same folder, to which [`OutputFile::commit`] gives its final name. Without
/// `commit` the temporary file is removed and a file of the final name is unchanged. Where the process ends without
/// dropping this, [`remove_partial_files`](super::remove_partial_files) removes it. Devices, pipes and files that are
/// open already (`/dev/fd/3`, and whatever standard output or standard error goes to) are written directly; a
/// symbolic link is kept, and the file that it points to is replaced or made.
#[derive(Debug)]
pub struct OutputFile(Target);

#[derive(Debug)]
enum Target {
    Direct(BufWriter<Direct>),
    // Dropped in this order: the file, then its entry in the list.
    Temporary { file: BufWriter<NamedTempFile>, path: PathBuf, _listed: Listed },
}

#[derive(Debug)]
enum Direct {
    /// Where standard output is not available as a file.
    #[cfg(not(unix))]
    Stdout(io::Stdout),
    File(File),
}

impl OutputFile {
    /// Creates a file.
    ///
    /// # Errors
    /// The system's reason for a failure.
    pub fn create(destination: &Destination) -> io::Result<Self> {
        destination.check()?;
        let path = match destination {
            Destination::Stdout => return Ok(Self::direct(standard_output()?)),
            Destination::File(path) => path,
        };
        if let Some(open) = open_already(path) {
            return Ok(Self::direct(open?));
        }
        let existing = fs::metadata(path).ok();
        if existing.as_ref().is_some_and(|m| !m.is_file()) {
            return Ok(Self::direct(Direct::File(File::options().write(true).open(path)?)));
        }
        let path = if existing.is_some() { fs::canonicalize(path)? } else { resolve(path) };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".tercio-").suffix(".part");
        // Temporary files are private by default; this one gets the permissions of an ordinary file.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let (file, listed) = partial::create(|| builder.tempfile_in(folder_of(&path)))?;
        if let Some(existing) = existing {
            if existing.permissions().readonly() {
                return Err(io::Error::new(io::ErrorKind::PermissionDenied, "is read-only"));
            }
            file.as_file().set_permissions(existing.permissions())?;
        }
        Ok(Self(Target::Temporary { file: BufWriter::new(file), path, _listed: listed }))
    }

    fn direct(target: Direct) -> Self {
        Self(Target::Direct(BufWriter::with_capacity(1 << 16, target)))
    }

    /// The temporary file, for another program that fills it; `None` if the output is written directly.
    pub fn temporary_path(&self) -> Option<&Path> {
        match &self.0 {
            Target::Temporary { file, .. } => Some(file.get_ref().path()),
            Target::Direct(_) => None,
        }
    }

    /// Makes what was written visible under its final name.
    ///
    /// # Errors
    /// The system's reason for a failure; the old file still exists.
    pub fn commit(self) -> io::Result<()> {
        match self.0 {
            Target::Direct(mut out) => out.flush(),
            Target::Temporary { file, path, _listed } => {
                let file = file.into_inner().map_err(|e| e.into_error())?;
                file.persist(path).map_err(|e| e.error)?;
                Ok(())
            }
        }
    }
}

/// Standard output as a file of its own: the standard library reports success for a write that failed because
/// standard output was opened for reading only.
#[cfg(unix)]
fn standard_output() -> io::Result<Direct> {
    use std::os::fd::AsFd;
    let mut shared = io::stdout();
    shared.flush()?;
    Ok(Direct::File(File::from(shared.as_fd().try_clone_to_owned()?)))
}

#[cfg(not(unix))]
fn standard_output() -> io::Result<Direct> {
    Ok(Direct::Stdout(io::stdout()))
}

/// Standard error as a file of its own.
#[cfg(unix)]
fn standard_error() -> io::Result<Direct> {
    use std::os::fd::AsFd;
    Ok(Direct::File(File::from(io::stderr().as_fd().try_clone_to_owned()?)))
}

#[cfg(not(unix))]
fn standard_error() -> io::Result<Direct> {
    Err(io::ErrorKind::Unsupported.into())
}

/// A file that is open already, according to its name or identity. Whoever opened it may have written to it, as a
/// shell does with `2>>log`: it must not be replaced. Standard output and standard error are written at their current
/// position, so that the output of other programs is appended after it. A file that is standard input is only read,
/// and may be replaced.
fn open_already(path: &Path) -> Option<io::Result<Direct>> {
    match OpenFile::from_path(path) {
        Some(OpenFile::Own(1)) => return Some(standard_output()),
        Some(OpenFile::Own(2)) => return Some(standard_error()),
        Some(_) => return Some(File::options().append(true).open(path).map(Direct::File)),
        None => {}
    }
    let identity = FileIdentity::from_path(path)?;
    if FileIdentity::from_destination(&Destination::Stdout).as_ref() == Some(&identity) {
        Some(standard_output())
    } else if FileIdentity::standard_error().as_ref() == Some(&identity) {
        Some(standard_error())
    } else {
        None
    }
}

/// The path of the file that this name refers to, existing or not: symbolic links are followed, also to a file that
/// does not exist yet.
pub(super) fn resolve(path: &Path) -> PathBuf {
    links(path).last().unwrap_or_else(|| path.to_path_buf())
}

/// A path, and the paths that its symbolic links lead to, one after the other.
pub(super) fn links(path: &Path) -> impl Iterator<Item = PathBuf> {
    // The number of links that Linux follows.
    const MOST_LINKS: usize = 40;
    let next = |path: &PathBuf| fs::read_link(path).ok().map(|target| folder_of(path).join(target));
    std::iter::successors(Some(path.to_path_buf()), next).take(1 + MOST_LINKS)
}

/// The folder that contains a file; `path.parent()` of a bare name is empty, not the current folder.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.0 {
            Target::Direct(out) => out.write(bytes),
            Target::Temporary { file, .. } => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.0 {
            Target::Direct(out) => out.flush(),
            Target::Temporary { file, .. } => file.flush(),
        }
    }
}

impl Write for Direct {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            #[cfg(not(unix))]
            Self::Stdout(out) => out.write(bytes),
            Self::File(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            #[cfg(not(unix))]
            Self::Stdout(out) => out.flush(),
            Self::File(out) => out.flush(),
        }
    }
}
