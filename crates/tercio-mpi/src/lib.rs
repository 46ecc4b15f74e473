//! Ranks of tercio as processes of an MPI job, on one machine or many.
//!
//! | module | what |
//! |---|---|
//! | [`launch`] | whether this process was started by `mpirun`, and with how many others |
//! | [`message`] | lines on standard error that stay in one piece among those of other processes |
//! | `job` | initializes and finalizes MPI; a rank that fails ends the job |
//! | `comm` | messages: the MPI backend of `tercio_parallel::Communicator` |
//!
//! `job` and `comm` need the feature `mpi`, which needs an MPI installation (Debian: libopenmpi-dev) and libclang; so
//! a workspace without it builds on every machine. `unsafe` is confined to the module `raw`, the calls of the C
//! library.
//!
//! # Examples
//!
//! Every process of a job does its own rank's work:
//!
#![cfg_attr(feature = "mpi", doc = "```no_run")]
#![cfg_attr(not(feature = "mpi"), doc = "```ignore")]
//! use tercio_parallel::Communicator;
//! use tercio_parallel::comm::CommError;
//!
//! let work = |comm: &mut tercio_mpi::MpiComm| {
//!     comm.barrier()?;
//!     Ok::<_, CommError>((comm.rank(), comm.size()))
//! };
//! let (rank, size) = tercio_mpi::run(work, tercio_mpi::write_error)?;
//! assert!(rank < size && Some(size) == tercio_mpi::processes());
//! # Ok::<(), tercio_mpi::StartError>(())
//! ```
//!
//! Whether there is a job can be tested without MPI:
//!
//! ```
//! match tercio_mpi::processes() {
//!     Some(count) => assert!(count > 0),
//!     None => println!("not started by mpirun: one process"),
//! }
//! ```

#[cfg(feature = "mpi")]
pub mod comm;
#[cfg(feature = "mpi")]
pub mod job;
pub mod launch;
pub mod message;
mod processors;
#[cfg(feature = "mpi")]
mod raw;
#[cfg(feature = "mpi")]
mod spare;
#[cfg(feature = "mpi")]
mod waiting;

#[cfg(feature = "mpi")]
pub use comm::{MpiComm, Patience};
#[cfg(feature = "mpi")]
pub use job::{StartError, run};
pub use launch::{is_first, is_first_alike, local_processes, processes};
pub use message::{write_error, write_line};
pub use processors::own_processors;
