//! Progress of long work, shown where standard error is a terminal.

use super::failure::Failure;
use indicatif::{ProgressBar, ProgressDrawTarget};
use rayon::prelude::*;
use std::time::Duration;

pub(super) fn bar(steps: usize, message: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
    bar.set_message(message);
    bar
}

/// For work of unknown length.
pub(super) fn spinner(message: String) -> ProgressBar {
    let spinner = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    spinner.set_message(message);
    spinner.enable_steady_tick(Duration::from_millis(100));
    spinner
}

/// Applies `function` to every item on `threads` threads (0: one for each core), with a bar. The results are in the order
/// of the items.
///
/// # Errors
/// Threads that cannot be started; the first failure in the order of the items.
pub(super) fn map_parallel<I: Sync, T: Send>(
    items: &[I],
    message: &'static str,
    threads: usize,
    function: impl Fn(&I) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(Failure::failed)?;
    let bar = bar(items.len(), message);
    let counted = |item| {
        let result = function(item);
        bar.inc(1);
        result
    };
    // Collected before a failure is returned: which one comes first does not depend on the threads.
    let results: Vec<Result<T, Failure>> =
        pool.install(|| items.par_iter().with_max_len(1).map(counted).collect());
    bar.finish_and_clear();
    results.into_iter().collect()
}
