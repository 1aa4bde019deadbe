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
    // No comparison with a figure that is no number holds: it would pass every gate below.
    let figures = [
        ("the distance", findings.balance.d),
        ("the threshold", findings.u_th),
        ("the agreement of the surfaces", findings.disagreement),
        ("the reference's overlap", findings.balance.overlap[0]),
        ("the revisit's overlap", findings.balance.overlap[1]),
        ("the registration's share", registration.share),
        ("the shift", pose.translation.vector.norm()),
        ("the turn", pose.rotation.angle()),
    ];
    if let Some((which, value)) = figures.into_iter().find(|(_, value)| !value.is_finite()) {
        return Some(format!("{which} came out as {value}"));
    }
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

#[cfg(test)]
mod tests {
    use super::{Findings, verdict};
    use crate::geometry::Registration;
    use crate::novelty::{Balance, Verdict, VerdictSettings};

    fn balance() -> Balance {
        Balance {
            d: 1e-5,
            work_m3: 1e-5,
            surface_m2: 1.0,
            appeared: Vec::new(),
            disappeared: Vec::new(),
            rest: 1e-5,
            components: [1; 2],
            overlap: [0.9; 2],
        }
    }

    fn judged(
        registration: &Registration,
        balance: &Balance,
        disagreement: f64,
    ) -> (Verdict, String) {
        let findings = Findings {
            registration,
            disagreement,
            balance,
            u_th: 5e-4,
            listed: 0,
        };
        verdict(&findings, &VerdictSettings::default())
    }

    #[test]
    fn a_figure_that_is_no_number_is_never_quiet() {
        let same = Registration::identity();
        assert_eq!(judged(&same, &balance(), 1.0).0, Verdict::Quiet);
        let mut cases = Vec::new();
        for bad in [f64::NAN, f64::INFINITY] {
            cases.push(judged(&same, &balance(), bad));
            let d = Balance {
                d: bad,
                ..balance()
            };
            cases.push(judged(&same, &d, 1.0));
            for overlap in [[bad, 0.9], [0.9, bad]] {
                let partly = Balance {
                    overlap,
                    ..balance()
                };
                cases.push(judged(&same, &partly, 1.0));
            }
        }
        let mut lost = Registration::identity();
        lost.current_from_reference.translation.vector.x = f64::NAN;
        cases.push(judged(&lost, &balance(), 1.0));
        for (word, reason) in cases {
            assert_eq!(word, Verdict::NotObserved, "{reason}");
            assert!(reason.contains("came out as"), "{reason}");
        }
    }
}
