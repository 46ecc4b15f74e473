//! Initializes and finalizes MPI. A rank that fails ends the whole job: the others would wait for it forever.

use std::panic::{AssertUnwindSafe, catch_unwind};

use mpi::Threading;
use tercio_parallel::Communicator as _;
use tercio_parallel::comm::CommError;

use crate::MpiComm;
use crate::message::write_line;
use crate::raw::{Failed, Link};

/// Exit code of a job in which a rank failed.
pub const FAILURE: i32 = 1;

/// Why MPI could not be initialized. If the library cannot find the other processes it reports that itself and ends
/// the job.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// A process can initialize MPI only once.
    #[error("MPI was already initialized in this process")]
    Twice,
    /// The library was built without threads, or the program has initialized it without.
    #[error(
        "MPI does not allow threads beside the one that calls it: initialize it with MPI_Init_thread and MPI_THREAD_FUNNELED"
    )]
    Threads,
    /// The program has not initialized MPI, or has finalized it.
    #[error("MPI is not initialized in this process")]
    Missing,
    /// A call failed.
    #[error("{0}")]
    Failed(String),
}

/// Runs this rank's work of an MPI job; all its processes have to call this, once. Returns when all ranks are done.
///
/// If the work fails on this rank, `tell` is called with the rank's number and the error
/// ([`write_error`](crate::write_error) writes both), and all processes of the job end with exit code 1; so they do
/// after a panic. There is no unwinding then, so incomplete files should not have their final names yet.
///
/// # Errors
/// [`StartError`], before any work is done.
pub fn run<T, E: From<CommError>>(
    work: impl FnOnce(&mut MpiComm) -> Result<T, E>,
    tell: impl FnOnce(usize, E),
) -> Result<T, StartError> {
    // MPI is called from this thread only, which may use other threads for drawing.
    let (universe, threads) = mpi::initialize_with_threading(Threading::Funneled).ok_or(StartError::Twice)?;
    if threads < Threading::Funneled {
        return Err(StartError::Threads);
    }
    let link = Link::new(&universe.world()).map_err(|Failed(reason)| StartError::Failed(reason))?;
    let mut comm = MpiComm::new(link);
    let rank = comm.rank();
    let done = match catch_unwind(AssertUnwindSafe(|| work(&mut comm))) {
        Ok(Ok(done)) => done,
        Ok(Err(error)) => {
            tell(rank, error);
            comm.abort(FAILURE);
        }
        Err(_) => {
            // The panic has printed its message and location.
            write_line(&format!("error: rank {rank} panicked"));
            comm.abort(FAILURE);
        }
    };
    let Err(error) = comm.leave(Some(0)) else { return Ok(done) };
    tell(rank, error.into());
    comm.abort(FAILURE)
}
