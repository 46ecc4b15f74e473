//! Counts the instructions of a process.

use std::fs::read_to_string;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result};

use crate::process;

/// Instructions that a program executes in user space, in all its threads.
///
/// # Errors
/// valgrind is missing, the program fails, or callgrind writes no total.
pub fn count(program: &Path, arguments: &[&str], folder: &Path) -> Result<u64> {
    let file = folder.join("callgrind.out");
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--quiet"]).arg(format!("--callgrind-out-file={}", file.display()));
    process::output(command.arg(program).args(arguments).current_dir(folder))?;
    let text = read_to_string(&file).context("reading what callgrind wrote")?;
    total(&text).context("callgrind wrote no total")
}

/// The total of a callgrind file.
fn total(text: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix("totals: ")?.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_total_is_found() {
        assert_eq!(super::total("version: 1\nfn=(1) main\n1 5\n\ntotals: 95647740\n"), Some(95_647_740));
        assert_eq!(super::total("version: 1\n"), None);
    }
}
