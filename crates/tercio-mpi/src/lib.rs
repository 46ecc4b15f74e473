//! Ranks of tercio as processes of an MPI job, on one machine or many.
//!
//! | module | what |
//! |---|---|
//! | [`launch`] | whether this process was started by `mpirun`, and with how many others |
//! | `job` | begins and ends MPI; a rank that fails ends them all |
//! | `comm` | messages: the MPI backend of `tercio_parallel::Communicator` |
//!
//! `job` and `comm` need the feature `mpi`, which needs an MPI installation (Debian: libopenmpi-dev) and libclang; so a
//! workspace without it builds on every machine. `unsafe` stands in the module `raw`, the calls of the C library.

#[cfg(feature = "mpi")]
pub mod comm;
#[cfg(feature = "mpi")]
pub mod job;
pub mod launch;
#[cfg(feature = "mpi")]
mod raw;
#[cfg(feature = "mpi")]
mod spare;
#[cfg(feature = "mpi")]
mod waiting;

#[cfg(feature = "mpi")]
pub use comm::MpiComm;
#[cfg(feature = "mpi")]
pub use job::{StartError, run};
pub use launch::processes;
