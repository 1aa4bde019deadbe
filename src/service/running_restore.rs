//! A restore that the service has begun.

use super::message::RestoreReply;
use crate::patrol::event::PatrolRequest;
use crate::store::PreparedRestore;
use std::path::PathBuf;
use tokio::sync::oneshot;

#[derive(Debug)]
pub(super) struct RunningRestore {
    pub(super) from: PathBuf,
    pub(super) client: oneshot::Sender<RestoreReply>,
    pub(super) phase: RestorePhase,
    /// The request that waits until the database is replaced.
    pub(super) deferred: Option<PatrolRequest>,
}

#[derive(Debug)]
pub(super) enum RestorePhase {
    /// Copying, or checking at the end: visits go on.
    Beside,
    /// Until no visit is under way.
    Waiting(Box<PreparedRestore>),
    Replacing,
}
