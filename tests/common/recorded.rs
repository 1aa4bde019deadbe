//! Recorded data: found through `PATROLD_DATA`, skipped with a reason where absent.

use std::path::{Path, PathBuf};

/// The folder of recorded data that holds `set`; `None`, said aloud, where there is none.
///
/// Fails instead where `PATROLD_REQUIRE_DATA=1`.
pub fn data(set: &str) -> Option<PathBuf> {
    let root = std::env::var_os("PATROLD_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"),
        PathBuf::from,
    );
    if root.join(set).is_dir() {
        return Some(root);
    }
    let required = std::env::var_os("PATROLD_REQUIRE_DATA").is_some_and(|v| v == "1");
    assert!(
        !required,
        "no recorded data at {}",
        root.join(set).display()
    );
    eprintln!("skipped: no recorded data at {}", root.join(set).display());
    None
}
