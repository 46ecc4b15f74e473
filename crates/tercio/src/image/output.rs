//! Output that replaces a good file only by a whole one.

use std::fs::{self, File};
use std::io::{self, BufWriter, Stdout, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Where something is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// Standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl Destination {
    /// `-` is standard output, everything else a file.
    pub fn parse(path: &Path) -> Self {
        if path.as_os_str() == "-" { Self::Stdout } else { Self::File(path.into()) }
    }

    /// Tells early, before work is done, what will certainly fail later.
    ///
    /// # Errors
    /// If the folder is not there, or a folder stands in the file's place.
    pub fn check(&self) -> io::Result<()> {
        let Self::File(path) = self else { return Ok(()) };
        if path.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder"));
        }
        let folder = folder_of(path);
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
/// The bytes go to a temporary file in the same folder, which [`OutputFile::commit`] gives its final name.
/// Without `commit` the temporary file goes and a file of that name stays as it was. Devices and pipes are
/// written directly; a symbolic link stays, and the file that it points to is replaced.
#[derive(Debug)]
pub struct OutputFile(Target);

#[derive(Debug)]
enum Target {
    Direct(BufWriter<Direct>),
    Temporary { file: BufWriter<NamedTempFile>, path: PathBuf },
}

#[derive(Debug)]
enum Direct {
    Stdout(Stdout),
    Device(File),
}

impl OutputFile {
    /// Begins a file.
    ///
    /// # Errors
    /// The system's reason why there can be none.
    pub fn create(destination: &Destination) -> io::Result<Self> {
        destination.check()?;
        let path = match destination {
            Destination::Stdout => return Ok(Self::direct(Direct::Stdout(io::stdout()))),
            Destination::File(path) => path,
        };
        let existing = fs::metadata(path).ok();
        if existing.as_ref().is_some_and(|m| !m.is_file()) {
            return Ok(Self::direct(Direct::Device(File::options().write(true).open(path)?)));
        }
        let path = if existing.is_some() { fs::canonicalize(path)? } else { path.clone() };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".tercio-").suffix(".part");
        // Temporary files are private by default; this one becomes the user's file.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder_of(&path))?;
        if let Some(existing) = existing {
            if existing.permissions().readonly() {
                return Err(io::Error::new(io::ErrorKind::PermissionDenied, "is read-only"));
            }
            file.as_file().set_permissions(existing.permissions())?;
        }
        Ok(Self(Target::Temporary { file: BufWriter::new(file), path }))
    }

    fn direct(target: Direct) -> Self {
        Self(Target::Direct(BufWriter::with_capacity(1 << 16, target)))
    }

    /// Makes what was written visible under its name.
    ///
    /// # Errors
    /// The system's reason why it could not; the old file is still there.
    pub fn commit(self) -> io::Result<()> {
        match self.0 {
            Target::Direct(mut out) => out.flush(),
            Target::Temporary { file, path } => {
                let file = file.into_inner().map_err(|e| e.into_error())?;
                file.persist(path).map_err(|e| e.error)?;
                Ok(())
            }
        }
    }
}

/// The folder that a file stands in; `path.parent()` of a bare name is empty, not the current folder.
fn folder_of(path: &Path) -> &Path {
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
            Self::Stdout(out) => out.write(bytes),
            Self::Device(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Stdout(out) => out.flush(),
            Self::Device(out) => out.flush(),
        }
    }
}
