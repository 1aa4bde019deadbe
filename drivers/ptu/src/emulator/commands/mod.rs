//! Execution of requests: `dispatch` selects the method; `motion`, `speed` and `modes` hold the methods.

mod dispatch;
mod modes;
mod motion;
mod speed;

use super::replies::{QueryAnswer, RequestRefusal};

/// The reply to a request that is not refused.
#[derive(Debug)]
pub(super) enum RequestOutcome {
    /// `*`
    Done,
    /// `* answer`
    Answer(QueryAnswer),
    /// The reply comes later, or never.
    NoReply,
}

pub(super) type RequestResult = Result<RequestOutcome, RequestRefusal>;
