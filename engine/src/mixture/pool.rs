//! The threads of one fit: a pool of its own that stays awake from the first iteration to the last.

use super::MixtureError;
use rayon::Yield;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs `work` where `threads` say: in a pool of so many, or on the caller's thread for 0 and 1.
///
/// # Errors
/// Threads that cannot be had.
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
    let over = AtomicBool::new(false);
    Ok(pool.scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|_| help_until(&over));
        }
        let _end = EndOnDrop(&over);
        work()
    }))
}

/// Takes work as it comes. An idle worker of the pool would fall asleep in every M step, and waking it takes
/// as long as a part of the E step.
fn help_until(over: &AtomicBool) {
    while !over.load(Ordering::Acquire) {
        if rayon::yield_now() != Some(Yield::Executed) {
            std::thread::yield_now();
        }
    }
}

/// Lets the helpers go, also when the work panics.
struct EndOnDrop<'a>(&'a AtomicBool);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
