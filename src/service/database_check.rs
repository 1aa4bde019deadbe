//! Looks for damage when the service starts, on a thread and a connection of its own: the service answers meanwhile.

use crate::store::Store;
use std::path::PathBuf;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// The start waits so long for the result: a database of 100 MB is checked in that time.
const START_WAIT: Duration = Duration::from_secs(1);

/// Checks the store in `dir` and calls `report` for each thing that is damaged. Returns when it is done, or after a second;
/// the rest goes on.
///
/// # Errors
/// The system refuses a thread.
pub(super) fn check_at_start(
    dir: PathBuf,
    report: impl Fn(String) + Send + 'static,
) -> std::io::Result<()> {
    let (end, ended) = mpsc::channel::<()>();
    thread::Builder::new()
        .name("patrold-check".to_owned())
        .spawn(move || {
            let damage = Store::open_for_reading(&dir).and_then(|store| store.find_damage());
            match damage {
                Ok(damage) => damage.into_iter().for_each(&report),
                Err(error) => report(error.to_string()),
            }
            drop(end);
        })?;
    // Nothing is ever sent: the channel disconnects at the end.
    let waited = ended.recv_timeout(START_WAIT);
    if waited == Err(RecvTimeoutError::Timeout) {
        tracing::debug!("the database is still being checked");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check_at_start;
    use crate::store::Store;
    use std::sync::mpsc;
    use std::time::Duration;

    #[test]
    fn damage_is_reported_and_a_sound_store_is_not() {
        let dir = tempfile::tempdir().expect("temp dir");
        Store::open(dir.path()).expect("store").close();
        let reports = || {
            let (sender, reports) = mpsc::channel();
            let send = move |text| sender.send(text).expect("the receiver exists");
            check_at_start(dir.path().to_owned(), send).expect("a thread");
            reports.recv_timeout(Duration::from_secs(60)).ok()
        };
        assert_eq!(reports(), None);
        let unknown = dir.path().join("none");
        let (sender, missing) = mpsc::channel();
        let send = move |text| sender.send(text).expect("the receiver exists");
        check_at_start(unknown, send).expect("a thread");
        let text = missing.recv_timeout(Duration::from_secs(60)).expect("none");
        assert!(text.contains("none"), "{text}");
        let database = dir.path().join("patrold.db");
        let mut bytes = std::fs::read(&database).expect("read");
        // Every page but the first.
        bytes[4096..].fill(0x5a);
        std::fs::write(&database, bytes).expect("damaged");
        let text = reports().expect("damage");
        assert!(text.contains("patrold store rebuild"), "{text}");
    }
}
