//! Progress of long work, where standard error is a terminal.

use super::failure::Failure;
use indicatif::{ProgressBar, ProgressDrawTarget};
use rayon::prelude::*;
use std::time::Duration;

/// A bar of so many steps; it hides itself where nobody watches.
pub fn bar(steps: usize, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
    bar.set_message(what);
    bar
}

/// A sign of life beside `what` for work of unknown length; it hides itself where nobody watches.
pub fn spinner(what: String) -> ProgressBar {
    let spinner = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    spinner.set_message(what);
    spinner.enable_steady_tick(Duration::from_millis(100));
    spinner
}

/// What `one` makes of every item, in their order, `threads` at a time (0: one for each core), with a bar.
///
/// # Errors
/// Threads that cannot be had; the first failure.
pub fn over<I: Sync, T: Send>(
    items: &[I],
    what: &'static str,
    threads: usize,
    one: impl Fn(&I) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(Failure::failed)?;
    let bar = bar(items.len(), what);
    let told = |item| {
        let made = one(item);
        bar.inc(1);
        made
    };
    // All first, then the first failure in their order, whichever thread met one first.
    let made: Vec<Result<T, Failure>> =
        pool.install(|| items.par_iter().with_max_len(1).map(told).collect());
    bar.finish_and_clear();
    made.into_iter().collect()
}
