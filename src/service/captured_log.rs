//! Log lines of a test.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};

/// A writer that keeps what is written.
#[derive(Clone, Default)]
pub(super) struct LogText(Arc<Mutex<Vec<u8>>>);

impl LogText {
    pub(super) fn text(&self) -> String {
        let bytes = self.0.lock().expect("one thread").clone();
        String::from_utf8(bytes).expect("text")
    }
}

impl Write for LogText {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().expect("one thread").write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// What `work` logs, with all fields.
pub(super) fn captured(work: impl FnOnce()) -> String {
    let log = LogText::default();
    let writer = log.clone();
    let subscriber = tracing_subscriber::fmt()
        .with_writer(move || writer.clone())
        .with_ansi(false)
        .finish();
    tracing::subscriber::with_default(subscriber, work);
    log.text()
}
