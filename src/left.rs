//! The memory that the system has left.

use std::fs;
use std::path::Path;

/// Bytes that programs can still have: of the machine, and of the group of processes that this one is in.
pub(crate) fn left() -> Option<u64> {
    let machine = fs::read_to_string("/proc/meminfo").ok()?;
    let machine = available(&machine)?;
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = groups.lines().find_map(|line| line.strip_prefix("0::/"));
    let group = group.and_then(|group| left_of_group(&Path::new("/sys/fs/cgroup").join(group)));
    Some(group.map_or(machine, |group| group.min(machine)))
}

/// What is available, by the text of `/proc/meminfo`.
fn available(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// What a group of processes may still take; `None` where it has no limit. Files that are kept in memory can be dropped.
fn left_of_group(folder: &Path) -> Option<u64> {
    let number = |name: &str| -> Option<u64> {
        let text = fs::read_to_string(folder.join(name)).ok()?;
        text.trim().parse().ok()
    };
    let files = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let files = files.lines().find_map(|l| l.strip_prefix("inactive_file "));
    let files: u64 = files.and_then(|n| n.trim().parse().ok()).unwrap_or(0);
    let used = number("memory.current")?.saturating_sub(files);
    Some(number("memory.max")?.saturating_sub(used))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_says_what_is_left() {
        let text = "MemTotal:       24682416 kB\nMemAvailable:   20458936 kB\n";
        assert_eq!(available(text), Some(20_458_936 * 1024));
        assert_eq!(available("MemFree: 1 kB"), None);
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            fs::write(folder.path().join(name), text).expect("written");
        };
        assert_eq!(left_of_group(folder.path()), None);
        write("memory.max", "max\n");
        write("memory.current", "700\n");
        assert_eq!(left_of_group(folder.path()), None);
        write("memory.max", "1000\n");
        write("memory.stat", "anon 5\ninactive_file 200\n");
        assert_eq!(left_of_group(folder.path()), Some(500));
    }
}
