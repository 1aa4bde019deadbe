//! The one thread that writes to the store.

use super::constants::STORE_WRITE_LIMIT;
use crate::store::Ledger;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

struct Job {
    /// Skipped when the service is about to end.
    optional: bool,
    run: Box<dyn FnOnce(&mut Ledger) + Send>,
}

/// Handle of the thread. Jobs run in the order of submission.
#[derive(Debug)]
pub(super) struct StoreWriter {
    jobs: Sender<Job>,
    job_started: Arc<Mutex<Option<Instant>>>,
    skipping_optional: Arc<AtomicBool>,
    /// Disconnects when the thread ends.
    ended: Receiver<()>,
}

impl StoreWriter {
    pub(super) fn spawn(mut ledger: Ledger) -> std::io::Result<Self> {
        let (jobs, inbox) = mpsc::channel::<Job>();
        let (end, ended) = mpsc::channel();
        let job_started = Arc::new(Mutex::new(None));
        let skipping_optional = Arc::new(AtomicBool::new(false));
        let (started, skipping) = (Arc::clone(&job_started), Arc::clone(&skipping_optional));
        let set_started = move |at| *started.lock().unwrap_or_else(PoisonError::into_inner) = at;
        thread::Builder::new()
            .name("patrold-writer".to_owned())
            .spawn(move || {
                while let Ok(job) = inbox.recv() {
                    if job.optional && skipping.load(Ordering::Relaxed) {
                        continue;
                    }
                    set_started(Some(Instant::now()));
                    (job.run)(&mut ledger);
                    set_started(None);
                }
                // Whoever waits for the end finds the database closed.
                ledger.close();
                drop::<Sender<()>>(end);
            })?;
        Ok(Self {
            jobs,
            job_started,
            skipping_optional,
            ended,
        })
    }

    /// `job` and then `done` run on the writer's thread.
    pub(super) fn submit<T>(
        &self,
        job: impl FnOnce(&mut Ledger) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        self.send(false, job, done);
    }

    /// As [`submit`](Self::submit); skipped if [`skip_optional`](Self::skip_optional) is called before its turn.
    pub(super) fn submit_optional<T>(
        &self,
        job: impl FnOnce(&mut Ledger) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        // A job submitted after `skip_optional` belongs to the end itself.
        let optional = !self.skipping_optional.load(Ordering::Relaxed);
        self.send(optional, job, done);
    }

    fn send<T>(
        &self,
        optional: bool,
        job: impl FnOnce(&mut Ledger) -> T + Send + 'static,
        done: impl FnOnce(T) + Send + 'static,
    ) {
        let run = Box::new(move |ledger: &mut Ledger| done(job(ledger)));
        // The thread lives as long as this handle.
        let _ = self.jobs.send(Job { optional, run });
    }

    /// Whether a job hangs at `now`.
    pub(super) fn is_overdue(&self, now: Instant) -> bool {
        let started = *self
            .job_started
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        started.is_some_and(|at| now.saturating_duration_since(at) > STORE_WRITE_LIMIT)
    }

    /// Skips the optional jobs in the queue.
    pub(super) fn skip_optional(&self) {
        self.skipping_optional.store(true, Ordering::Relaxed);
    }

    /// Waits at most `limit` for the queued jobs; whether they are done. The process may end before: a transaction is on
    /// disk as a whole or not at all.
    pub(super) fn finish(self, limit: Duration) -> bool {
        drop(self.jobs);
        // Nothing is ever sent: the channel disconnects, also where the thread panicked.
        !matches!(
            self.ended.recv_timeout(limit),
            Err(RecvTimeoutError::Timeout)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{STORE_WRITE_LIMIT, StoreWriter};
    use crate::store::{Ledger, Store};
    use std::sync::mpsc;
    use std::time::{Duration, Instant};

    const TIMEOUT: Duration = Duration::from_secs(60);

    #[test]
    fn finish_skips_optional_jobs_and_gives_up_after_its_limit() {
        let dir = tempfile::tempdir().expect("temp dir");
        let store = Store::open(dir.path()).expect("store");
        let writer = StoreWriter::spawn(Ledger::new(store)).expect("a thread");
        let (release, released) = mpsc::channel::<()>();
        let (sender, done) = mpsc::channel();
        let report = |job: &'static str| {
            let sender = sender.clone();
            move |()| sender.send(job).expect("the receiver exists")
        };
        writer.submit(move |_| released.recv().expect("released"), report("long"));
        writer.submit_optional(|_| (), report("optional"));
        writer.submit(|_| (), report("verdict"));
        writer.skip_optional();
        writer.submit_optional(|_| (), report("last event"));
        assert!(
            !writer.finish(Duration::from_millis(1)),
            "the long job runs"
        );
        release.send(()).expect("the job waits");
        let jobs: Vec<_> = (0..3).map(|_| done.recv_timeout(TIMEOUT)).collect();
        assert_eq!(jobs, [Ok("long"), Ok("verdict"), Ok("last event")]);
    }

    #[test]
    fn a_job_that_hangs_is_noticed() {
        let dir = tempfile::tempdir().expect("temp dir");
        let store = Store::open(dir.path()).expect("store");
        let writer = StoreWriter::spawn(Ledger::new(store)).expect("a thread");
        let late = || Instant::now() + STORE_WRITE_LIMIT + TIMEOUT;
        assert!(!writer.is_overdue(late()), "no job");
        let before = Instant::now();
        let (begun, begins) = mpsc::channel();
        let (release, released) = mpsc::channel::<()>();
        let (sender, done) = mpsc::channel();
        writer.submit(
            move |_| {
                begun.send(()).expect("the receiver exists");
                released.recv().expect("released");
            },
            |()| (),
        );
        writer.submit(
            |_| (),
            move |()| sender.send(()).expect("the receiver exists"),
        );
        begins.recv_timeout(TIMEOUT).expect("begun");
        assert!(!writer.is_overdue(before + STORE_WRITE_LIMIT), "not yet");
        assert!(writer.is_overdue(late()));
        release.send(()).expect("the job waits");
        done.recv_timeout(TIMEOUT).expect("the next job");
        assert!(writer.finish(TIMEOUT));
    }

    #[test]
    fn finish_waits_for_queued_jobs() {
        let dir = tempfile::tempdir().expect("temp dir");
        let store = Store::open(dir.path()).expect("store");
        let writer = StoreWriter::spawn(Ledger::new(store)).expect("a thread");
        writer.submit_optional(|_| (), |()| ());
        assert!(writer.finish(TIMEOUT));
    }
}
