//! The tree as the rules see it: every Rust file, with its comments and texts set aside.

use std::fs;
use std::path::PathBuf;

/// One Rust file.
pub struct Source {
    /// Path from the root, with forward slashes.
    pub path: String,
    /// Its text.
    pub text: String,
    /// Its text without comments, and with texts and characters emptied.
    pub code: String,
}

impl Source {
    /// A file of this text at this path.
    pub fn new(path: &str, text: &str) -> Self {
        Self {
            path: path.to_owned(),
            text: text.to_owned(),
            code: code_of(text),
        }
    }

    /// The room below `src/` that it belongs to.
    pub fn room(&self) -> Option<&str> {
        let inside = ["src/", "engine/src/", "sim/src/", "lab/src/"]
            .iter()
            .find_map(|source| self.path.strip_prefix(source))?;
        let (room, _) = inside.split_once('/')?;
        Some(room)
    }

    /// The crate below `drivers/` whose source it is.
    pub fn driver(&self) -> Option<&str> {
        let (driver, rest) = self.path.strip_prefix("drivers/")?.split_once('/')?;
        rest.starts_with("src/").then_some(driver)
    }
}

/// Every Rust file of the project.
pub fn tree() -> Vec<Source> {
    let mut files = Vec::new();
    for folder in [
        "src", "engine", "sim", "lab", "drivers", "tests", "benches", "fuzz",
    ] {
        walk(folder, &mut files);
    }
    files
}

/// The folders of `src/`.
pub fn rooms() -> Vec<String> {
    let entries = fs::read_dir(root().join("src")).expect("src is readable");
    entries
        .map(|entry| entry.expect("an entry"))
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

/// The text of a file of the project.
pub fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn root() -> PathBuf {
    patrold_test_support::workspace_root()
}

fn walk(folder: &str, files: &mut Vec<Source>) {
    let Ok(entries) = fs::read_dir(root().join(folder)) else {
        return;
    };
    for entry in entries {
        let entry = entry.expect("an entry");
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() && !path.ends_with("/target") {
            walk(&path, files);
        } else if path.ends_with(".rs") {
            files.push(Source::new(&path, &read(&path)));
        }
    }
}

/// `text` without comments, and with texts and characters emptied.
fn code_of(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |at| at + 2)
        } else if first == '"' {
            text_length(rest)
        } else if let Some(length) = raw_length(rest, code.chars().next_back()) {
            length
        } else {
            character_length(rest)
        };
        if skipped == 0 {
            code.push(first);
            rest = &rest[first.len_utf8()..];
        } else {
            code.push(' ');
            rest = &rest[skipped..];
        }
    }
    code
}

fn text_length(rest: &str) -> usize {
    let mut escaped = false;
    for (at, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    rest.len()
}

/// Length of a raw text at the start of `rest`, if there is one.
fn raw_length(rest: &str, before: Option<char>) -> Option<usize> {
    if before.is_some_and(|c| c.is_alphanumeric() && c != 'b' || c == '_') {
        return None;
    }
    let hashes = rest.strip_prefix('r')?;
    let count = hashes.len() - hashes.trim_start_matches('#').len();
    let open = 2 + count;
    if !hashes[count..].starts_with('"') {
        return None;
    }
    let close = format!("\"{}", "#".repeat(count));
    Some(
        rest[open..]
            .find(&close)
            .map_or(rest.len(), |at| open + at + close.len()),
    )
}

/// Length of a character literal at the start of `rest`; 0 if there is none (a lifetime, say).
fn character_length(rest: &str) -> usize {
    let Some(inner) = rest.strip_prefix('\'') else {
        return 0;
    };
    if inner.starts_with('\\') {
        return inner[2..].find('\'').map_or(0, |at| at + 4);
    }
    let mut chars = inner.chars();
    match (chars.next(), chars.next()) {
        (Some(c), Some('\'')) => 2 + c.len_utf8(),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::code_of;

    #[test]
    fn comments_and_texts_go_and_code_stays() {
        assert_eq!(code_of("a // b\nc").replace(' ', ""), "a\nc");
        assert_eq!(code_of("a /* b\n */ c").replace(' ', ""), "ac");
        assert_eq!(code_of("f(\"x \\\" // y\", z)").replace(' ', ""), "f(,z)");
        assert_eq!(
            code_of("f(r#\"x \" y\"#, '\"', '\\'', 'a', z)").replace(' ', ""),
            "f(,,,,z)"
        );
        assert_eq!(code_of("fn f<'a>(x: &'a str)"), "fn f<'a>(x: &'a str)");
    }
}
