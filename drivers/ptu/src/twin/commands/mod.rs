//! What requests do: [`motion`](self) of the head, its speeds, and the modes of the unit.

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
