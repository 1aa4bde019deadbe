//! Which programs have a device node open, from `/proc`.

use std::fs;
use std::path::Path;

/// Programs that have the node behind `path` open, as `name (pid N)`. Only root sees those of other users.
pub fn holders(path: &str) -> Vec<String> {
    let Ok(node) = Path::new(path).canonicalize() else {
        return Vec::new();
    };
    let Ok(processes) = fs::read_dir("/proc") else {
        return Vec::new();
    };
    let mut found: Vec<(u32, String)> = processes
        .flatten()
        .filter_map(|entry| {
            let pid: u32 = entry.file_name().to_str()?.parse().ok()?;
            let folder = entry.path();
            let mut open = fs::read_dir(folder.join("fd")).ok()?.flatten();
            open.any(|fd| fs::read_link(fd.path()).is_ok_and(|target| target == node))
                .then(|| {
                    let name = fs::read_to_string(folder.join("comm")).unwrap_or_default();
                    (pid, format!("{} (pid {pid})", name.trim()))
                })
        })
        .collect();
    found.sort_unstable();
    found.into_iter().map(|(_, holder)| holder).collect()
}
