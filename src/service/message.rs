//! Messages to the service loop.

use super::acceptance::Acceptance;
use super::judgement::{SweepJudgement, VisitBasis};
use super::replies::{AcceptReply, AckReply, ReloadReply, RequestReply, ServiceReply};
use super::scanner_thread::ScannerEvent;
use crate::alarm::AlarmAnswer;
use crate::config::{ConfigError, LoadedConfig};
use crate::patrol::event::{PatrolTask, RefusalReason};
use crate::patrol::severity::Severity;
use crate::store::{BackupResult, Disk, PreparedRestore, StorageReport, StoreError, StoreStart};
use std::path::PathBuf;
use std::sync::Arc;
use tokio::sync::oneshot;

/// What the client of a teach decided.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct TeachOptions {
    /// Standing alarms whose things become normal.
    pub(super) accept: Vec<i64>,
    /// The name is new, however near to a known one.
    pub(super) new_name: bool,
}

/// What a client says about an alarm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct AckRequest {
    pub(super) id: i64,
    /// With the user that the socket saw.
    pub(super) by: String,
    pub(super) note: Option<String>,
    pub(super) answer: Option<AlarmAnswer>,
}

/// Who makes the thing of an alarm normal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct AcceptRequest {
    pub(super) id: i64,
    /// With the user that the socket saw.
    pub(super) by: String,
}

/// The steps of a restore while the service runs.
#[derive(Debug)]
pub(super) enum RestoreStep {
    /// Nothing is deleted any more from the store in this folder.
    Quiet(PathBuf, Arc<dyn Disk>),
    /// The files of the backup are there; the database waits beside the old one.
    Prepared(Result<PreparedRestore, StoreError>),
    /// The database is in its place.
    InPlace(Result<(PreparedRestore, StoreStart), StoreError>),
    /// Checked.
    Checked(Result<BackupResult, StoreError>),
}

/// Who waits for an accept.
pub(super) type AcceptClient = oneshot::Sender<Result<AcceptReply, StoreError>>;

/// The outcome for the client.
pub(super) type RestoreReply = Result<BackupResult, String>;

/// A request from the control socket.
#[derive(Debug)]
pub(super) struct ClientRequest {
    pub(super) task: PatrolTask,
    /// Empty for a bare sweep.
    pub(super) waypoint: String,
    pub(super) teach: TeachOptions,
    pub(super) reply_to: ReplyTo,
}

/// How the outcome of a request gets to its client.
#[derive(Debug)]
pub(super) enum ReplyTo {
    /// The client waits for it; where it hangs up, it is gone.
    Client(oneshot::Sender<ServiceReply>),
    /// The client asks for it later, by what it gets now.
    Later(oneshot::Sender<RequestReply>),
}

/// What became of the wish to end a request.
#[derive(Debug)]
pub(super) enum CancelResult {
    Cancelled(RequestReply),
    /// Its sweep is taken; the state in which it is.
    TooLate(String),
    Unknown,
}

/// Numbers are request ids.
#[derive(Debug)]
pub(super) enum ServiceMessage {
    Scanner(ScannerEvent),
    Request(ClientRequest),
    /// A client asks for the state of a request by its id.
    RequestState(String, oneshot::Sender<Option<RequestReply>>),
    /// A client ends a request.
    CancelRequest(String, oneshot::Sender<CancelResult>),
    /// The waypoint's reference and incidents were looked up; a new waypoint has none.
    Prepared(u64, Result<Option<Box<VisitBasis>>, RefusalReason>),
    Judged(u64, Box<SweepJudgement>),
    /// The outcome is on disk.
    Recorded(u64, Result<ServiceReply, RefusalReason>),
    /// A client asks for a reload.
    ReloadRequested(oneshot::Sender<ReloadReply>),
    /// The configuration files were read for a reload; the client that asked for it, if one did.
    ConfigRead(
        Result<Box<LoadedConfig>, Vec<ConfigError>>,
        Option<oneshot::Sender<ReloadReply>>,
    ),
    /// What the upkeep of the store found.
    Storage(Box<StorageReport>),
    /// A client acknowledges an alarm.
    Acknowledge(AckRequest, oneshot::Sender<Result<AckReply, StoreError>>),
    /// A client accepts an alarm.
    Accept(AcceptRequest, AcceptClient),
    /// Its new reference is made, or cannot be.
    AcceptPrepared(
        Box<Result<Acceptance, StoreError>>,
        AcceptRequest,
        AcceptClient,
    ),
    /// A client asks for a restore from the folder of a backup.
    Restore(PathBuf, oneshot::Sender<RestoreReply>),
    /// The next step of a restore is done, or cannot be.
    RestoreStep(Box<RestoreStep>),
    /// A health incident of this subject could not be written: it is noted again at the next occasion.
    HealthUnwritten(&'static str),
    /// For the event log: severity, device, text.
    Note(Severity, String, String),
}

/// Command to the service as a whole, from a signal or the embedding program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ServiceCommand {
    /// Reload the configuration.
    Reload,
    /// End the service.
    Stop,
}
