//! Where tests find recorded data.

use std::path::{Path, PathBuf};

/// A folder of the recorded data, from `PATROLD_DATA` (default `../shared/data` beside the project). `None`, with
/// the reason printed, where it is absent, unless `PATROLD_REQUIRE_DATA=1`.
pub fn data(folder: &str) -> Option<PathBuf> {
    let root = std::env::var_os("PATROLD_DATA").map_or_else(
        || patrold_test_support::workspace_root().join("../shared/data"),
        PathBuf::from,
    );
    let path = root.join(folder);
    if path.is_dir() {
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
