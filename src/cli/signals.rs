//! SIGINT and SIGTERM, for commands that must not leave a laser on or a link behind.

use super::failure::Failure;
use crate::devices::Cancel;
use std::thread;
use tokio::runtime::{Builder, Runtime};
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Both signals. Once created, they no longer end the process by themselves.
pub(super) struct TerminationSignals {
    runtime: Runtime,
    interrupt: Signal,
    terminate: Signal,
}

impl TerminationSignals {
    pub(super) fn new() -> Result<Self, Failure> {
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

    /// Blocks until one of them arrives.
    pub(super) fn wait(mut self) {
        let (interrupt, terminate) = (&mut self.interrupt, &mut self.terminate);
        self.runtime.block_on(async {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        });
    }
}

/// Cancelled by either signal.
pub(super) fn cancel_on_signal() -> Result<Cancel, Failure> {
    let cancel = Cancel::new();
    let setter = cancel.clone();
    let signals = TerminationSignals::new()?;
    thread::spawn(move || {
        signals.wait();
        setter.cancel();
    });
    Ok(cancel)
}
