//! What the processes of a job on one machine leave each other: processors and memory.
#![cfg(target_os = "linux")]

use std::process::Stdio;

use super::{Outcome, Place, command, process_of};

/// Processes that are not bound share the processors; without `--threads` each has one thread at least.
#[test]
fn processes_that_are_not_bound_share_the_processors() {
    let place = Place::new();
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    for count in [1, 2, 3, processors + 1] {
        let render = "render builtin:teapot@5k -o a.png --size 200x150 --organisation sort-first --stats -";
        let mut job = command(&place, &[(count, render)]);
        // For mpirun and its processes.
        job.env("OMPI_MCA_hwloc_base_binding_policy", "none");
        let outcome = Outcome::from(job.output().expect("mpirun starts")).ok_silently();
        let stats: serde_json::Value = serde_json::from_str(outcome.text()).expect("statistics");
        let ranks = stats["parallel"]["ranks"].as_array().expect("ranks");
        let threads = ranks.iter().map(|rank| rank["frame"]["threads"].as_u64().expect("threads") as usize);
        let threads: Vec<usize> = threads.collect();
        assert_eq!(threads, vec![(processors / count).max(1); count], "of {processors} processors");
        assert!(threads.iter().sum::<usize>() <= processors.max(count), "{threads:?} of {processors}");
    }
}

/// How a job ended, and the memory that each of its processes took for itself.
struct Run {
    outcome: Outcome,
    own: Vec<u64>,
}

/// The most that a process had resident so far, less pages of files: those of programs and libraries, which processes share.
fn own(id: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let bytes = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key))?;
        Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
    };
    Some(bytes("VmHWM:")?.saturating_sub(bytes("RssFile:")?))
}

/// Runs a job, whose processes are looked at again and again until it ends.
fn watched(place: &Place, count: usize, arguments: &str) -> Run {
    let mut job = command(place, &[(count, arguments)]);
    let mut job = job.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("mpirun starts");
    let (mut ids, mut most) = (vec![None; count], vec![0; count]);
    while job.try_wait().expect("a state").is_none() {
        for rank in 0..count {
            ids[rank] = ids[rank].or_else(|| process_of(rank, job.id()));
            most[rank] = ids[rank].and_then(own).unwrap_or(0).max(most[rank]);
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    Run { outcome: job.wait_with_output().expect("the job ends").into(), own: most }
}

/// What a process may take beside its limit: stacks, the heap's own, and data of the program and its libraries.
const BESIDE: u64 = 4_000_000;

/// Each process stays within its limit, messages included, or the job ends with one line that names it. Not counted is what MPI takes
/// for itself, which is as much where nearly nothing is drawn.
#[test]
fn processes_stay_within_their_limit_or_name_it() {
    let place = Place::new();
    let arguments = |model: &str, size: &str, limit: u64| {
        format!(
            "render {model} -o {{}}.png --size {size} --turntable 8 --threads 1 --organisation sort-last --quiet \
             --memory-limit {limit}"
        )
    };
    let small = watched(&place, 2, &arguments("builtin:sphere@100", "16x16", 8_000_000));
    assert_eq!(small.outcome.code, Some(0), "{}", small.outcome.stderr);
    assert!(small.own.iter().all(|&bytes| bytes > 0), "{:?}", small.own);
    let (mut drawn, mut refused) = (0, 0);
    for limit in [2_000_000, 8_000_000, 16_000_000, 32_000_000, 48_000_000, 96_000_000] {
        let run = watched(&place, 2, &arguments("builtin:sphere@50k", "700x700", limit));
        let what = format!("{limit} bytes: {:?} of {:?}, {}", run.own, small.own, run.outcome.stderr);
        for (own, of_mpi) in run.own.iter().zip(&small.own) {
            assert!(*own <= limit + of_mpi + BESIDE, "{what}");
        }
        match run.outcome.code {
            Some(0) => drawn += 1,
            Some(1) => {
                refused += 1;
                let lines = run.outcome.stderr.lines().filter(|line| line.starts_with("error: "));
                let lines: Vec<&str> = lines.collect();
                let names = |line: &&str| {
                    line.contains("builtin:sphere@50k: ")
                        && line.contains(&format!("{limit} bytes (--memory-limit)"))
                };
                assert!(!lines.is_empty() && lines.iter().all(names), "{what}");
            }
            code => panic!("{code:?}: {what}"),
        }
    }
    assert!(drawn > 0 && refused > 0, "{drawn} drawn, {refused} refused");
}
