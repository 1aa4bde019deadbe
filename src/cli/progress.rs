//! Progress of long work, where standard error is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget};
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
