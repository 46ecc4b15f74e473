//! Errors of jobs: each in one whole line, wrong usage once.

use super::{Outcome, Place, mpirun};

/// Lines that name an error, all of which begin with it.
fn errors(outcome: &Outcome) -> Vec<&str> {
    let lines: Vec<&str> = outcome.stderr.lines().filter(|line| line.contains("error: ")).collect();
    assert!(lines.iter().all(|line| line.starts_with("error: ")), "lines are mixed: {}", outcome.stderr);
    lines
}

#[test]
fn wrong_usage_is_told_once() {
    let place = Place::new();
    for (arguments, says) in [
        ("render model.off -o a.png --nonsense", "unexpected argument '--nonsense'"),
        ("render model.off", "required"),
        ("nonsense", "nonsense"),
        ("render model.off -o a.png --size 0x9", "--size"),
        ("render model.off -o a.png --ranks 7", "mpirun started 3 processes"),
        ("render model.off -o ./model.off --format png", "an output must not be an input"),
    ] {
        let alone = place.run(arguments);
        let outcome = mpirun(&place, &[(3, arguments)]);
        assert_eq!(outcome.code, Some(2), "{arguments}: {}", outcome.stderr);
        let lines = errors(&outcome);
        assert!(matches!(lines[..], [line] if line.contains(says)), "{arguments}: {}", outcome.stderr);
        assert_eq!(outcome.stderr.matches("For more information, try '--help'.").count(), 1, "{arguments}");
        // What one process says is there as a whole.
        assert!(says.contains("mpirun") || outcome.stderr.contains(&alone.stderr), "{}", outcome.stderr);
    }
}

/// A process that was started with other arguments than the first one tells what is wrong with them.
#[test]
fn wrong_usage_of_later_processes_is_told_once() {
    let place = Place::new();
    let right = "render model.off -o a.png --quiet";
    let outcome = mpirun(&place, &[(1, right), (3, &format!("{right} --nonsense"))]);
    assert_ne!(outcome.code, Some(0), "{}", outcome.stderr);
    let lines = errors(&outcome);
    assert!(matches!(lines[..], [line] if line.contains("--nonsense")), "{}", outcome.stderr);
}

/// All processes fail at once. The first ones end the job, so some may not get to tell.
#[test]
fn lines_of_processes_that_fail_at_once_are_whole() {
    let place = Place::new();
    const PROCESSES: usize = 6;
    let missing = "missing-".repeat(20);
    for _ in 0..4 {
        let render = format!("render {missing}.off -o a.png --quiet");
        let outcome = mpirun(&place, &[(PROCESSES, &render)]);
        assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
        let mut ranks = Vec::new();
        assert!(outcome.stderr.contains("error: "), "{}", outcome.stderr);
        for line in errors(&outcome) {
            let (rank, error) = line["error: ".len()..].split_once(": ").expect("a rank and its error");
            assert!(
                error.starts_with(&format!("{missing}.off: ")) && error.ends_with("(os error 2)"),
                "{}",
                outcome.stderr
            );
            ranks.push(rank.strip_prefix("rank ").expect("a rank").parse::<usize>().expect("a number"));
        }
        ranks.sort_unstable();
        assert!(ranks.windows(2).all(|two| two[0] < two[1]) && ranks.iter().all(|&rank| rank < PROCESSES));
    }
}
