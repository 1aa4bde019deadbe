//! SIGINT and SIGTERM for commands that must not leave a laser on or a link behind.

use super::failure::Failure;
use crate::devices::Cancel;
use std::thread;
use tokio::runtime::{Builder, Runtime};
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Waiting for either signal; from its making on they no longer end the process by themselves.
pub struct Interruption {
    runtime: Runtime,
    interrupt: Signal,
    terminate: Signal,
}

impl Interruption {
    /// Takes over both signals.
    ///
    /// # Errors
    /// The system refuses.
    pub fn new() -> Result<Self, Failure> {
        let failed = |error| Failure::Failed(format!("signals: {error}"));
        let runtime = Builder::new_current_thread()
            .enable_io()
            .build()
            .map_err(failed)?;
        let entered = runtime.enter();
        let interrupt = signal(SignalKind::interrupt()).map_err(failed)?;
        let terminate = signal(SignalKind::terminate()).map_err(failed)?;
        drop(entered);
        Ok(Self {
            runtime,
            interrupt,
            terminate,
        })
    }

    /// Blocks until one of them comes.
    pub fn wait(mut self) {
        let (interrupt, terminate) = (&mut self.interrupt, &mut self.terminate);
        self.runtime.block_on(async {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        });
    }
}

/// A flag that either signal sets.
///
/// # Errors
/// As [`Interruption::new`].
pub fn cancel_on_signal() -> Result<Cancel, Failure> {
    let cancel = Cancel::new();
    let setter = cancel.clone();
    let interruption = Interruption::new()?;
    thread::spawn(move || {
        interruption.wait();
        setter.cancel();
    });
    Ok(cancel)
}
