//! The report of one comparison: what `compare` prints and the log keeps (`docs/contract.md`).

use super::novelty_record::NoveltyRecord;
use crate::geometry::{Registration, RollPitchYaw};
use crate::inspect::Inspection;
use crate::novelty::Verdict;
use serde::{Deserialize, Serialize};

/// Pose of the revisit relative to the reference, as registration found it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseCorrection {
    /// t of `p_cur = R p_ref + t`, metres.
    pub translation: [f64; 3],
    /// Roll, pitch, yaw of R in degrees, `R = Rz(yaw) Ry(pitch) Rx(roll)`.
    pub rotation_deg: [f64; 3],
    /// Whether the registration converged.
    pub converged: bool,
    /// Directions that the surfaces leave open, by name.
    pub unobservable: Vec<String>,
}

/// Size of one view of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ViewCounts {
    /// Number of points.
    pub points: usize,
    /// Number of components of its mixture.
    pub components: usize,
}

/// The JSON of one comparison, without its name and timing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InspectionReport {
    /// `quiet`, `changed` or `not_observed`.
    pub verdict: String,
    /// Why this verdict, in one line.
    pub reason: String,
    /// d_GMM (paper Eq. 6), in the unit of the ground distance.
    pub d_gmm: f64,
    /// Part of d_GMM that no novelty explains.
    pub unexplained: f64,
    /// d_GMM times the visible surface, m^3.
    pub work_m3: f64,
    /// U_th in force (paper Eq. 7), in the unit of `d_gmm`.
    pub u_th: f64,
    /// Whether an alarm is due: the verdict is `changed`.
    pub alarm: bool,
    /// `standard` or `paper`.
    pub engine: String,
    /// Seed of the random number generators.
    pub seed: u64,
    /// Pose of the revisit relative to the reference.
    pub pose_correction: PoseCorrection,
    /// Size of the reference.
    pub reference: ViewCounts,
    /// Size of the revisit.
    pub current: ViewCounts,
    /// Listed novelties, in the frame of the revisit.
    pub novelties: Vec<NoveltyRecord>,
}

impl InspectionReport {
    /// The report of `inspection`; `points` are those of reference and revisit, `engine` is `standard` or `paper`.
    pub fn new(inspection: &Inspection, points: [usize; 2], engine: &str, seed: u64) -> Self {
        let detection = &inspection.detection;
        let [reference, current] = [0, 1].map(|side| ViewCounts {
            points: points[side],
            components: detection.components[side],
        });
        let novelties = detection
            .novelties
            .iter()
            .zip(&inspection.retrievals)
            .map(|(novelty, retrieval)| NoveltyRecord::new(novelty, retrieval.as_ref()))
            .collect();
        Self {
            verdict: detection.verdict.as_str().to_owned(),
            reason: detection.reason.clone(),
            d_gmm: detection.d_gmm,
            unexplained: detection.unexplained,
            work_m3: detection.work_m3,
            u_th: detection.u_th,
            alarm: detection.verdict == Verdict::Changed,
            engine: engine.to_owned(),
            seed,
            pose_correction: PoseCorrection::new(&detection.registration),
            reference,
            current,
            novelties,
        }
    }
}

impl PoseCorrection {
    fn new(registration: &Registration) -> Self {
        let pose = &registration.current_from_reference;
        let angles = RollPitchYaw::from_pose(pose);
        Self {
            translation: pose.translation.vector.into(),
            rotation_deg: [angles.roll_rad, angles.pitch_rad, angles.yaw_rad].map(f64::to_degrees),
            converged: registration.converged,
            unobservable: registration.unobservable.clone(),
        }
    }
}
