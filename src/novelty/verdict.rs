//! Quiet, changed or not observed, and why.

use super::{Balance, Verdict, VerdictSettings};
use crate::geometry::Registration;

/// What the verdict is read from.
pub struct Findings<'a> {
    /// How the views were brought together.
    pub registration: &'a Registration,
    /// Noise of the difference of the views over the noise that they have themselves.
    pub disagreement: f64,
    /// d_GMM and its parts.
    pub balance: &'a Balance,
    /// Threshold of d_GMM.
    pub u_th: f64,
    /// Number of listed novelties.
    pub listed: usize,
}

/// The verdict with its reason.
pub fn verdict(findings: &Findings<'_>, settings: &VerdictSettings) -> (Verdict, String) {
    if let Some(reason) = blind(findings, settings) {
        return (Verdict::NotObserved, reason);
    }
    let (d, u_th, listed) = (findings.balance.d, findings.u_th, findings.listed);
    let things = if listed == 1 {
        "1 novelty".to_owned()
    } else {
        format!("{listed} novelties")
    };
    match (d >= u_th, listed > 0) {
        (true, true) => (
            Verdict::Changed,
            format!("d_GMM {d:.5} reaches U_th {u_th:.5}, {things}"),
        ),
        (true, false) => (
            Verdict::NotObserved,
            format!("unexplained difference: d_GMM {d:.5} reaches U_th {u_th:.5}, no novelty"),
        ),
        (false, true) => (
            Verdict::Quiet,
            format!("d_GMM {d:.5} is below U_th {u_th:.5} in spite of {things}"),
        ),
        (false, false) => (
            Verdict::Quiet,
            format!("d_GMM {d:.5} is below U_th {u_th:.5}"),
        ),
    }
}

/// Why nothing can be said, if so.
fn blind(findings: &Findings<'_>, settings: &VerdictSettings) -> Option<String> {
    let registration = findings.registration;
    let pose = &registration.current_from_reference;
    if !registration.converged {
        return Some(format!(
            "the views do not match: {:.0} % of the flat surfaces agree",
            100.0 * registration.share
        ));
    }
    let shift_m = pose.translation.vector.norm();
    let turn_rad = pose.rotation.angle();
    if shift_m > settings.most_shift_m || turn_rad > settings.most_turn_rad {
        return Some(format!(
            "the robot stands elsewhere: {shift_m:.2} m and {:.1} deg from the reference",
            turn_rad.to_degrees()
        ));
    }
    if findings.disagreement > settings.most_disagreement {
        return Some(format!(
            "surfaces seen by both views lie {:.1} times further apart than their noise explains",
            findings.disagreement
        ));
    }
    let overlap = findings.balance.overlap[0].min(findings.balance.overlap[1]);
    if overlap < settings.least_overlap {
        return Some(format!(
            "only {:.0} % of the place was seen by both views",
            100.0 * overlap
        ));
    }
    None
}
