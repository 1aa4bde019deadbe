//! What requests do: `dispatch` finds the method, `motion` moves the head, `speed` bounds it, `modes` does the rest.

mod dispatch;
mod modes;
mod motion;
mod speed;

use super::replies::{Answer, Refusal};

/// What follows a request that is not refused.
#[derive(Debug)]
pub(super) enum Outcome {
    /// `*`
    Done,
    /// `* answer`
    Say(Answer),
    /// Nothing: the reply comes later, or never.
    Silent,
}

/// What a request comes to.
pub(super) type Executed = Result<Outcome, Refusal>;
