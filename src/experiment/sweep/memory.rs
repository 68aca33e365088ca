//! How much memory there is for cells, and whether one more fits.

use std::{fs, path::Path};

/// What a cell is taken for until one has been measured: a training on a lidar log of some thousand snapshots.
pub const ASSUMED_BYTES: u64 = 512 << 20;

/// Free memory in bytes: what the system says is available, or less where a control group (a container, a Slurm job) has less left;
/// none where the system doesn't say.
pub fn available_bytes() -> Option<u64> {
    let meminfo = fs::read_to_string("/proc/meminfo").ok()?;
    let available = field(&meminfo, "MemAvailable:")? * 1024;
    let group = group_left(Path::new("/sys/fs/cgroup"));
    Some(group.map_or(available, |left| left.min(available)))
}

/// What a control group has left: its limit less what it holds, files that can be dropped not counted.
fn group_left(root: &Path) -> Option<u64> {
    let own = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let own = own.lines().find_map(|line| line.strip_prefix("0::/"));
    let folder = own.map(|own| root.join(own)).filter(|own| own.is_dir());
    let folder = folder.unwrap_or_else(|| root.to_path_buf());
    let number = |name: &str| -> Option<u64> {
        fs::read_to_string(folder.join(name))
            .ok()?
            .trim()
            .parse()
            .ok()
    };
    let (limit, held) = (number("memory.max")?, number("memory.current")?);
    let statistics = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let droppable = field(&statistics, "inactive_file ").unwrap_or(0);
    Some(limit.saturating_sub(held.saturating_sub(droppable)))
}

/// The number behind the words that a line begins with.
fn field(text: &str, words: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(words))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Does one more cell fit? Each of those that run may still grow to what a cell takes.
///
/// ```
/// use ballmark::experiment::sweep::fits;
/// // 1000 are free; two cells of at most 400 run, which hold 300 and 100 so far: 400 are theirs yet.
/// assert!(fits(1000, 400, &[300, 100]));
/// assert!(!fits(799, 400, &[300, 100]));
/// // One always runs, or nothing would ever be done.
/// assert!(fits(0, 400, &[]));
/// ```
pub fn fits(available: u64, of_a_cell: u64, running: &[u64]) -> bool {
    let to_come = running.iter().map(|held| of_a_cell.saturating_sub(*held));
    let to_come: u64 = to_come.sum();
    running.is_empty() || available >= to_come.saturating_add(of_a_cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_group_has_what_its_limit_leaves() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        assert_eq!(group_left(folder.path()), None);
        write("memory.max", "max\n");
        write("memory.current", "300\n");
        assert_eq!(group_left(folder.path()), None);
        write("memory.max", "1000\n");
        assert_eq!(group_left(folder.path()), Some(700));
        write("memory.stat", "anon 5\ninactive_file 100\n");
        assert_eq!(group_left(folder.path()), Some(800));
        assert_eq!(
            field("MemTotal: 5 kB\nMemAvailable:   23 kB", "MemAvailable:"),
            Some(23)
        );
    }
}
