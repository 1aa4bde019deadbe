//! The only module that writes to standard output; warnings go to standard error. Control characters of names and notes never reach a terminal.

use super::failure::Failure;
use serde::Serialize;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, ErrorKind, Write as _};

/// Writes one line or several. A closed reader (`| head`) is no failure.
pub(super) fn line(text: impl AsRef<str>) -> Result<(), Failure> {
    write_line(&printable(text.as_ref()))
}

/// Writes one line of JSON.
pub(super) fn json(value: &impl Serialize) -> Result<(), Failure> {
    write_line(&json_text(value)?)
}

/// JSON in one line; control characters in its strings are escaped.
pub(super) fn json_text(value: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string(value).map_err(Failure::failed)?;
    Ok(printable(&text).into_owned())
}

/// Reports something that stops nothing, on standard error.
pub(super) fn warning(text: &str) {
    eprintln!("patrold: warning: {}", printable(text));
}

/// How far long work is, on standard error.
pub(super) fn progress_line(text: &str) {
    eprintln!("patrold: {}", printable(text));
}

/// A question to the person at the terminal, on standard error: standard output is the report.
pub(super) fn question(text: &str) {
    eprintln!("{}", printable(text));
}

fn write_line(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let written = writeln!(out, "{text}").and_then(|()| out.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// The text with control characters, and those that turn the direction of writing, as `\uXXXX`: what a JSON string has for them
/// too. Line breaks and tabs stay.
pub(super) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unprintable) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_unprintable(c) {
            // All of them are below U+10000. Writing to a string does not fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

fn is_unprintable(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && !matches!(c, '\n' | '\t')
}

#[cfg(test)]
mod tests {
    use super::{json_text, printable};
    use proptest::prelude::*;
    use serde_json::Value;

    #[test]
    fn no_escape_sequence_comes_through() {
        let shown = printable("a\u{1b}[2Jb\rc\u{9b}31m\u{202e}d\te\nf\u{7f}");
        assert_eq!(shown, "a\\u001b[2Jb\\u000dc\\u009b31m\\u202ed\te\nf\\u007f");
        assert!(matches!(
            printable("plain text, äöü"),
            std::borrow::Cow::Borrowed(_)
        ));
    }

    proptest! {
        #[test]
        fn json_keeps_every_text_and_shows_no_control_character(text in any::<String>()) {
            let shown = json_text(&text).expect("JSON");
            prop_assert!(!shown.contains(char::is_control));
            prop_assert_eq!(serde_json::from_str::<Value>(&shown).ok(), Some(Value::String(text)));
        }
    }
}
