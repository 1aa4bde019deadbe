//! Configuration files: read or refused with their lines told, whatever stands in them.

use patrold::config::{KEYS, Layers, Settings, Source, template};
use std::path::PathBuf;

pub fn run(data: &[u8]) {
    let text = String::from_utf8_lossy(data).into_owned();
    let lines = text.split('\n').count();
    let mut layers = Layers::defaults();
    let source = Source {
        path: PathBuf::from("fuzzed.toml"),
        text,
    };
    for mistake in layers.add(&source) {
        assert!(mistake.line <= lines, "line {} of {lines}", mistake.line);
        assert!(!mistake.to_string().is_empty());
    }
    if let Err(mistakes) = Settings::build(&layers) {
        assert!(!mistakes.is_empty());
    }
}

pub fn seeds() -> Vec<Vec<u8>> {
    let mut all = vec![template().into_bytes()];
    all.extend(KEYS.iter().map(|key| {
        let (table, name) = key.name.split_once('.').unwrap_or(("", key.name));
        format!("[{table}]\n{name} = 1\n").into_bytes()
    }));
    all
}
