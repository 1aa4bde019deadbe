//! Configuration files: read, or refused with errors that name a line of the file.

use patrold::config::{ConfigFile, ConfigLayers, KEYS, Settings, template};
use std::path::PathBuf;

pub(crate) fn run(data: &[u8]) {
    let text = String::from_utf8_lossy(data).into_owned();
    let lines = text.split('\n').count();
    let mut layers = ConfigLayers::defaults();
    let source = ConfigFile {
        path: PathBuf::from("fuzzed.toml"),
        text,
    };
    for error in layers.add(&source) {
        assert!(error.line <= lines, "line {} of {lines}", error.line);
        assert!(!error.to_string().is_empty());
    }
    if let Err(errors) = Settings::from_layers(&layers) {
        assert!(!errors.is_empty());
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let mut all = vec![template().into_bytes()];
    all.extend(KEYS.iter().map(|key| {
        let (table, name) = key.name.split_once('.').unwrap_or(("", key.name));
        format!("[{table}]\n{name} = 1\n").into_bytes()
    }));
    all
}
