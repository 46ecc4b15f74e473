//! Counts the memory of a program that a test runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Child;

use nix::errno::Errno;
use nix::sys::ptrace;
use nix::sys::wait::{Id, WaitPidFlag, WaitStatus, waitid, waitpid};
use nix::unistd::Pid;

/// Memory of a process in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// The most that was resident.
    peak: u64,
    /// Pages of the program and of its libraries at its end: all processes share them, and the system drops them when memory is
    /// short.
    program: u64,
}

impl Memory {
    /// The most that the process took for itself, at most less what it read of the program after that.
    pub fn own(&self) -> u64 {
        self.peak - self.program
    }
}

/// Waits until a program is about to end, and counts its memory; nothing if it has ended already.
///
/// What the system tells of an ended process is the larger of its peak and that of the process which started it, so it is stopped
/// before its memory is gone.
pub fn until_end(child: &Child) -> Option<Memory> {
    let pid = Pid::from_raw(i32::try_from(child.id()).expect("a number of a process"));
    match ptrace::seize(pid, ptrace::Options::PTRACE_O_TRACEEXIT) {
        Err(Errno::ESRCH) => return None,
        // One that has ended and was not waited for yet cannot be watched.
        Err(Errno::EPERM) if has_ended(pid) => return None,
        seized => seized.expect("the right to watch a program that this one has started"),
    }
    loop {
        let peek = WaitPidFlag::WEXITED | WaitPidFlag::WSTOPPED | WaitPidFlag::WNOWAIT;
        match waitid(Id::Pid(pid), peek).expect("a process that is watched") {
            // It was about to end when it began to be watched; whoever started it waits for it.
            WaitStatus::Exited(..) | WaitStatus::Signaled(..) => return None,
            _ => {}
        }
        match waitpid(pid, None).expect("a process that is watched") {
            WaitStatus::PtraceEvent(..) => {
                let memory = count(pid);
                ptrace::detach(pid, None).expect("a process that is watched");
                return Some(memory);
            }
            WaitStatus::Stopped(_, signal) => ptrace::cont(pid, signal).expect("a process that is watched"),
            _ => {}
        }
    }
}

fn has_ended(pid: Pid) -> bool {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).expect("a file of /proc");
    status.lines().any(|line| line.starts_with("State:\tZ") || line.starts_with("State:\tX"))
}

fn count(pid: Pid) -> Memory {
    let folder = PathBuf::from(format!("/proc/{pid}"));
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("a file of /proc");
    let status = read("status");
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).map(bytes).expect("a peak");
    let executable = fs::read_link(folder.join("exe")).expect("a file of /proc");
    let is_program = |path: &Path| {
        path == executable || path.file_name().is_some_and(|n| n.to_string_lossy().contains(".so"))
    };
    // Mapped models are not the program, and pages that were written to are not the file's.
    let (mut program, mut counts) = (0, false);
    for line in read("smaps").lines() {
        match line.split_once(':').filter(|(key, _)| key.chars().all(|c| c.is_alphanumeric() || c == '_')) {
            Some(("Rss", rest)) if counts => program += bytes(rest),
            Some(("Anonymous", rest)) if counts => program -= bytes(rest),
            Some(_) => {}
            // Addresses, permissions, offset, device and number before the file.
            None => counts = line.split_whitespace().nth(5).is_some_and(|path| is_program(Path::new(path))),
        }
    }
    Memory { peak, program }
}

/// The bytes of a number in kB.
fn bytes(text: &str) -> u64 {
    text.trim().strip_suffix("kB").and_then(|n| n.trim().parse::<u64>().ok()).expect("a number in kB") * 1024
}

#[test]
fn an_ended_process_is_not_counted() {
    let mut child = std::process::Command::new("true").spawn().expect("the program starts");
    let pid = Pid::from_raw(child.id() as i32);
    while !has_ended(pid) {
        std::thread::yield_now();
    }
    assert!(until_end(&child).is_none());
    child.wait().expect("the program ran");
}
