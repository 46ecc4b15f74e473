//! The program that the tests of this crate start with `mpirun`: `tercio-mpi-trial NAME` runs one trial on every
//! rank. A trial that fails panics, which ends the job with exit code 1; rank 0 prints `passed` if all ranks
//! finished.

mod trials;

use std::process::ExitCode;

use tercio_mpi::{MpiComm, run, write_error};
use tercio_parallel::{Communicator as _, ParallelError};

/// A trial and its name.
type Trial = (&'static str, fn(&mut MpiComm) -> Result<(), ParallelError>);

const TRIALS: [Trial; 16] = [
    ("order", trials::order),
    ("everybody-sends-first", trials::everybody_sends_first),
    ("parts", trials::parts),
    ("barrier", trials::barrier),
    ("gather", trials::gather),
    ("groups", trials::groups),
    ("within", trials::within),
    ("any", trials::any),
    ("not-taken", trials::not_taken),
    ("error", trials::error),
    ("panic", trials::panic),
    ("early-end", trials::early_end),
    ("notice", trials::notice),
    ("lines", trials::lines),
    ("silent-end", trials::silent_end),
    ("long-end", trials::long_end),
];

fn main() -> ExitCode {
    let name = std::env::args().nth(1).unwrap_or_default();
    let Some((_, trial)) = TRIALS.iter().find(|t| t.0 == name) else {
        eprintln!("expected one of {}", TRIALS.map(|t| t.0).join(", "));
        return ExitCode::from(2);
    };
    let work = |comm: &mut MpiComm| trial(comm).map(|()| comm.rank());
    match run(work, write_error) {
        Ok(0) => println!("passed"),
        Ok(_) => {}
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
