//! Commands on the input of `emulate`, and what it answers.

use crate::harness::program::command;
use crate::harness::schema;
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::Stdio;

#[test]
fn every_command_is_answered_and_one_that_failed_as_failed() {
    let dir = tempfile::tempdir().expect("temp dir");
    let scenes = patrold_test_support::workspace_root().join("config/scenes");
    let scene = scenes.join("office.toml");
    let door = scenes.join("office-door.toml");
    let mut emulator = command(
        dir.path(),
        &["emulate", "--scene", &scene.to_string_lossy()],
    )
    .stdin(Stdio::piped())
    .stdout(Stdio::piped())
    .stderr(Stdio::null())
    .spawn()
    .expect("starts");
    let mut lines = BufReader::new(emulator.stdout.take().expect("piped")).lines();
    let mut next = || -> Value {
        let line = lines.next().expect("a line").expect("text");
        serde_json::from_str(&line).expect("JSON")
    };
    schema::check("emulate-ready", &next());
    let mut input = emulator.stdin.take().expect("piped");
    let commands = [
        ("{\"at\": [1, 0, 0]}".to_owned(), None),
        (format!("{{\"scene\": {door:?}}}"), None),
        (
            "{\"scene\": \"nowhere.toml\"}".to_owned(),
            Some("nowhere.toml"),
        ),
        (
            "{\"fault\": \"laser.nothing\"}".to_owned(),
            Some("brown-out"),
        ),
        ("{\"fault\": \"laser.silence:for=1\"}".to_owned(), None),
        ("forward".to_owned(), Some("expected {\"at\"")),
    ];
    for (number, (command, failed)) in (1..).zip(commands) {
        writeln!(input, "{command}").expect("sent");
        let answer = next();
        schema::check("emulate-answer", &answer);
        assert_eq!(answer["command"], number, "{command}");
        match failed {
            None => assert!(answer["failed"].is_null(), "{answer}"),
            Some(why) => assert!(
                answer["failed"].as_str().is_some_and(|f| f.contains(why)),
                "{answer}"
            ),
        }
    }
    emulator.kill().expect("ends");
    emulator.wait().expect("ended");
}
