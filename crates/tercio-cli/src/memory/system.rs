//! Memory figures of the system: used, free, and allowed.

use std::fs;
use std::path::Path;

use super::{Limit, Source};
use crate::mpi;

/// The peak resident size so far in bytes; `None` where the system does not report it.
pub fn peak_bytes() -> Option<u64> {
    // On other systems the file does not exist.
    line(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Bytes that this process can still take: the minimum of what the system has available, its control groups allow (both divided
/// by the processes of an MPI job on the machine) and its own limits leave; `None` where the system does not report it.
pub fn limit() -> Option<Limit> {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| line(&text, "MemAvailable:"));
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let groups = left_in_groups(Path::new("/sys/fs/cgroup"), &groups);
    let limits = [(machine, Source::Machine), (groups, Source::ControlGroup)];
    let processes = mpi::local_processes() as u64;
    let limits = limits.into_iter().filter_map(|(bytes, source)| match processes {
        1 => Some((bytes?, source)),
        _ => Some((bytes? / processes, Source::Share)),
    });
    limits.chain(own_limits()).min()
}

/// Bytes that the limits of this process leave (`ulimit -v`, `ulimit -d`); `None` where there are none.
#[cfg(target_os = "linux")]
pub fn own_limits() -> Option<Limit> {
    use rustix::process::{Resource, getrlimit};
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let left = |resource, key, source| {
        let limit = getrlimit(resource).current?;
        Some((limit.saturating_sub(line(&status, key).unwrap_or(0)), source))
    };
    let space = left(Resource::As, "VmSize:", Source::AddressSpace);
    space.into_iter().chain(left(Resource::Data, "VmData:", Source::Data)).min()
}

#[cfg(not(target_os = "linux"))]
pub fn own_limits() -> Option<Limit> {
    None
}

/// What the control groups of a process, as named in `/proc/self/cgroup`, leave at least. A group is limited by all its
/// ancestors, too. Memory that the system can reclaim, pages of files, does not count as used.
fn left_in_groups(root: &Path, groups: &str) -> Option<u64> {
    let ways = groups.lines().filter_map(|line| {
        let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
        // Version 2 has one hierarchy for all controllers, version 1 one for each.
        let (tree, kind) = match controllers {
            "" => (root.to_path_buf(), &V2),
            c if c.split(',').any(|c| c == "memory") => (root.join("memory"), &V1),
            _ => return None,
        };
        Some((tree, path.trim_start_matches('/').to_owned(), kind))
    });
    ways.flat_map(|(tree, path, kind)| {
        let folders: Vec<_> = Path::new(&path).ancestors().map(|p| tree.join(p)).collect();
        folders.into_iter().filter_map(|folder| kind.left(&folder))
    })
    .min()
}

/// File names of a version of control groups.
struct Files {
    limits: &'static [&'static str],
    usage: &'static str,
    /// Of `memory.stat`: pages of files.
    cached: [&'static str; 2],
}

const V1: Files = Files {
    limits: &["memory.limit_in_bytes"],
    usage: "memory.usage_in_bytes",
    cached: ["total_inactive_file", "total_active_file"],
};

const V2: Files = Files {
    limits: &["memory.max", "memory.high"],
    usage: "memory.current",
    cached: ["inactive_file", "active_file"],
};

impl Files {
    fn left(&self, folder: &Path) -> Option<u64> {
        let number = |file: &str| fs::read_to_string(folder.join(file)).ok()?.trim().parse::<u64>().ok();
        // No limit is "max", or a number larger than any memory.
        let limit = self.limits.iter().filter_map(|file| number(file)).min().filter(|&l| l < 1 << 60)?;
        let stat = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let cached = stat.lines().filter_map(|line| {
            let (key, bytes) = line.split_once(' ')?;
            self.cached.contains(&key).then(|| bytes.trim().parse::<u64>().unwrap_or(0))
        });
        let used = number(self.usage).unwrap_or(0).saturating_sub(cached.sum());
        Some(limit.saturating_sub(used))
    }
}

/// The bytes of a line `KEY 123 kB`.
fn line(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_found() {
        assert_eq!(line("Name:\ttercio\nVmHWM:\t    2048 kB\nVmRSS:\t 1 kB\n", "VmHWM:"), Some(2 << 20));
        assert_eq!(line("Name:\ttercio\n", "VmHWM:"), None);
    }

    #[test]
    fn the_tightest_of_nested_groups_counts() {
        let root = tempfile::tempdir().unwrap();
        let write = |file: &str, text: &str| {
            let path = root.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        let v2 = "0::/job/step\n";
        assert_eq!(left_in_groups(root.path(), v2), None);
        write("job/step/memory.max", "max\n");
        write("job/step/memory.current", "50\n");
        assert_eq!(left_in_groups(root.path(), v2), None);
        // The limit is that of the parent group; pages of files can be reclaimed.
        write("job/memory.max", "1000\n");
        write("job/memory.current", "600\n");
        write("job/memory.stat", "anon 100\ninactive_file 200\nactive_file 150\nshmem 7\n");
        assert_eq!(left_in_groups(root.path(), v2), Some(750));
        write("job/step/memory.high", "300\n");
        assert_eq!(left_in_groups(root.path(), v2), Some(250));

        let v1 = "9:name=systemd:/\n4:cpu,memory:/a\n0::/\n";
        write("memory/memory.limit_in_bytes", "9223372036854771712\n");
        assert_eq!(left_in_groups(root.path(), v1), None);
        write("memory/a/memory.limit_in_bytes", "5000\n");
        write("memory/a/memory.usage_in_bytes", "4500\n");
        write("memory/a/memory.stat", "inactive_file 1\ntotal_inactive_file 500\n");
        assert_eq!(left_in_groups(root.path(), v1), Some(1000));
    }
}
