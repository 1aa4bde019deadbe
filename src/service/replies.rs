//! What the control socket answers, in the words of the contract. The command line reads the same types.

use crate::patrol::event::Refusal;
use patrold_engine::novelty::Verdict;
use patrold_engine::report::{NoveltyRecord, PoseCorrection};
use patrold_engine::sweep::Quality;
use serde::{Deserialize, Serialize};

/// The alarm that a visit raised or belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct AlarmReply {
    /// Its number in the log.
    pub id: i64,
    /// Whether this visit raised it; otherwise it stood already.
    pub raised: bool,
}

/// Milliseconds by step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StepTiming {
    /// Moving and scanning, on the devices' clock.
    pub sweep: f64,
    /// From raw data to the verdict, or to the reference's mixture.
    pub judge: f64,
    /// Until it was on disk.
    pub record: f64,
}

/// Outcome of a visit. When it is told, it is on disk, and so is its alarm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VisitReply {
    /// Where.
    pub waypoint: String,
    /// quiet, changed or not_observed.
    pub verdict: String,
    /// Why.
    pub reason: String,
    /// Sequence number of the visit.
    pub visit_id: i64,
    /// Its alarm.
    pub alarm: Option<AlarmReply>,
    /// Alarms that it cleared.
    pub cleared: Vec<i64>,
    /// d_GMM; null where none could be computed.
    pub d_gmm: Option<f64>,
    /// The threshold in force.
    pub u_th: f64,
    /// Where the robot stood.
    pub pose_correction: Option<PoseCorrection>,
    /// Version of the reference.
    pub reference_version: i64,
    /// Frame of the positions below: waypoint/reference version.
    pub frame: String,
    /// What came and went.
    pub novelties: Vec<NoveltyRecord>,
    /// How good the sweep was; null where there was none.
    pub sweep: Option<Quality>,
    /// How long it took.
    pub timing_ms: StepTiming,
}

impl VisitReply {
    /// The verdict; a word that is none counts as not observed.
    pub fn verdict(&self) -> Verdict {
        [Verdict::Quiet, Verdict::Changed]
            .into_iter()
            .find(|v| v.word() == self.verdict)
            .unwrap_or(Verdict::NotObserved)
    }
}

/// Outcome of taking a reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TeachReply {
    /// Where.
    pub waypoint: String,
    /// The new version.
    pub version: i64,
    /// Points of its sweep.
    pub points: usize,
    /// Components of its mixture.
    pub components: usize,
    /// How good the sweep was.
    pub sweep: Quality,
    /// How long it took.
    pub timing_ms: StepTiming,
}

/// A sweep handed out.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepReply {
    /// The points in the base's frame, as PLY.
    pub ply: Vec<u8>,
    /// About them.
    pub about: SweepAbout,
}

/// What goes with the points of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepAbout {
    /// Points.
    pub points: usize,
    /// Where the laser was half-way, metres in the base's frame.
    pub origin: [f64; 3],
    /// How good the sweep was.
    pub sweep: Quality,
    /// Why it would not be judged; null where it would.
    pub fault: Option<String>,
    /// How long it took.
    pub timing_ms: StepTiming,
}

/// Outcome of any request.
#[derive(Debug, Clone, PartialEq)]
pub enum Reply {
    /// Of a visit.
    Visit(Box<VisitReply>),
    /// Of taking a reference.
    Teach(Box<TeachReply>),
    /// Of a sweep.
    Sweep(Box<SweepReply>),
    /// None.
    Refused(Refusal),
}

/// The devices in the status.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DevicesStatus {
    /// opening, ready, lost or closed.
    pub state: String,
    /// Why they are lost.
    pub reason: Option<String>,
    /// Who answered when they were opened last.
    pub identity: serde_json::Value,
    /// How long the head took back to the begin of the last sweep, while that was judged, on the devices' clock; null where
    /// it did not come there.
    #[serde(default)]
    pub return_ms: Option<f64>,
}

/// The request in hand in the status.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurrentStatus {
    /// visit, teach or sweep.
    pub task: String,
    /// Where; empty for a bare sweep.
    pub waypoint: String,
}

/// What the service is doing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StatusReply {
    /// Version of the program.
    pub version: String,
    /// Name of the robot.
    pub robot: String,
    /// Process.
    pub pid: u32,
    /// When the service began.
    pub started_at: String,
    /// starting, idle, preparing, sweeping, judging, recording, devices lost or stopping.
    pub phase: String,
    /// The devices.
    pub devices: DevicesStatus,
    /// The request in hand.
    pub current: Option<CurrentStatus>,
    /// Requests that wait behind it.
    pub waiting: usize,
    /// Configuration files in force.
    pub config_files: Vec<String>,
    /// When they were put in force.
    pub config_loaded_at: String,
    /// The store's folder.
    pub store_dir: String,
}

/// An error, as one line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ErrorReply {
    /// The line.
    pub error: String,
}
