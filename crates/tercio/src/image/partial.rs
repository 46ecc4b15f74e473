//! The partial files of this process, so that none remains if the process ends without unwinding.

use std::io;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::thread;
use std::time::Duration;

use tempfile::NamedTempFile;

static FILES: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

#[derive(Debug)]
struct Entry {
    number: u64,
    path: PathBuf,
}

/// Keeps a partial file in the list until it has its final name or is removed.
#[derive(Debug)]
pub(super) struct Listed(u64);

/// Creates a partial file and lists it, atomically with respect to `remove_partial_files`.
pub(super) fn create(
    make: impl FnOnce() -> io::Result<NamedTempFile>,
) -> io::Result<(NamedTempFile, Listed)> {
    let mut files = lock();
    let file = make()?;
    let number = files.last().map_or(0, |last| last.number + 1);
    files.push(Entry { number, path: file.path().to_owned() });
    Ok((file, Listed(number)))
}

impl Drop for Listed {
    fn drop(&mut self) {
        lock().retain(|entry| entry.number != self.0);
    }
}

fn lock() -> MutexGuard<'static, Vec<Entry>> {
    FILES.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Removes all partial files of this process: those that [`OutputFile`](super::OutputFile) writes to until they are
/// complete. For programs that are about to end without dropping their values, because of a signal, an abort or a
/// lack of memory. Files of the final names are unchanged.
///
/// Call it only right before the process ends: any thread that creates or finishes an output file afterwards blocks
/// forever. It allocates no memory (for paths shorter than 384 bytes), and is best-effort: it gives up after a moment
/// if another thread, or this one, is just creating a partial file.
pub fn remove_partial_files() {
    const TRIES: u32 = 100;
    for _ in 0..TRIES {
        let files = match FILES.try_lock() {
            Ok(files) => files,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                thread::sleep(Duration::from_millis(1));
                continue;
            }
        };
        for entry in files.iter() {
            // A file that no longer exists has got its final name.
            let _ = std::fs::remove_file(&entry.path);
        }
        // The list stays locked, so that no file is created afterwards.
        std::mem::forget(files);
        return;
    }
}
