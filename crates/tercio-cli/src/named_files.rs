//! The files that a command line names. The rule for all commands: no output is an input or another output.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use anyhow::{Context, Result};
use tercio::image::{Destination, FileIdentity};

use crate::output::{self, UsageError};

/// Paths of files that a command reads, those that its models name included.
#[derive(Clone, Debug, Default)]
pub struct FilesRead(Arc<Mutex<BTreeSet<PathBuf>>>);

impl FilesRead {
    /// All paths so far.
    pub fn paths(&self) -> BTreeSet<PathBuf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn extend<'a>(&self, paths: impl IntoIterator<Item = &'a PathBuf>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(paths.into_iter().cloned());
    }
}

/// The inputs and outputs of a command. Names are collected first, then [`NamedFiles::check`]ed, before anything is
/// read.
#[derive(Debug, Default)]
pub struct NamedFiles {
    read: Vec<Named>,
    written: Vec<(Named, Destination)>,
    /// Companions that no output replaces.
    checked: Mutex<HashSet<PathBuf>>,
    newest_input: Option<SystemTime>,
    /// Inputs and companions, with their paths.
    paths: FilesRead,
}

#[derive(Debug)]
struct Named {
    /// As on the command line: the option, or the kind of file, and its name.
    words: String,
    identity: Option<FileIdentity>,
}

impl NamedFiles {
    /// From now on, adds the paths of inputs and companions to `paths`.
    pub fn recording(mut self, paths: &FilesRead) -> Self {
        // All models of a batch record in the same place.
        if !Arc::ptr_eq(&self.paths.0, &paths.0) {
            paths.extend(&self.paths.paths());
            self.paths = paths.clone();
        }
        self
    }

    /// Adds an input, `-` for standard input. `what` is its kind: "the model".
    pub fn reads(mut self, what: &str, path: &Path) -> Self {
        let named = if path.as_os_str() == "-" {
            Named { words: format!("{what} from standard input"), identity: FileIdentity::standard_input() }
        } else {
            self.paths.extend([&path.to_path_buf()]);
            Named { words: format!("{what} {}", path.display()), identity: FileIdentity::from_path(path) }
        };
        self.read.push(named);
        self.newest_input = self.newest_input.max(output::modified(path));
        self
    }

    /// When the input that was changed last was changed, of those that are files.
    pub fn newest_input(&self) -> Option<SystemTime> {
        self.newest_input
    }

    /// Adds a model; one that is built in is no file.
    pub fn reads_model(self, path: &Path) -> Self {
        let is_builtin = path.to_str().is_some_and(|name| name.starts_with("builtin:"));
        if is_builtin { self } else { self.reads("the model", path) }
    }

    /// Adds a description of a machine; built-in ones are no files.
    pub fn reads_machine(self, name: &str) -> Self {
        if tercio_lab::machines::NAMES.contains(&name) {
            self
        } else {
            self.reads("the machine", name.as_ref())
        }
    }

    /// Adds an output with its option.
    pub fn writes(mut self, option: &str, destination: &Destination) -> Self {
        let words = match destination {
            Destination::Stdout => format!("{option} -"),
            Destination::File(path) => format!("{option} {}", path.display()),
        };
        let identity = FileIdentity::from_destination(destination);
        self.written.push((Named { words, identity }, destination.clone()));
        self
    }

    /// Adds standard output, for commands that print their results.
    pub fn prints(mut self) -> Self {
        let identity = FileIdentity::from_destination(&Destination::Stdout);
        self.written.push((Named { words: "standard output".into(), identity }, Destination::Stdout));
        self
    }

    /// Checks that no output is an input or another output.
    ///
    /// # Errors
    /// [`UsageError`] with both names.
    pub fn check(&self) -> Result<(), UsageError> {
        let (mut files, mut names) = (HashMap::new(), HashMap::new());
        let mut standard_output: Option<&Named> = None;
        for (output, destination) in &self.written {
            if *destination == Destination::Stdout
                && let Some(other) = standard_output.replace(output)
            {
                return Err(UsageError(format!(
                    "{} and {}: only one output can go to standard output",
                    other.words, output.words
                )));
            }
            let Some(identity) = &output.identity else { continue };
            if let Some(other) = files.insert(identity, output) {
                return Err(UsageError(format!(
                    "{} and {} are the same file: each output needs a file of its own",
                    other.words, output.words
                )));
            }
            if let Some(key) = identity.name_in_any_case()
                && let Some(other) = names.insert(key, output)
            {
                return Err(UsageError(format!(
                    "{} and {} differ by upper and lower case alone, and may be the same file: choose other names",
                    other.words, output.words
                )));
            }
        }
        self.check_against(&self.read)
    }

    /// Checks that no output is one of the other files of a loaded model.
    ///
    /// # Errors
    /// [`UsageError`] with both names.
    pub fn check_companions(&self, model: &str, companions: &[PathBuf]) -> Result<(), UsageError> {
        self.paths.extend(companions);
        if companions.is_empty() || self.written.iter().all(|(output, _)| output.identity.is_none()) {
            return Ok(());
        }
        // Each time of a collection names the files of all times: the file system is asked once about each.
        let mut checked = self.checked.lock().unwrap_or_else(PoisonError::into_inner);
        // A missing file cannot be overwritten; it may be there later.
        let there: Vec<&PathBuf> =
            companions.iter().filter(|path| !checked.contains(*path) && path.is_file()).collect();
        let named = |path: &PathBuf| Named {
            words: format!("a material library or texture of {model}"),
            identity: FileIdentity::from_path(path),
        };
        self.check_against(&there.iter().copied().map(named).collect::<Vec<_>>())?;
        checked.extend(there.into_iter().cloned());
        Ok(())
    }

    /// Does any output replace a file?
    pub fn replaces_any(&self) -> bool {
        self.written.iter().any(|(_, to)| matches!(to, Destination::File(path) if path.is_file()))
    }

    fn check_against(&self, read: &[Named]) -> Result<(), UsageError> {
        let known = |named: &'_ Named| named.identity.clone();
        let inputs: HashMap<_, _> = read.iter().filter_map(|input| Some((known(input)?, input))).collect();
        let of_output =
            |(output, _): &'_ (Named, Destination)| inputs.get(output.identity.as_ref()?).copied();
        match self.written.iter().find_map(|written| Some((&written.0, of_output(written)?))) {
            Some((output, input)) => Err(UsageError(format!(
                "{} and {} are the same file: an output must not be an input",
                output.words, input.words
            ))),
            None => Ok(()),
        }
    }

    /// Makes the folders of outputs that are missing inside of folders that there are: those of many pictures. Then files in them
    /// have an identity, and are [checked](Self::check).
    ///
    /// # Errors
    /// The first folder that cannot be made; those of the check, then no folder stays.
    pub fn make_folders(&mut self) -> Result<()> {
        let (mut made, mut are_new) = (Vec::new(), false);
        for (_, destination) in &self.written {
            let Destination::File(path) = destination else { continue };
            let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) else {
                continue;
            };
            let above = folder.parent().is_some_and(|above| above.as_os_str().is_empty() || above.is_dir());
            if folder.exists() || !above {
                continue;
            }
            are_new = true;
            match std::fs::create_dir(folder) {
                Ok(()) => made.push(folder.to_owned()),
                // Another run has made it.
                Err(error) if error.kind() == ErrorKind::AlreadyExists && folder.is_dir() => {}
                Err(error) => return Err(error).with_context(|| format!("folder {}", folder.display())),
            }
        }
        if !are_new {
            return Ok(());
        }
        for (named, destination) in &mut self.written {
            named.identity = FileIdentity::from_destination(destination);
        }
        self.check().inspect_err(|_| {
            // One that is not empty is somebody else's.
            made.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
        })?;
        Ok(())
    }

    /// [`NamedFiles::check`] and [`NamedFiles::check_places`].
    ///
    /// # Errors
    /// Those of both.
    pub fn ready(&self) -> Result<()> {
        self.check()?;
        self.check_places()
    }

    /// Checks before the work that all outputs can be written.
    ///
    /// # Errors
    /// The first output whose folder is missing; standard output if it is closed.
    pub fn check_places(&self) -> Result<()> {
        self.written.iter().try_for_each(|(_, destination)| output::check(destination))
    }
}
