//! Jobs of `mpirun`. Ranks share the processors of the machine, however few it has.

use std::process::{Command, Output};

/// Seconds after which a job is taken to hang.
const HANGS: &str = "600";

/// Runs a trial with some ranks, by a user who may be root.
fn mpirun(ranks: usize, trial: &str) -> Output {
    Command::new("timeout")
        .args(["--kill-after=10", HANGS, "mpirun", "--oversubscribe", "-n"])
        .arg(ranks.to_string())
        .arg(env!("CARGO_BIN_EXE_tercio-mpi-trial"))
        .arg(trial)
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .output()
        .expect("timeout and mpirun start")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn holds(trial: &str) {
    for ranks in [1, 2, 3, 4] {
        let output = mpirun(ranks, trial);
        let told = format!("{trial}, {ranks} ranks: {}", text(&output.stderr));
        assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(0), "held\n"), "{told}");
    }
}

/// The job ends with code 1, which a hanging one does not, and says why.
#[track_caller]
fn fails(trial: &str, says: &str) {
    for ranks in [2, 4] {
        let output = mpirun(ranks, trial);
        let told = text(&output.stderr);
        assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(1), ""), "{trial}: {told}");
        let says = says.replace("LAST", &(ranks - 1).to_string());
        assert!(told.contains(&says), "{trial}: {says:?} is not in {told}");
    }
}

#[test]
fn messages_and_signals_arrive_in_order_and_are_counted() {
    holds("order");
}

#[test]
fn sending_does_not_wait() {
    holds("everybody-sends-first");
}

#[test]
fn a_barrier_waits_for_all() {
    holds("barrier");
}

#[test]
fn rank_0_gathers_in_order() {
    holds("gather");
}

#[test]
fn messages_that_nobody_takes_hold_nobody_up() {
    holds("not-taken");
}

#[test]
fn large_messages_travel_in_parts() {
    for ranks in [2, 3] {
        let output = mpirun(ranks, "parts");
        assert_eq!(text(&output.stdout), "held\n", "{}", text(&output.stderr));
    }
}

#[test]
fn a_rank_that_fails_ends_the_job() {
    fails("error", "error: rank LAST: rank LAST is no partner of a message");
}

#[test]
fn a_rank_that_panics_ends_the_job() {
    fails("panic", "error: rank LAST panicked");
    fails("panic", "no paper");
}

#[test]
fn a_rank_that_ends_early_is_missed() {
    fails("early-end", "rank 0 is gone");
}
