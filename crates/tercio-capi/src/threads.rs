//! The threads that draw.

use std::error::Error;
use std::ffi::c_int;
use std::sync::Mutex;

use crate::error::status;

/// The number of threads once it is fixed.
static THREADS: Mutex<Option<usize>> = Mutex::new(None);

/// Chooses how many threads draw, for all sessions of this process; 0 for as many as there are processors, shared with the other
/// processes of an MPI job on this machine, which is the default. Call it before the first session is opened. The picture does not
/// depend on it.
#[unsafe(no_mangle)]
pub extern "C" fn tercio_set_threads(threads: u32) -> c_int {
    status(|| start(threads as usize))
}

/// Starts the threads, unless they run.
pub fn start_default() -> Result<(), Box<dyn Error>> {
    let runs = THREADS.lock().unwrap_or_else(|e| e.into_inner()).is_some();
    if runs { Ok(()) } else { start(0) }
}

fn start(requested: usize) -> Result<(), Box<dyn Error>> {
    let threads = if requested > 0 { requested } else { tercio_mpi::own_processors() };
    let mut fixed = THREADS.lock().unwrap_or_else(|e| e.into_inner());
    match *fixed {
        Some(running) if running == threads => Ok(()),
        Some(running) => {
            Err(format!("{running} threads draw already: set their number before the first session").into())
        }
        None => {
            // Calls come from threads of the program, and MPI stays on them; so the work is done by the pool of all callers.
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|number| format!("tercio {number}"))
                .build_global()?;
            *fixed = Some(threads);
            Ok(())
        }
    }
}
