//! An inspection in the form of the contract: what `compare` prints and what the log keeps.

use super::record::NoveltyRecord;
use crate::geometry::{Registration, RollPitchYaw};
use crate::inspect::Inspection;
use crate::novelty::Verdict;
use serde::{Deserialize, Serialize};

/// Where the robot stood, as a correction of where it should have stood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseCorrection {
    /// t of `p_cur = R p_ref + t`, metres.
    pub translation: [f64; 3],
    /// Roll, pitch, yaw of R in degrees, `R = Rz(yaw) Ry(pitch) Rx(roll)`.
    pub rotation_deg: [f64; 3],
    /// Whether the two views agree after it.
    pub converged: bool,
    /// Directions that the surfaces do not fix.
    pub unobservable: Vec<String>,
}

/// Size of one side of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SideReport {
    /// Points.
    pub points: usize,
    /// Components of its mixture.
    pub components: usize,
}

/// The contract's JSON of one comparison, but for its name and its timing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// quiet, changed or not_observed.
    pub verdict: String,
    /// Why.
    pub reason: String,
    /// d_GMM (Eq. 6).
    pub d_gmm: f64,
    /// The part of it that no novelty explains.
    pub unexplained: f64,
    /// d_GMM times the visible surface, m^2 m.
    pub work_m3: f64,
    /// U_th in force (Eq. 7).
    pub u_th: f64,
    /// Whether an alarm is due; the same as verdict changed.
    pub alarm: bool,
    /// standard or paper.
    pub engine: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Where the robot stood.
    pub pose_correction: PoseCorrection,
    /// The reference.
    pub reference: SideReport,
    /// The revisit.
    pub current: SideReport,
    /// What came and went, in the frame of the revisit.
    pub novelties: Vec<NoveltyRecord>,
}

impl Report {
    /// Puts an inspection into the contract's form.
    pub fn new(inspection: &Inspection, points: [usize; 2], engine: &str, seed: u64) -> Self {
        let detection = &inspection.detection;
        let [reference, current] = [0, 1].map(|side| SideReport {
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
            verdict: detection.verdict.word().to_owned(),
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
    /// The contract's form of a registration.
    pub fn new(registration: &Registration) -> Self {
        let pose = &registration.current_from_reference;
        let angles = RollPitchYaw::of(pose);
        Self {
            translation: pose.translation.vector.into(),
            rotation_deg: [angles.roll_rad, angles.pitch_rad, angles.yaw_rad].map(f64::to_degrees),
            converged: registration.converged,
            unobservable: registration.unobservable.clone(),
        }
    }
}
