//! The identity of a file, independent of the spelling of its name.

use std::path::Path;

use super::output::{Destination, folder_of, resolve};

/// A file, identified by what it is and not by its name: `./a.png`, a symbolic link and a hard link are the same as
/// `a.png`.
///
/// Only files have an identity. Pipes, terminals and devices such as `/dev/null` may be written to by several at
/// once.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FileIdentity(Which);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Which {
    There(system::Number),
    /// A file that does not exist yet: the folder and the name in it.
    NotYet(system::Number, std::ffi::OsString),
}

impl FileIdentity {
    /// The file of this name; `None` for anything that is not a file or cannot be accessed.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        Self::at(path.as_ref())
    }

    fn at(path: &Path) -> Option<Self> {
        match std::fs::metadata(path) {
            Ok(metadata) => Some(Self(Which::There(system::of_file(path, &metadata)?))),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let path = resolve(path);
                let folder = system::of_folder(folder_of(&path))?;
                Some(Self(Which::NotYet(folder, path.file_name()?.to_owned())))
            }
            Err(_) => None,
        }
    }

    /// True for files of one folder that do not exist yet and whose names differ only in case: some systems would
    /// make one file of them, which cannot be known in advance.
    pub fn differs_in_case_alone(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Which::NotYet(folder, name), Which::NotYet(other_folder, other_name)) => {
                let [name, other_name] = [name, other_name].map(|n| n.to_str());
                folder == other_folder
                    && name != other_name
                    && name.map(str::to_lowercase) == other_name.map(str::to_lowercase)
            }
            _ => false,
        }
    }

    /// The same for files of one folder that do not exist yet and whose names differ in nothing but case; `None` for others.
    pub fn name_in_any_case(&self) -> Option<impl Eq + std::hash::Hash + use<>> {
        match &self.0 {
            Which::NotYet(folder, name) => Some((*folder, name.to_str()?.to_lowercase())),
            Which::There(_) => None,
        }
    }

    /// The file that a destination writes to.
    pub fn from_destination(destination: &Destination) -> Option<Self> {
        match destination {
            Destination::Stdout => system::of_standard_output().map(Which::There).map(Self),
            Destination::File(path) => Self::at(path),
        }
    }

    /// The file that standard error goes to.
    pub(super) fn standard_error() -> Option<Self> {
        system::of_standard_error().map(Which::There).map(Self)
    }

    /// The file that standard input comes from.
    pub fn standard_input() -> Option<Self> {
        system::of_standard_input().map(Which::There).map(Self)
    }
}

#[cfg(unix)]
mod system {
    use std::fs::{File, Metadata};
    use std::io;
    use std::os::fd::{AsFd, BorrowedFd};
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    use std::path::Path;

    /// Device, and inode number on it.
    pub type Number = (u64, u64);

    pub fn of_file(_: &Path, metadata: &Metadata) -> Option<Number> {
        let kind = metadata.file_type();
        (kind.is_file() || kind.is_block_device()).then(|| (metadata.dev(), metadata.ino()))
    }

    pub fn of_folder(path: &Path) -> Option<Number> {
        let metadata = std::fs::metadata(path).ok().filter(Metadata::is_dir)?;
        Some((metadata.dev(), metadata.ino()))
    }

    pub fn of_standard_output() -> Option<Number> {
        of_open(io::stdout().as_fd())
    }

    pub fn of_standard_error() -> Option<Number> {
        of_open(io::stderr().as_fd())
    }

    pub fn of_standard_input() -> Option<Number> {
        of_open(io::stdin().as_fd())
    }

    fn of_open(file: BorrowedFd) -> Option<Number> {
        let file = File::from(file.try_clone_to_owned().ok()?);
        of_file(Path::new(""), &file.metadata().ok()?)
    }
}

#[cfg(not(unix))]
mod system {
    use std::fs::{Metadata, canonicalize};
    use std::path::{Path, PathBuf};

    /// The full path, without links.
    pub type Number = PathBuf;

    pub fn of_file(path: &Path, metadata: &Metadata) -> Option<Number> {
        metadata.is_file().then(|| canonicalize(path).ok()).flatten()
    }

    pub fn of_folder(path: &Path) -> Option<Number> {
        canonicalize(path).ok()
    }

    pub fn of_standard_output() -> Option<Number> {
        None
    }

    pub fn of_standard_error() -> Option<Number> {
        None
    }

    pub fn of_standard_input() -> Option<Number> {
        None
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn spelling_does_not_matter() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "").unwrap();
        fs::create_dir(at("d")).unwrap();
        symlink("a", at("to_a")).unwrap();
        symlink(at("to_a"), at("to_to_a")).unwrap();
        symlink("d/new", at("to_new")).unwrap();
        symlink(".", at("d/here")).unwrap();
        symlink("loop", at("loop")).unwrap();
        fs::hard_link(at("a"), at("also_a")).unwrap();
        let id = |name: &str| FileIdentity::from_path(at(name));
        let a = id("a");
        assert!(a.is_some());
        for same in ["./a", "d/../a", "to_a", "to_to_a", "also_a"] {
            assert_eq!(id(same), a, "{same}");
        }
        let new = id("d/new");
        assert!(new.is_some() && new != a && new != id("new"));
        for same in ["d/./new", "to_new", "d/here/new", "d/../d/new"] {
            assert_eq!(id(same), new, "{same}");
        }
        let differs = |a: &str, b: &str| id(a).unwrap().differs_in_case_alone(&id(b).unwrap());
        assert!(differs("d/new", "d/NEW") && differs("d/\u{e4}", "d/here/\u{c4}"));
        assert!(!differs("d/new", "New") && !differs("d/new", "to_new") && !differs("a", "A"));
        for none in ["d", "missing/new", "loop", "a/b"] {
            assert_eq!(id(none), None, "{none}");
        }
        for special in ["/dev/null", "/dev/full"] {
            assert_eq!(FileIdentity::from_path(special), None, "{special}");
        }
    }
}
