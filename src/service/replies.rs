//! Answers of the control socket as docs/contract.md defines them. The command line reads the same types.

use crate::patrol::event::RefusalReason;
use patrold_engine::novelty::Verdict;
use patrold_engine::report::{CoverageRecord, NoveltyRecord, PoseCorrection};
use patrold_engine::sweep::SweepQuality;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The alarm of a visit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct AlarmReply {
    /// Number of the alarm.
    pub id: i64,
    /// Whether this visit raised it; otherwise the visit belongs to an open one.
    pub raised: bool,
}

/// What a visit was to one alarm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlarmSeen {
    /// Number of the alarm.
    pub id: i64,
    /// raised, seen, moved, changed or back.
    pub relation: String,
    /// Index of its thing among the visit's novelties.
    pub novelty: usize,
    /// Distance of the thing from where it was, metres; null for a new one.
    pub distance_m: Option<f64>,
}

impl fmt::Display for AlarmSeen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (id, relation) = (self.id, &self.relation);
        match (relation.as_str(), self.distance_m) {
            ("moved", Some(by_m)) => write!(f, "alarm {id} moved by {by_m:.2} m"),
            ("seen", _) => write!(f, "alarm {id} seen again"),
            _ => write!(f, "alarm {id} {relation}"),
        }
    }
}

/// An alarm that was acknowledged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AckReply {
    /// Number of the alarm.
    pub alarm: i64,
    /// Its state now.
    pub state: String,
    /// By whom: the user that the socket saw, and the name that was given.
    pub by: String,
}

/// An alarm whose thing is normal now.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AcceptReply {
    /// Number of the alarm.
    pub alarm: i64,
    /// Where.
    pub waypoint: String,
    /// The version of the reference in which it is normal.
    pub version: i64,
    /// By whom: the user that the socket saw, and the name that was given.
    pub by: String,
}

/// Durations of the steps, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StepTiming {
    /// Moving and scanning, on the devices' clock.
    pub sweep: f64,
    /// From raw data to the verdict, or to the reference's mixture.
    pub judge: f64,
    /// Writing to the store.
    pub record: f64,
}

/// Outcome of a visit. Where it is `stored`, it is on disk before it is sent, and so is its alarm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VisitReply {
    /// Name of the waypoint.
    pub waypoint: String,
    /// quiet, changed or not_observed.
    pub verdict: String,
    /// Why this verdict, for a person to read; one line.
    pub reason: String,
    /// Sequence number of the visit; null where it is not stored.
    pub visit_id: Option<i64>,
    /// Whether its rows are on disk.
    pub stored: bool,
    /// Why they are not; the service holds the visit and writes it at the first chance, then it has its alarm.
    pub not_stored_because: Option<String>,
    /// Why the files of its sweep are not on disk; null where they are.
    pub evidence_missing_because: Option<String>,
    /// `None` for a visit without an alarm.
    pub alarm: Option<AlarmReply>,
    /// Every alarm that it raised or saw again.
    #[serde(default)]
    pub alarms: Vec<AlarmSeen>,
    /// Alarms that it cleared.
    pub cleared: Vec<i64>,
    /// d_GMM; null where none could be computed.
    pub d_gmm: Option<f64>,
    /// The threshold in force.
    pub u_th: f64,
    /// From the reference's to the visit's frame.
    pub pose_correction: Option<PoseCorrection>,
    /// How much of the reference it could judge.
    pub coverage: CoverageRecord,
    /// Version of the reference; 0 without one.
    pub reference_version: i64,
    /// Frame of the novelties: waypoint/reference version.
    pub frame: String,
    /// What appeared and disappeared.
    pub novelties: Vec<NoveltyRecord>,
    /// Null where there was no sweep.
    pub sweep: Option<SweepQuality>,
    /// Durations.
    pub timing_ms: StepTiming,
}

impl VisitReply {
    /// The verdict as an enum; an unknown value counts as not observed.
    pub fn verdict(&self) -> Verdict {
        [Verdict::Quiet, Verdict::Changed]
            .into_iter()
            .find(|v| v.as_str() == self.verdict)
            .unwrap_or(Verdict::NotObserved)
    }
}

/// Outcome of taking a reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TeachReply {
    /// Name of the waypoint.
    pub waypoint: String,
    /// The new version.
    pub version: i64,
    /// Points of its sweep.
    pub points: usize,
    /// Components of its mixture.
    pub components: usize,
    /// Quality of its sweep.
    pub sweep: SweepQuality,
    /// Durations.
    pub timing_ms: StepTiming,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct SweepReply {
    /// Points in the base's frame.
    pub(super) ply: Vec<u8>,
    pub(super) info: SweepInfo,
}

/// Sent with the points of a bare sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepInfo {
    /// Number of points.
    pub points: usize,
    /// Position of the laser half-way, metres in the base's frame.
    pub origin: [f64; 3],
    /// Quality of the sweep.
    pub sweep: SweepQuality,
    /// Why a visit would not judge it; null where it would.
    pub fault: Option<String>,
    /// Durations.
    pub timing_ms: StepTiming,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum ServiceReply {
    Visit(Box<VisitReply>),
    Teach(Box<TeachReply>),
    Sweep(Box<SweepReply>),
    Refused(RefusalReason),
}

/// The devices in the status.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DevicesStatus {
    /// opening, ready, lost or closed.
    pub state: String,
    /// Why they are lost.
    pub reason: Option<String>,
    /// The devices as they were last connected.
    pub identity: serde_json::Value,
    /// Duration of the head's return to the start of the last sweep, on the devices' clock; null where it did not get there.
    #[serde(default)]
    pub return_ms: Option<f64>,
}

/// The request being served, in the status.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurrentStatus {
    /// visit, teach or sweep.
    pub task: String,
    /// Empty for a bare sweep.
    pub waypoint: String,
    /// How far it is.
    #[serde(default)]
    pub progress: WorkProgress,
}

/// How far a request is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WorkProgress {
    /// 0 to 1.
    pub share: f64,
    /// Expected, of wall time; null where nobody knows.
    pub seconds_left: Option<f64>,
}

/// Answer to `GET /requests/ID`: a request whose client does not wait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RequestReply {
    /// Names it as long as this service runs, and no request of another run.
    pub id: String,
    /// visit or teach.
    pub task: String,
    /// Name of the waypoint.
    pub waypoint: String,
    /// waiting, preparing, sweeping, judging, recording; then done, refused or cancelled.
    pub state: String,
    /// Whether its client asked to end it.
    pub cancelled: bool,
    /// While it is under way.
    pub progress: Option<WorkProgress>,
    /// Outcome of a visit that is done.
    pub visit: Option<Box<VisitReply>>,
    /// Outcome of a teach that is done.
    pub teach: Option<Box<TeachReply>>,
    /// Why it was refused.
    pub refusal: Option<RefusalReply>,
}

/// Why a request was refused, as a client that waits would have had it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefusalReply {
    /// Of HTTP.
    pub status: u16,
    /// The body.
    #[serde(flatten)]
    pub reply: ErrorReply,
}

/// What became of reading the configuration's files.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ReloadReply {
    /// Whether they are in force.
    pub taken: bool,
    /// RFC 3339, UTC.
    pub at: String,
    /// The files in force.
    pub files: Vec<String>,
    /// Why they were not taken, one line each.
    pub mistakes: Vec<String>,
    /// Keys whose new values wait for a restart of the service.
    pub needs_restart: Vec<String>,
}

/// Answer to `GET /status`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StatusReply {
    /// Version of the program.
    pub version: String,
    /// Name of the robot.
    pub robot: String,
    /// Process id of the service.
    pub pid: u32,
    /// RFC 3339, UTC.
    pub started_at: String,
    /// starting, idle, preparing, sweeping, judging, recording, devices lost or stopping.
    pub phase: String,
    /// Laser and head.
    pub devices: DevicesStatus,
    /// The request being served.
    pub current: Option<CurrentStatus>,
    /// Requests queued behind it.
    pub waiting: usize,
    /// Configuration files in force.
    pub config_files: Vec<String>,
    /// RFC 3339, UTC.
    pub config_loaded_at: String,
    /// The last reading of the configuration's files, at the start or for a reload.
    #[serde(default)]
    pub config_read: ReloadReply,
    /// The store's folder.
    pub store_dir: String,
}

/// Reply to a request that was refused or failed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ErrorReply {
    /// What failed, for a person to read; one line.
    pub error: String,
    /// The known waypoint whose name the new one nearly has, where that is why.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearly: Option<String>,
}

impl From<&RefusalReason> for ErrorReply {
    fn from(refusal: &RefusalReason) -> Self {
        Self {
            error: refusal.to_string(),
            nearly: match refusal {
                RefusalReason::NearName { known, .. } => Some(known.clone()),
                _ => None,
            },
        }
    }
}
