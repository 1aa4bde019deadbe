//! What `demo` leaves behind. Whole rounds are tested in `service::visit_tests`.

use crate::harness::program::command;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

#[test]
fn an_interrupted_demo_leaves_nothing_behind() {
    let dir = tempfile::tempdir().expect("temp dir");
    let mut demo = command(dir.path(), &["demo"])
        .env("TMPDIR", dir.path())
        .stdout(Stdio::piped())
        .spawn()
        .expect("starts");
    let entries = || std::fs::read_dir(dir.path()).expect("listed").count();
    let out = demo.stdout.take().expect("piped");
    let mut lines = BufReader::new(out).lines();
    // It has begun to teach: database, socket and both devices are there.
    let begun = lines
        .by_ref()
        .map_while(Result::ok)
        .any(|line| line == "teaching");
    assert!(begun && entries() == 1);
    let signal = Command::new("kill").arg(demo.id().to_string()).status();
    assert!(signal.expect("kill runs").success());
    let status = demo.wait().expect("ends");
    assert_eq!(status.code(), Some(1));
    assert_eq!(entries(), 0);
}
