//! The one thread that writes to the store.

use super::constants::WRITE_LIMIT;
use crate::store::Store;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

struct Job {
    /// Left undone once the end is near.
    spare: bool,
    work: Box<dyn FnOnce(&mut Store) + Send>,
}

/// Handle of the writer. Jobs are done in their order.
#[derive(Debug)]
pub struct Ledger {
    jobs: Sender<Job>,
    begun: Arc<Mutex<Option<Instant>>>,
    hurried: Arc<AtomicBool>,
    /// Closed when the thread ends.
    ended: Receiver<()>,
}

impl Ledger {
    /// Hands the store to a thread of its own.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn spawn(mut store: Store) -> std::io::Result<Self> {
        let (jobs, inbox) = mpsc::channel::<Job>();
        let (end, ended) = mpsc::channel();
        let begun = Arc::new(Mutex::new(None));
        let hurried = Arc::new(AtomicBool::new(false));
        let (mark, hurry) = (Arc::clone(&begun), Arc::clone(&hurried));
        let set = move |at| *mark.lock().unwrap_or_else(PoisonError::into_inner) = at;
        thread::Builder::new()
            .name("patrold-ledger".to_owned())
            .spawn(move || {
                let _end: Sender<()> = end;
                while let Ok(job) = inbox.recv() {
                    if job.spare && hurry.load(Ordering::Relaxed) {
                        continue;
                    }
                    set(Some(Instant::now()));
                    (job.work)(&mut store);
                    set(None);
                }
            })?;
        Ok(Self {
            jobs,
            begun,
            hurried,
            ended,
        })
    }

    /// Lets the writer do `job`, then hand the outcome to `done` (on the writer's thread).
    pub fn ask<T>(
        &self,
        job: impl FnOnce(&mut Store) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        self.send(false, job, done);
    }

    /// As [`ask`](Self::ask), for what nobody waits for: skipped if [`hurry`](Self::hurry) comes before its turn.
    pub fn ask_spare<T>(
        &self,
        job: impl FnOnce(&mut Store) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        // What is asked after the hurry began belongs to the end itself.
        let spare = !self.hurried.load(Ordering::Relaxed);
        self.send(spare, job, done);
    }

    fn send<T>(
        &self,
        spare: bool,
        job: impl FnOnce(&mut Store) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        let work = Box::new(move |store: &mut Store| done(job(store)));
        // The thread lives as long as this handle.
        let _ = self.jobs.send(Job { spare, work });
    }

    /// Whether a job takes longer than any honest one.
    pub fn is_overdue(&self) -> bool {
        let begun = *self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.is_some_and(|at| at.elapsed() > WRITE_LIMIT)
    }

    /// The end is near: spare jobs that wait are skipped from now on.
    pub fn hurry(&self) {
        self.hurried.store(true, Ordering::Relaxed);
    }

    /// Waits until everything asked so far is done, at most `limit`; whether it is. What is not done then ends with
    /// the process: a transaction is on disk as a whole or not at all.
    pub fn finish(self, limit: Duration) -> bool {
        drop(self.jobs);
        // The channel carries nothing: it only ends. A panic in there was told on standard error.
        !matches!(
            self.ended.recv_timeout(limit),
            Err(RecvTimeoutError::Timeout)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::Ledger;
    use crate::store::Store;
    use std::sync::mpsc;
    use std::time::Duration;

    const PATIENCE: Duration = Duration::from_secs(60);

    #[test]
    fn the_end_waits_neither_for_spare_jobs_nor_for_ever() {
        let dir = tempfile::tempdir().expect("temp dir");
        let store = Store::open(dir.path()).expect("store");
        let ledger = Ledger::spawn(store).expect("a thread");
        let (free, freed) = mpsc::channel::<()>();
        let (tell, told) = mpsc::channel();
        let said = |word: &'static str| {
            let tell = tell.clone();
            move |()| tell.send(word).expect("somebody listens")
        };
        ledger.ask(move |_| freed.recv().expect("freed"), said("long"));
        ledger.ask_spare(|_| (), said("spare"));
        ledger.ask(|_| (), said("verdict"));
        ledger.hurry();
        ledger.ask_spare(|_| (), said("last words"));
        assert!(!ledger.finish(Duration::from_millis(1)), "still at work");
        free.send(()).expect("it waits");
        let words: Vec<_> = (0..3).map(|_| told.recv_timeout(PATIENCE)).collect();
        assert_eq!(words, [Ok("long"), Ok("verdict"), Ok("last words")]);
    }

    #[test]
    fn a_writer_with_little_to_do_ends_in_time() {
        let dir = tempfile::tempdir().expect("temp dir");
        let store = Store::open(dir.path()).expect("store");
        let ledger = Ledger::spawn(store).expect("a thread");
        ledger.ask_spare(|_| (), |()| ());
        assert!(ledger.finish(PATIENCE));
    }
}
