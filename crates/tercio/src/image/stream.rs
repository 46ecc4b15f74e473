//! File names that refer to files that are open already.

use std::fs;
use std::path::Path;

use super::output::{folder_of, links};

/// One of the three files that are open when a program starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandardStream {
    /// Standard input.
    Input,
    /// Standard output.
    Output,
    /// Standard error.
    Error,
}

impl StandardStream {
    /// The stream that a file name refers to on Unix: `/dev/stdin`, `/dev/fd/1`, `/proc/self/fd/2`, other spellings
    /// of these, and symbolic links to them. `-` is not among them, because its meaning depends on the context.
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        match OpenFile::from_path(path.as_ref())? {
            OpenFile::Own(0) => Some(Self::Input),
            OpenFile::Own(1) => Some(Self::Output),
            OpenFile::Own(2) => Some(Self::Error),
            _ => None,
        }
    }
}

/// A file that is open already and has a name of its own as an open file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OpenFile {
    /// In this process, with its descriptor number.
    Own(u32),
    /// In another process.
    OfAnother,
}

impl OpenFile {
    /// The open file that a name refers to, directly or through symbolic links. The last link, from `/proc/self/fd/1`
    /// to the file itself, is not followed: the file's own path does not show that it is open.
    pub(super) fn from_path(path: &Path) -> Option<Self> {
        if cfg!(unix) { links(path).find_map(|hop| Self::named(&hop)) } else { None }
    }

    fn named(path: &Path) -> Option<Self> {
        // Links to /proc on Linux, devices elsewhere.
        for (number, name) in ["/dev/stdin", "/dev/stdout", "/dev/stderr"].into_iter().enumerate() {
            if path == Path::new(name) {
                return Some(Self::Own(number as u32));
            }
        }
        let number = path.file_name()?.to_str()?.parse().ok()?;
        let folder = folder_of(path);
        let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
        let parts: Vec<_> = folder.iter().filter_map(|part| part.to_str()).collect();
        let process = match parts[..] {
            ["/", "dev", "fd"] => "self",
            ["/", "proc", process, "fd"] | ["/", "proc", process, "task", _, "fd"] => process,
            _ => return None,
        };
        let is_own = process == "self" || process == "thread-self" || {
            // If /proc belongs to another PID namespace, only this link shows the number of this process there.
            fs::read_link("/proc/self").is_ok_and(|own| own == Path::new(process))
        };
        Some(if is_own { Self::Own(number) } else { Self::OfAnother })
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn streams_are_found_however_they_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink("/dev/stdout", at("out")).unwrap();
        symlink("out", at("to_out")).unwrap();
        symlink("/proc/thread-self/fd", at("open")).unwrap();
        symlink("loop", at("loop")).unwrap();
        fs::write(at("1"), "").unwrap();
        let own = format!("/proc/{}/fd/1", std::process::id());
        let to_out = at("to_out");
        for name in [
            "/dev/stdout",
            "/dev/fd/1",
            "/proc/self/fd/1",
            "/proc/thread-self/fd/1",
            "/dev/../dev/fd/./1",
            &own,
        ] {
            assert_eq!(StandardStream::from_path(name), Some(StandardStream::Output), "{name}");
        }
        assert_eq!(StandardStream::from_path(&to_out), Some(StandardStream::Output));
        assert_eq!(StandardStream::from_path(at("open/2")), Some(StandardStream::Error));
        assert_eq!(StandardStream::from_path("/dev/stdin"), Some(StandardStream::Input));
        assert_eq!(OpenFile::from_path("/dev/fd/7".as_ref()), Some(OpenFile::Own(7)));
        assert_eq!(OpenFile::from_path("/proc/1/fd/1".as_ref()), Some(OpenFile::OfAnother));
        for name in ["1", "loop", "missing"] {
            assert_eq!(OpenFile::from_path(&at(name)), None, "{name}");
        }
        for name in ["-", "", "/", "/dev/null", "/dev/fd", "/dev/fd/x", "/proc/self/stat"] {
            assert_eq!(OpenFile::from_path(name.as_ref()), None, "{name}");
        }
    }
}
