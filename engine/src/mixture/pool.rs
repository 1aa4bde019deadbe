//! The thread pool of one fit; its threads stay awake from the first iteration to the last.

use super::MixtureError;
use rayon::Yield;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs `work` in a new pool of `threads`, or on the caller's thread for 0 and 1.
///
/// # Errors
/// Threads that cannot be started.
pub(super) fn in_pool<T: Send>(
    threads: usize,
    work: impl FnOnce() -> T + Send,
) -> Result<T, MixtureError> {
    if threads <= 1 {
        return Ok(work());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| MixtureError::Threads {
        threads,
        reason: e.to_string(),
    })?;
    let finished = AtomicBool::new(false);
    Ok(pool.scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|_| help_until(&finished));
        }
        let _finish = FinishOnDrop(&finished);
        work()
    }))
}

/// Takes work until finished. An idle worker would fall asleep in every M step, and waking it takes as long as a part of the
/// E step.
fn help_until(finished: &AtomicBool) {
    while !finished.load(Ordering::Acquire) {
        if rayon::yield_now() != Some(Yield::Executed) {
            std::thread::yield_now();
        }
    }
}

/// Stops the helpers, also when the work panics.
struct FinishOnDrop<'a>(&'a AtomicBool);

impl Drop for FinishOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
