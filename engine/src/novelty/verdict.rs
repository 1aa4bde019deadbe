//! The verdict and its reason (`docs/novelty.md section 9`).

use super::quantified_change::QuantifiedChange;
use super::{AbsorbingThing, Coverage, Verdict, VerdictSettings};
use crate::geometry::Registration;

/// What the verdict depends on.
pub(super) struct Findings<'a> {
    pub registration: &'a Registration,
    /// Noise between the views over the noise of both.
    pub disagreement: f64,
    /// d_GMM and its parts.
    pub change: &'a QuantifiedChange,
    pub coverage: &'a Coverage,
    pub u_th: f64,
    /// Number of listed novelties.
    pub novelties: usize,
    pub absorbing: &'a [AbsorbingThing],
}

/// The verdict with its reason.
pub(super) fn verdict(findings: &Findings<'_>, settings: &VerdictSettings) -> (Verdict, String) {
    if let Some(reason) = not_observed_reason(findings, settings) {
        return (Verdict::NotObserved, reason);
    }
    let (d, u_th, count) = (findings.change.d, findings.u_th, findings.novelties);
    let novelties = if count == 1 {
        "1 novelty".to_owned()
    } else {
        format!("{count} novelties")
    };
    // What is proved is changed however little was seen.
    if !(d >= u_th && count > 0)
        && let Some(reason) = coverage_reason(findings.coverage, settings.min_coverage)
            .or_else(|| absorbing_reason(findings.absorbing))
    {
        return (Verdict::NotObserved, reason);
    }
    match (d >= u_th, count > 0) {
        (true, true) => (
            Verdict::Changed,
            format!("d_GMM {d:.5} reaches U_th {u_th:.5}, {novelties}"),
        ),
        (true, false) => (
            Verdict::NotObserved,
            format!("unexplained difference: d_GMM {d:.5} reaches U_th {u_th:.5}, no novelty"),
        ),
        (false, true) => (
            Verdict::Quiet,
            format!("d_GMM {d:.5} is below U_th {u_th:.5} in spite of {novelties}"),
        ),
        (false, false) => (
            Verdict::Quiet,
            format!("d_GMM {d:.5} is below U_th {u_th:.5}"),
        ),
    }
}

/// Why too little was seen to say that nothing changed, if so.
fn coverage_reason(coverage: &Coverage, least: f64) -> Option<String> {
    if coverage.solid_angle >= least {
        return None;
    }
    let missing = match coverage.missing.as_str() {
        "" => String::new(),
        missing => format!(": {missing}"),
    };
    Some(format!(
        "only {:.0} % of the solid angle and {:.0} % of the surface of the reference could be judged{missing}",
        100.0 * coverage.solid_angle,
        100.0 * coverage.surface
    ))
}

/// What may stand where nothing came back, if anything.
fn absorbing_reason(things: &[AbsorbingThing]) -> Option<String> {
    let largest = things.iter().max_by_key(|thing| thing.beams)?;
    let [right, left] = largest.bearings_rad.map(f64::to_degrees);
    let more = match things.len() {
        1 => String::new(),
        count => format!(", and {} more", count - 1),
    };
    Some(format!(
        "something gives nothing back at bearings {right:.0} to {left:.0} deg, nearer than {:.1} m ({} beams){more}",
        largest.far_m, largest.beams
    ))
}

/// Why a registration did not converge, if so.
pub(crate) fn unmatched_reason(registration: &Registration) -> Option<String> {
    if registration.converged {
        return None;
    }
    let Some(rival) = &registration.rival else {
        return Some(format!(
            "the views do not match: {:.0} % of the flat surfaces agree, {:.0} % where every direction counts alike",
            // A sum of nothing is negative zero.
            100.0 * registration.agreement + 0.0,
            100.0 * registration.agreement_by_direction + 0.0
        ));
    };
    let between = rival.inverse() * registration.current_from_reference;
    Some(format!(
        "the views match at two poses, {:.2} m and {:.1} deg apart",
        between.translation.vector.norm(),
        between.rotation.angle().to_degrees()
    ))
}

/// Why no answer is possible, if so.
fn not_observed_reason(findings: &Findings<'_>, settings: &VerdictSettings) -> Option<String> {
    let registration = findings.registration;
    let pose = &registration.current_from_reference;
    // A value that is not finite would pass every gate below.
    let values = [
        ("the distance", findings.change.d),
        ("the threshold", findings.u_th),
        ("the agreement of the surfaces", findings.disagreement),
        ("the reference's overlap", findings.change.overlap[0]),
        ("the current view's overlap", findings.change.overlap[1]),
        ("the coverage", findings.coverage.solid_angle),
        ("the registration's agreement", registration.agreement),
        ("the shift", pose.translation.vector.norm()),
        ("the rotation", pose.rotation.angle()),
    ];
    if let Some((name, value)) = values.into_iter().find(|(_, value)| !value.is_finite()) {
        return Some(format!("{name} is {value}"));
    }
    if let Some(reason) = unmatched_reason(registration) {
        return Some(reason);
    }
    let shift_m = pose.translation.vector.norm();
    let rotation_rad = pose.rotation.angle();
    if shift_m > settings.max_shift_m || rotation_rad > settings.max_rotation_rad {
        return Some(format!(
            "the robot is elsewhere: {shift_m:.2} m and {:.1} deg from the reference",
            rotation_rad.to_degrees()
        ));
    }
    if findings.disagreement > settings.max_disagreement {
        return Some(format!(
            "surfaces seen by both views are {:.1} times further apart than their noise explains",
            findings.disagreement
        ));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{Findings, verdict};
    use crate::geometry::Registration;
    use crate::novelty::quantified_change::QuantifiedChange;
    use crate::novelty::{AbsorbingThing, Coverage, Verdict, VerdictSettings};

    fn change() -> QuantifiedChange {
        QuantifiedChange {
            d: 1e-5,
            work_m3: 1e-5,
            shares: Default::default(),
            unexplained: 1e-5,
            components: [1; 2],
            overlap: [0.9; 2],
        }
    }

    fn coverage(surface: f64, solid_angle: f64) -> Coverage {
        Coverage {
            surface,
            solid_angle,
            missing: "5 % hidden".to_owned(),
        }
    }

    fn verdict_of(
        registration: &Registration,
        change: &QuantifiedChange,
        disagreement: f64,
    ) -> (Verdict, String) {
        let findings = Findings {
            registration,
            disagreement,
            change,
            coverage: &coverage(0.9, 0.9),
            u_th: 5e-4,
            novelties: 0,
            absorbing: &[],
        };
        verdict(&findings, &VerdictSettings::default())
    }

    fn with_coverage(
        surface: f64,
        solid_angle: f64,
        d: f64,
        novelties: usize,
    ) -> (Verdict, String) {
        let findings = Findings {
            registration: &Registration::identity(),
            disagreement: 1.0,
            change: &QuantifiedChange { d, ..change() },
            coverage: &coverage(surface, solid_angle),
            u_th: 5e-4,
            novelties,
            absorbing: &[],
        };
        verdict(&findings, &VerdictSettings::default())
    }

    #[test]
    fn a_value_that_is_not_finite_is_never_quiet() {
        let same = Registration::identity();
        assert_eq!(verdict_of(&same, &change(), 1.0).0, Verdict::Quiet);
        let mut cases = Vec::new();
        for bad in [f64::NAN, f64::INFINITY] {
            cases.push(verdict_of(&same, &change(), bad));
            let d = QuantifiedChange { d: bad, ..change() };
            cases.push(verdict_of(&same, &d, 1.0));
            for overlap in [[bad, 0.9], [0.9, bad]] {
                let partly = QuantifiedChange {
                    overlap,
                    ..change()
                };
                cases.push(verdict_of(&same, &partly, 1.0));
            }
        }
        let mut lost = Registration::identity();
        lost.current_from_reference.translation.vector.x = f64::NAN;
        cases.push(verdict_of(&lost, &change(), 1.0));
        for (verdict, reason) in cases {
            assert_eq!(verdict, Verdict::NotObserved, "{reason}");
            assert!(
                reason.contains(" is NaN") || reason.contains(" is inf"),
                "{reason}"
            );
        }
    }

    /// The verdict of views that agree but for `spoil`, and a word of its reason.
    fn gate(
        spoil: impl Fn(&mut Registration, &mut QuantifiedChange, &mut f64),
    ) -> (Verdict, String) {
        let (mut registration, mut change, mut disagreement) =
            (Registration::identity(), change(), 1.0);
        spoil(&mut registration, &mut change, &mut disagreement);
        verdict_of(&registration, &change, disagreement)
    }

    #[test]
    fn each_gate_alone_refuses_beyond_its_limit_and_not_before() {
        let limits = VerdictSettings::default();
        type Case<'a> = (&'a str, Box<dyn Fn(f64) -> (Verdict, String)>, f64);
        let shift = |axis: usize| -> Box<dyn Fn(f64) -> (Verdict, String)> {
            Box::new(move |m| gate(|r, _, _| r.current_from_reference.translation.vector[axis] = m))
        };
        let turn = |rad: f64| {
            gate(|r, _, _| {
                r.current_from_reference.rotation =
                    nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, rad);
            })
        };
        let above: [Case<'_>; 5] = [
            ("elsewhere", shift(0), limits.max_shift_m),
            ("elsewhere", shift(1), limits.max_shift_m),
            ("elsewhere", shift(2), limits.max_shift_m),
            ("elsewhere", Box::new(turn), limits.max_rotation_rad),
            (
                "further apart",
                Box::new(|x| gate(|_, _, disagreement| *disagreement = x)),
                limits.max_disagreement,
            ),
        ];
        for (word, of, limit) in above {
            assert_eq!(of(0.999 * limit).0, Verdict::Quiet, "{word}");
            let (verdict, reason) = of(1.001 * limit);
            assert_eq!(verdict, Verdict::NotObserved, "{word}");
            assert!(reason.contains(word), "{reason}");
        }
        let (verdict, reason) = gate(|r, _, _| r.converged = false);
        assert_eq!(verdict, Verdict::NotObserved);
        assert!(reason.contains("do not match"), "{reason}");
        let (verdict, reason) = gate(|r, _, _| {
            r.converged = false;
            r.rival = Some(nalgebra::Isometry3::translation(0.3, 0.0, 0.4));
        });
        assert_eq!(verdict, Verdict::NotObserved);
        assert_eq!(
            reason,
            "the views match at two poses, 0.50 m and 0.0 deg apart"
        );
    }

    #[test]
    fn too_little_of_the_solid_angle_seen_is_not_quiet() {
        let least = VerdictSettings::default().min_coverage;
        for (surface, solid_angle, expected) in [
            (0.1, least, Verdict::Quiet),
            (1.0, least, Verdict::Quiet),
            (1.0, least - 1e-6, Verdict::NotObserved),
        ] {
            let (verdict, reason) = with_coverage(surface, solid_angle, 0.0, 0);
            assert_eq!(verdict, expected, "{reason}");
            // Novelties below the threshold stay listed and do not make it quiet.
            assert_eq!(with_coverage(surface, solid_angle, 1e-4, 1).0, expected);
        }
        let (_, reason) = with_coverage(0.5, 0.6, 0.0, 0);
        assert_eq!(
            reason,
            "only 60 % of the solid angle and 50 % of the surface of the reference could be judged: 5 % hidden"
        );
    }

    #[test]
    fn what_gives_nothing_back_is_not_quiet_and_hides_no_change() {
        let thing = |right_deg: f64, beams| AbsorbingThing {
            bearings_rad: [right_deg, right_deg + 12.0].map(f64::to_radians),
            elevations_rad: [-0.2, 0.3],
            far_m: 2.04,
            beams,
        };
        let of = |things: &[AbsorbingThing], d, novelties| {
            let findings = Findings {
                registration: &Registration::identity(),
                disagreement: 1.0,
                change: &QuantifiedChange { d, ..change() },
                coverage: &coverage(0.9, 0.9),
                u_th: 5e-4,
                novelties,
                absorbing: things,
            };
            verdict(&findings, &VerdictSettings::default())
        };
        let (black, coat) = (thing(-31.0, 1478), thing(40.0, 300));
        let (verdict, reason) = of(&[coat, black], 1e-5, 0);
        assert_eq!(verdict, Verdict::NotObserved);
        assert_eq!(
            reason,
            "something gives nothing back at bearings -31 to -19 deg, nearer than 2.0 m (1478 beams), and 1 more"
        );
        let (_, reason) = of(&[coat], 1e-4, 1);
        assert!(reason.ends_with("(300 beams)"), "{reason}");
        assert_eq!(of(&[black], 5e-4, 1).0, Verdict::Changed);
        assert_eq!(of(&[], 1e-5, 0).0, Verdict::Quiet);
    }

    #[test]
    fn what_is_proved_is_changed_however_little_was_seen() {
        assert_eq!(with_coverage(0.01, 0.01, 1.0, 1).0, Verdict::Changed);
        assert_eq!(with_coverage(0.01, 0.01, 1.0, 0).0, Verdict::NotObserved);
    }

    #[test]
    fn a_coverage_that_is_no_number_is_never_quiet() {
        for bad in [f64::NAN, f64::INFINITY] {
            let (verdict, reason) = with_coverage(0.9, bad, 0.0, 0);
            assert_eq!(verdict, Verdict::NotObserved, "{reason}");
        }
    }

    #[test]
    fn the_threshold_itself_is_reached_and_needs_a_novelty() {
        let of = |d, novelties| with_coverage(0.9, 0.9, d, novelties).0;
        assert_eq!(of(5e-4, 1), Verdict::Changed);
        assert_eq!(of(5e-4, 0), Verdict::NotObserved);
        assert_eq!(of(4.99e-4, 1), Verdict::Quiet);
        assert_eq!(of(4.99e-4, 0), Verdict::Quiet);
    }
}
