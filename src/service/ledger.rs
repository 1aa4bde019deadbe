//! The one thread that writes to the store.

use super::constants::WRITE_LIMIT;
use crate::store::Store;
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

type Job = Box<dyn FnOnce(&mut Store) + Send>;

/// Handle of the writer. Jobs are done in their order.
#[derive(Debug)]
pub struct Ledger {
    jobs: Sender<Job>,
    begun: Arc<Mutex<Option<Instant>>>,
    thread: JoinHandle<()>,
}

impl Ledger {
    /// Hands the store to a thread of its own.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn spawn(mut store: Store) -> std::io::Result<Self> {
        let (jobs, inbox) = mpsc::channel::<Job>();
        let begun = Arc::new(Mutex::new(None));
        let mark = Arc::clone(&begun);
        let set = move |at| *mark.lock().unwrap_or_else(PoisonError::into_inner) = at;
        let thread = thread::Builder::new()
            .name("patrold-ledger".to_owned())
            .spawn(move || {
                while let Ok(job) = inbox.recv() {
                    set(Some(Instant::now()));
                    job(&mut store);
                    set(None);
                }
            })?;
        Ok(Self {
            jobs,
            begun,
            thread,
        })
    }

    /// Lets the writer do `job`, then hand the outcome to `done` (on the writer's thread).
    pub fn ask<T>(
        &self,
        job: impl FnOnce(&mut Store) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        let whole: Job = Box::new(move |store| done(job(store)));
        // The thread lives as long as this handle.
        let _ = self.jobs.send(whole);
    }

    /// Whether a job takes longer than any honest one.
    pub fn is_overdue(&self) -> bool {
        let begun = *self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.is_some_and(|at| at.elapsed() > WRITE_LIMIT)
    }

    /// Waits until everything asked so far is done.
    pub fn finish(self) {
        drop(self.jobs);
        // A panic in there was told on standard error; there is no more to do.
        let _ = self.thread.join();
    }
}
