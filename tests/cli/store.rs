//! `patrold store`, `patrold backup` and `patrold restore` on a store filled through the library.

use crate::harness::schema;
use crate::log::{ids, run, store_folder};
use std::fs;

#[test]
fn a_store_is_checked_lost_and_rebuilt() {
    let dir = store_folder();
    let check = run(dir.path(), &["store", "check", "--json"]);
    schema::check("store-check", &check.json());
    assert_eq!(check.code, 0, "{}", check.err);
    let alarms = run(dir.path(), &["alarms", "list", "--json"]);
    for name in ["patrold.db", "patrold.db-wal", "patrold.db-shm"] {
        let _ = fs::remove_file(dir.path().join("store").join(name));
    }
    let gone = run(dir.path(), &["store", "check"]);
    assert_eq!(gone.code, 1);
    let rebuilt = run(dir.path(), &["store", "rebuild", "--json"]);
    assert_eq!(rebuilt.code, 0, "{}", rebuilt.err);
    schema::check("store-rebuilt", &rebuilt.json());
    let again = run(dir.path(), &["alarms", "list", "--json"]);
    assert_eq!((ids(&again), again.out), (ids(&alarms), alarms.out));
    let text = run(dir.path(), &["store", "rebuild"]);
    assert!(text.out.contains("the old database is"), "{}", text.out);
}

#[test]
fn a_check_lists_what_is_missing_and_what_no_row_names() {
    let dir = store_folder();
    let blobs = dir.path().join("store/blobs");
    let stray = "a".repeat(64);
    fs::write(blobs.join(&stray), b"stray").expect("written");
    let check = run(dir.path(), &["store", "check"]);
    assert_eq!(check.code, 0, "a stray file is no damage");
    assert!(
        check.out.contains(&format!("{stray} (5 bytes)")),
        "{}",
        check.out
    );
    let entries = fs::read_dir(&blobs).expect("blobs");
    let named = entries
        .map(|entry| entry.expect("an entry").path())
        .find(|path| {
            path.file_name()
                .is_some_and(|name| name.len() == 64 && name != stray.as_str())
        });
    let named = named.expect("evidence");
    let mut bytes = fs::read(&named).expect("read");
    bytes[0] ^= 1;
    fs::write(&named, bytes).expect("damaged");
    let check = run(dir.path(), &["store", "check", "--json"]);
    assert_eq!(check.code, 1);
    let json = check.json();
    schema::check("store-check", &json);
    assert_eq!(json["missing"].as_array().map(Vec::len), Some(1), "{json}");
    let why = json["missing"][0]["why"].as_str().expect("why");
    assert!(why.contains("expected content with hash"), "{why}");
}

#[test]
fn a_backup_is_restored() {
    let dir = store_folder();
    let backup = run(dir.path(), &["backup", "copy", "--json"]);
    assert_eq!(backup.code, 0, "{}", backup.err);
    schema::check("backup", &backup.json());
    let alarms = run(dir.path(), &["alarms", "list", "--json"]);
    run(dir.path(), &["waypoints", "forget", "hall"]);
    let restored = run(dir.path(), &["restore", "copy", "--json"]);
    assert_eq!(restored.code, 0, "{}", restored.err);
    schema::check("backup", &restored.json());
    let again = run(dir.path(), &["alarms", "list", "--json"]);
    assert_eq!(again.out, alarms.out);
    let none = run(dir.path(), &["restore", "nowhere"]);
    assert_eq!((none.code, none.out.as_str()), (1, ""));
    assert!(
        none.err.contains("nowhere/patrold.db: no database here"),
        "{}",
        none.err
    );
}
