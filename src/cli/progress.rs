//! Progress of long work, where standard error is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget};

/// A bar of so many steps; it hides itself where nobody watches.
pub fn bar(steps: usize, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
    bar.set_message(what);
    bar
}
