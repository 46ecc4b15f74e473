//! Jobs of `mpirun`. Ranks share the processors of the machine, however few it has.

use std::process::{Command, Output};

/// Seconds after which a job is assumed to hang.
const HANGS: &str = "600";

/// Runs a trial on some ranks; also works as root.
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
fn passes(trial: &str) {
    for ranks in [1, 2, 3, 4] {
        let output = mpirun(ranks, trial);
        let shown = format!("{trial}, {ranks} ranks: {}", text(&output.stderr));
        assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(0), "passed\n"), "{shown}");
    }
}

/// Checks that the job ends with code 1, which a hanging one does not, and that standard error contains the message.
#[track_caller]
fn fails(trial: &str, message: &str) {
    for ranks in [2, 4] {
        let output = mpirun(ranks, trial);
        let shown = text(&output.stderr);
        assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(1), ""), "{trial}: {shown}");
        let message = message.replace("LAST", &(ranks - 1).to_string());
        assert!(shown.contains(&message), "{trial}: {message:?} is not in {shown}");
    }
}

#[test]
fn messages_and_signals_arrive_in_order_and_are_counted() {
    passes("order");
}

#[test]
fn sending_does_not_wait() {
    passes("everybody-sends-first");
}

#[test]
fn a_barrier_waits_for_all() {
    passes("barrier");
}

#[test]
fn rank_0_gathers_in_order() {
    passes("gather");
}

#[test]
fn messages_are_received_from_any_rank() {
    passes("any");
}

#[test]
fn messages_that_are_not_received_block_no_rank() {
    passes("not-taken");
}

#[test]
fn large_messages_are_sent_in_parts() {
    for ranks in [2, 3] {
        let output = mpirun(ranks, "parts");
        assert_eq!(text(&output.stdout), "passed\n", "{}", text(&output.stderr));
    }
}

#[test]
fn a_rank_that_fails_ends_the_job() {
    fails("error", "error: rank LAST: rank LAST is not a valid peer");
}

#[test]
fn a_rank_that_panics_ends_the_job() {
    fails("panic", "error: rank LAST panicked");
    fails("panic", "no paper");
}

#[test]
fn a_rank_that_ends_early_is_gone() {
    fails("early-end", "rank 0 is gone");
}
