//! Jobs of `mpirun`. Ranks share the processors of the machine, however few it has.

use std::fs;
use std::path::Path;
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
fn ranks_are_divided_into_groups() {
    passes("groups");
}

#[test]
fn messages_are_waited_for_as_long_as_requested() {
    passes("within");
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

#[test]
fn ranks_that_do_not_end_are_named() {
    fails("silent-end", "rank LAST has been silent for 1 s");
}

#[test]
fn rank_0_may_end_late() {
    passes("long-end");
}

#[test]
fn a_silent_rank_is_noticed_and_waited_for() {
    for ranks in [2, 3] {
        let output = mpirun(ranks, "notice");
        assert_eq!(text(&output.stdout), "passed\n", "{ranks} ranks: {}", text(&output.stderr));
    }
}

/// 60 lines of each rank, at the same times.
#[test]
fn lines_of_ranks_do_not_mix() {
    const RANKS: usize = 8;
    let output = mpirun(RANKS, "lines");
    assert_eq!(text(&output.stdout), "passed\n", "{}", text(&output.stderr));
    let shown = text(&output.stderr);
    let mut found: Vec<&str> = shown.lines().collect();
    let mut expected: Vec<String> = (0..RANKS * 60)
        .map(|n| format!("error: rank {}: line {} of {} is whole", n % RANKS, n / RANKS, n % RANKS))
        .collect();
    found.sort_unstable();
    expected.sort_unstable();
    assert!(found == expected, "{shown}");
}

/// The example, as one process with some threads, or as a job.
fn wave(ranks: usize, is_job: bool, folder: &Path) -> Vec<Vec<u8>> {
    let program = std::env::current_exe().expect("this program's path");
    let program =
        program.parent().and_then(Path::parent).expect("the profile's folder").join("examples/wave");
    assert!(
        program.is_file(),
        "no example: cargo build --workspace --example wave --features tercio-mpi/mpi"
    );
    let mut command = Command::new("timeout");
    command.args(["--kill-after=10", HANGS]);
    if is_job {
        command.args(["mpirun", "--oversubscribe", "-n", &ranks.to_string()]);
    }
    command.arg(program).args("--steps 4 --every 2 --cells 24 --size 160x120".split(' '));
    if !is_job {
        command.args(["--ranks", &ranks.to_string()]);
    }
    command.arg("--pictures").arg(folder);
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    let output = command.output().expect("timeout and mpirun start");
    let shown = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{shown}{}", text(&output.stderr));
    assert!(shown.contains("elapsed seconds: ") && shown.contains("processor seconds: "), "{shown}");
    assert!(shown.contains(&format!("4 steps of 24 x 24 cells on {ranks} ranks, 2 pictures")), "{shown}");
    ["wave-00002.png", "wave-00004.png"].map(|name| fs::read(folder.join(name)).expect("a picture")).into()
}

#[test]
fn a_simulation_draws_itself_while_it_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = wave(1, false, &folder.path().join("alone"));
    assert!(alone[0] != alone[1], "nothing moves");
    for (ranks, is_job) in [(3, false), (30, false), (1, true), (2, true), (3, true)] {
        let pictures = wave(ranks, is_job, &folder.path().join(format!("{ranks}-{is_job}")));
        assert!(pictures == alone, "{ranks} ranks, processes: {is_job}");
    }
}
