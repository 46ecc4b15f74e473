//! Processes that `mpirun` started: detection, and work that they do together.

#[cfg(any(feature = "mpi", test))]
use std::time::Duration;

use anyhow::Result;
#[cfg(any(feature = "mpi", test))]
use tercio::parallel::comm::RankNames;

pub use ranks::{Comm, library, run, watch};
pub use tercio_mpi::{is_first, is_first_alike, local_processes, own_processors, processes};

/// After this time a rank says which one it waits for.
#[cfg(any(feature = "mpi", test))]
const SILENCE: Duration = Duration::from_secs(10);

/// What it says.
#[cfg(any(feature = "mpi", test))]
fn notice(rank: usize, waited: Duration, from: &RankNames) -> String {
    let seconds = waited.as_secs();
    format!("rank {rank} has waited {seconds} s for {from} (--timeout ends such a job)")
}

/// With the feature `mpi`.
#[cfg(feature = "mpi")]
mod ranks {
    use std::time::Duration;

    use anyhow::Error;
    use tercio::image::remove_partial_files;
    use tercio::parallel::Communicator as _;
    use tercio::parallel::comm::RankNames;
    pub use tercio_mpi::MpiComm as Comm;
    use tercio_mpi::Patience;

    use super::{Result, SILENCE, notice};
    use crate::messages;

    /// Name and version of the MPI library.
    pub fn library(comm: &Comm) -> String {
        comm.library()
    }

    /// From now on this rank says which one it waits for, if it waits for long, and fails after the `timeout`.
    pub fn watch(comm: &mut Comm, timeout: Option<Duration>) {
        let rank = comm.rank();
        let tell = move |from: &RankNames| messages::warning(&notice(rank, SILENCE, from));
        comm.set_patience(Patience { silence: SILENCE, notice: Box::new(tell), timeout });
    }

    /// Runs this rank's part of the work of a job, once. If it fails, the rank prints why and ends the job.
    ///
    /// # Errors
    /// MPI cannot be initialised.
    pub fn run<T>(work: impl FnOnce(&mut Comm) -> Result<T>) -> Result<T> {
        let report = |rank: usize, error: Error| {
            messages::error(&error.context(format!("rank {rank}")));
            // The job is aborted next, without running destructors.
            remove_partial_files();
        };
        Ok(tercio_mpi::run(work, report)?)
    }
}

/// Without the feature.
#[cfg(not(feature = "mpi"))]
mod ranks {
    use std::time::Duration;

    use anyhow::bail;
    use tercio::parallel::Communicator;
    use tercio::parallel::comm::{CommError, Traffic};

    use super::Result;

    /// A communicator that cannot be constructed.
    #[derive(Clone, Copy, Debug)]
    pub enum Comm {}

    impl Communicator for Comm {
        fn rank(&self) -> usize {
            match *self {}
        }

        fn size(&self) -> usize {
            match *self {}
        }

        fn send(&mut self, _: usize, _: Vec<u8>) -> Result<(), CommError> {
            match *self {}
        }

        fn receive(&mut self, _: usize) -> Result<Vec<u8>, CommError> {
            match *self {}
        }

        fn receive_within(&mut self, _: usize, _: Duration) -> Result<Option<Vec<u8>>, CommError> {
            match *self {}
        }

        fn traffic(&self) -> Traffic {
            match *self {}
        }

        fn signal(&mut self, _: usize) -> Result<(), CommError> {
            match *self {}
        }

        fn await_signal(&mut self, _: usize) -> Result<(), CommError> {
            match *self {}
        }
    }

    /// Name and version of the MPI library.
    pub fn library(comm: &Comm) -> String {
        match *comm {}
    }

    /// Says which rank a rank waits for.
    pub fn watch(comm: &mut Comm, _: Option<Duration>) {
        match *comm {}
    }

    /// Fails with how to build a program with MPI.
    ///
    /// # Errors
    /// Always.
    pub fn run<T>(_: impl FnOnce(&mut Comm) -> Result<T>) -> Result<T> {
        let count = super::processes().unwrap_or(1);
        bail!(
            "mpirun started {count} of this program, which was built without MPI: build it with 'cargo build --release \
             --features mpi' (that needs an MPI installation, such as Debian's libopenmpi-dev, and libclang-dev)"
        )
    }
}

#[cfg(test)]
mod tests {
    use tercio::parallel::comm::Awaited;

    use super::*;

    #[test]
    fn a_rank_that_is_silent_for_10_seconds_is_named() {
        let text = "rank 2 has waited 10 s for rank 5 (--timeout ends such a job)";
        assert_eq!(notice(2, SILENCE, &5.into()), text);
        let several = Awaited::new([3, 1]).names();
        assert!(notice(0, SILENCE, &several).contains(&several.to_string()));
    }
}
