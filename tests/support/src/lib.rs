//! Where the tests of every crate find the workspace's files and the recorded data.

use std::path::{Path, PathBuf};

/// The root of the workspace.
pub fn workspace_root() -> PathBuf {
    // Two levels above `tests/support`. The test below holds it to the workspace's manifest.
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}

/// A file or folder of the recorded data, from `PATROLD_DATA` (default `../shared/data` beside the workspace).
/// `None`, with the reason printed, where it is absent.
///
/// # Panics
/// It is absent and `PATROLD_REQUIRE_DATA=1`.
pub fn data(path: &str) -> Option<PathBuf> {
    let root = std::env::var_os("PATROLD_DATA")
        .map_or_else(|| workspace_root().join("../shared/data"), PathBuf::from);
    let path = root.join(path);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var("PATROLD_REQUIRE_DATA").is_ok_and(|v| v == "1");
    assert!(
        !required,
        "{} is missing and PATROLD_REQUIRE_DATA=1",
        path.display()
    );
    eprintln!("skipped: no recorded data at {}", path.display());
    None
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_root_is_the_workspace() {
        let manifest = std::fs::read_to_string(super::workspace_root().join("Cargo.toml"));
        assert!(manifest.expect("a manifest").contains("[workspace]"));
    }
}
