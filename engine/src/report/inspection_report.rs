//! The report of one comparison: what `compare` prints and the log keeps (`docs/contract.md`).

use super::novelty_record::NoveltyRecord;
use super::nullable;
use crate::geometry::{Registration, RollPitchYaw};
use crate::inspect::Inspection;
use crate::novelty::{Coverage, Detection, Verdict};
use serde::{Deserialize, Serialize};
use std::fmt;

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

/// How much of the reference a visit could judge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CoverageRecord {
    /// Share of the reference's visible surface, 0 to 1.
    #[serde(deserialize_with = "nullable::number")]
    pub surface: f64,
    /// Share of the solid angle in which the reference saw something, 0 to 1.
    #[serde(deserialize_with = "nullable::number")]
    pub solid_angle: f64,
    /// What is missing and why, one line; empty where hardly anything is.
    pub missing: String,
}

impl CoverageRecord {
    /// That of a visit which judged nothing, and why.
    #[must_use]
    pub fn none(why: &str) -> Self {
        Self {
            surface: 0.0,
            solid_angle: 0.0,
            missing: format!("everything: {why}"),
        }
    }
}

impl From<&Coverage> for CoverageRecord {
    fn from(coverage: &Coverage) -> Self {
        Self {
            surface: coverage.surface,
            solid_angle: coverage.solid_angle,
            missing: coverage.missing.clone(),
        }
    }
}

impl fmt::Display for CoverageRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| 100.0 * share;
        let (surface, solid_angle) = (percent(self.surface), percent(self.solid_angle));
        write!(
            f,
            "judged {surface:.0} % of the surface, {solid_angle:.0} % of the solid angle"
        )?;
        if self.missing.is_empty() {
            return Ok(());
        }
        write!(f, "; {}", self.missing)
    }
}

/// Size of one view of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ViewCounts {
    /// Number of points.
    pub points: usize,
    /// Number of components of its mixture.
    pub components: usize,
}

/// One Gaussian that Algorithm 1 took.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RemovalRecord {
    /// `theta` (something appeared) or `gamma` (something disappeared).
    pub from: String,
    /// Its position in that mixture, as `--mixtures-out` writes it.
    pub component: usize,
    /// d_GMM without it.
    #[serde(deserialize_with = "nullable::number")]
    pub d_gmm: f64,
    /// Whether d_GMM was at least U_th until it was taken.
    pub needed_for_alarm: bool,
}

fn removed(detection: &Detection) -> Vec<RemovalRecord> {
    let present: [Vec<usize>; 2] = [0, 1].map(|side| detection.compared.present(side).collect());
    detection
        .removals
        .iter()
        .filter_map(|(removal, d_gmm)| {
            Some(RemovalRecord {
                from: ["gamma", "theta"][removal.side].to_owned(),
                component: present[removal.side]
                    .binary_search(&removal.component)
                    .ok()?,
                d_gmm: *d_gmm,
                needed_for_alarm: removal.needed_for_alarm,
            })
        })
        .collect()
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
    /// `standard`, `paper` or `paper-independent`.
    pub engine: String,
    /// Seed of the random number generators.
    pub seed: u64,
    /// Pose of the revisit relative to the reference.
    pub pose_correction: PoseCorrection,
    /// How much of the reference the visit could judge; none in logs of earlier versions.
    #[serde(default)]
    pub coverage: Option<CoverageRecord>,
    /// Size of the reference.
    pub reference: ViewCounts,
    /// Size of the revisit.
    pub current: ViewCounts,
    /// Gaussians that Algorithm 1 took, in order. Empty in logs of earlier versions.
    #[serde(default)]
    pub removed: Vec<RemovalRecord>,
    /// Listed novelties, in the frame of the revisit.
    pub novelties: Vec<NoveltyRecord>,
}

impl InspectionReport {
    /// The report of `inspection`; `points` are those of reference and revisit, `engine` is its name.
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
            coverage: Some((&detection.coverage).into()),
            reference,
            current,
            removed: removed(detection),
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
