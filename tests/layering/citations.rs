//! Citations: what comments and documents point at must be in the repository.

use std::sync::LazyLock;

use regex::Regex;

use super::source::{FILES, read};

static FILE: LazyLock<Regex> = LazyLock::new(|| regex(r"[\w./-]*[\w-]\.(md|rs)\b"));
static NUMBER: LazyLock<Regex> = LazyLock::new(|| regex(r"\d+(\.\d+)*\b|[IVX]+(\.[A-Z])?\b"));
/// The word before, and the numbers.
static SECTION: LazyLock<Regex> = LazyLock::new(|| {
    let more = r"(?:,?\s+(?:and|or|to)\s+|,\s+|-)";
    let number = NUMBER.as_str();
    let numbers = format!(r"(?:{number})(?:{more}(?:{number}))*");
    regex(&format!(
        r"(?:([^\s(\[;]+)\s+)?\b[Ss]ections?\s+({numbers})"
    ))
});

/// What `text` of the file at `path` cites that is not there, as `path:line: what`.
pub(crate) fn missing(path: &str, text: &str) -> Vec<String> {
    let is_doc = path.ends_with(".md");
    let text = if is_doc { text.into() } else { comments(text) };
    let at = |end: usize| format!("{path}:{}", text[..end].matches('\n').count() + 1);
    let mut found = Vec::new();
    for file in FILE.find_iter(&text).filter(|file| !is_file(file.as_str())) {
        found.push(format!("{}: no file {}", at(file.start()), file.as_str()));
    }
    for cited in SECTION.captures_iter(&text) {
        let name = cited.get(1).map_or("", |name| name.as_str());
        let name = name.trim_matches(['`', '*', ',']).trim_end_matches("'s");
        let has = |n: &str| has_section(name, n) || is_doc && has_heading(&text, n);
        let mut numbers = NUMBER.find_iter(&cited[2]);
        if !numbers.all(|number| has(number.as_str())) {
            let (at, what) = (at(cited.get_match().end()), cited[0].replace('\n', " "));
            found.push(format!("{at}: no document has {what}"));
        }
    }
    if path.starts_with("docs/protocols/") {
        let tags = unlisted_tags(&text);
        found.extend(tags.iter().map(|tag| format!("{path}: no source [{tag}]")));
    }
    found
}

/// Whether a file's path is or ends with `name`.
fn is_file(name: &str) -> bool {
    let name = name.trim_start_matches(['.', '/']);
    let mut before = FILES.iter().filter_map(|path| path.strip_suffix(name));
    before.any(|before| before.is_empty() || before.ends_with('/'))
}

/// Whether a section `number` is in what `name` calls: a text that the README so names, or a document of `docs/`.
fn has_section(name: &str, number: &str) -> bool {
    if !name.is_empty() && read("README.md").contains(&format!("{name}\"")) {
        return true;
    }
    let stem = name.trim_end_matches(".md").rsplit('/').next();
    let end = format!("/{}.md", stem.unwrap_or(name));
    let mut docs = FILES.iter().filter(|path| path.starts_with("docs/"));
    let found = docs.find(|path| path.ends_with(&end));
    found.is_some_and(|path| has_heading(&read(path), number))
}

fn has_heading(document: &str, number: &str) -> bool {
    let titles = document.lines().filter(|line| line.starts_with("##"));
    let mut numbers = titles.filter_map(|title| title.split(' ').nth(1));
    numbers.any(|first| first.trim_end_matches('.') == number)
}

/// Source tags such as `[S p5, L1]` that the document's own table of sources lacks.
fn unlisted_tags(text: &str) -> Vec<&str> {
    let brackets = text.split('[').skip(1);
    let insides = brackets.filter_map(|rest| rest.split(']').next());
    let parts = insides.flat_map(|inside| inside.split([',', ';']));
    let words = parts.filter_map(|part| part.trim().split([' ', ':']).next());
    let is_other = |c: char| !c.is_ascii_uppercase() && !c.is_ascii_digit();
    let is_tag = |word: &&str| word.starts_with(char::is_uppercase) && !word.contains(is_other);
    let listed = |tag: &&str| text.contains(&format!("\n| [{tag}"));
    words.filter(is_tag).filter(|tag| !listed(tag)).collect()
}

/// The comments of Rust code on their lines; code becomes `;`.
fn comments(code: &str) -> String {
    let lines = code
        .lines()
        .map(|line| match line.trim_start().strip_prefix("//") {
            Some(comment) => comment.trim_start_matches(['/', '!']),
            None => line.split_once(" // ").map_or(";", |(_, comment)| comment),
        });
    lines.collect::<Vec<_>>().join("\n")
}

fn regex(pattern: &str) -> Regex {
    Regex::new(pattern).expect("a pattern")
}
