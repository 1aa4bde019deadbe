//! The report of a calibration, as JSON and as text.

use patrold_engine::sweep::{Calibration, CalibrationParameter, ParameterEstimate};
use serde_json::{Value, json};

/// Standard deviations by which a value must differ from the configured one to be proposed: within them, one of twenty right
/// values lies beyond.
const MIN_CHANGE_SIGMAS: f64 = 2.0;

const ROTATION: [CalibrationParameter; 3] = [
    CalibrationParameter::Roll,
    CalibrationParameter::Pitch,
    CalibrationParameter::Yaw,
];
const POSITION: [CalibrationParameter; 3] = [
    CalibrationParameter::X,
    CalibrationParameter::Y,
    CalibrationParameter::Z,
];

/// Name, unit, and units per metre, radian or second.
fn name_and_unit(parameter: CalibrationParameter) -> (&'static str, &'static str, f64) {
    let deg = 1f64.to_degrees();
    match parameter {
        CalibrationParameter::Roll => ("roll", "deg", deg),
        CalibrationParameter::Pitch => ("pitch", "deg", deg),
        CalibrationParameter::Yaw => ("yaw", "deg", deg),
        CalibrationParameter::X => ("x", "m", 1.0),
        CalibrationParameter::Y => ("y", "m", 1.0),
        CalibrationParameter::Z => ("z", "m", 1.0),
        CalibrationParameter::TimeOffset => ("time_offset", "ms", 1e3),
        CalibrationParameter::Backlash => ("backlash", "deg", deg),
        CalibrationParameter::RangeOffset => ("range_offset", "m", 1.0),
    }
}

fn find_estimate(
    calibration: &Calibration,
    parameter: CalibrationParameter,
) -> Option<&ParameterEstimate> {
    calibration
        .estimates
        .iter()
        .find(|e| e.parameter == parameter)
}

/// The value to configure, in the unit of the configuration: the present one where the sweeps give no better one.
fn proposed_value(calibration: &Calibration, parameter: CalibrationParameter) -> f64 {
    let (_, _, factor) = name_and_unit(parameter);
    let Some(e) = find_estimate(calibration, parameter) else {
        return 0.0;
    };
    factor * if is_changed(e) { e.value } else { e.present }
}

/// Whether the sweeps give a better value than the present one, not just another.
fn is_changed(e: &ParameterEstimate) -> bool {
    e.observable && (e.value - e.present).abs() > MIN_CHANGE_SIGMAS * e.sigma
}

/// Configuration lines, for keys whose value is not right within its error.
fn proposed_lines(calibration: &Calibration) -> Vec<String> {
    let any_changed = |parameters: &[CalibrationParameter]| {
        let mut estimates = parameters
            .iter()
            .filter_map(|p| find_estimate(calibration, *p));
        estimates.any(is_changed)
    };
    let triple = |p: [CalibrationParameter; 3], decimals: usize| {
        let [a, b, c] = p.map(|p| proposed_value(calibration, p));
        format!("[{a:.decimals$}, {b:.decimals$}, {c:.decimals$}]")
    };
    let mut lines = Vec::new();
    if any_changed(&ROTATION) {
        lines.push(format!("mount.rpy_deg = {}", triple(ROTATION, 3)));
    }
    if any_changed(&POSITION) {
        lines.push(format!("mount.xyz_m = {}", triple(POSITION, 4)));
    }
    if any_changed(&[CalibrationParameter::Backlash]) {
        let backlash = proposed_value(calibration, CalibrationParameter::Backlash);
        lines.push(format!("ptu.tilt_backlash_deg = {backlash:.4}"));
    }
    if any_changed(&[CalibrationParameter::TimeOffset]) {
        let time_offset = proposed_value(calibration, CalibrationParameter::TimeOffset);
        lines.push(format!("sweep.time_offset_ms = {time_offset:.3}"));
    }
    lines
}

/// Whether there is a line to write to the configuration.
pub(super) fn has_proposals(calibration: &Calibration) -> bool {
    !proposed_lines(calibration).is_empty()
}

pub(super) fn report_json(calibration: &Calibration, sweeps: usize) -> Value {
    let parameters: Vec<Value> = calibration
        .estimates
        .iter()
        .map(|e| {
            let (name, unit, factor) = name_and_unit(e.parameter);
            json!({
                "name": name,
                "unit": unit,
                "present": factor * e.present,
                "value": e.observable.then_some(factor * e.value),
                "sigma": factor * e.sigma,
                "observable": e.observable,
            })
        })
        .collect();
    let up_down = calibration
        .up_down_mismatch_m
        .map(|(present, proposed)| json!({"present": 1e3 * present, "proposed": 1e3 * proposed}));
    json!({
        "sweeps": sweeps,
        "legs": calibration.pan_segments,
        "planes": calibration.planes,
        "beams": calibration.beams,
        "residual_mm": 1e3 * calibration.residual_m,
        "up_against_down_mm": up_down,
        "parameters": parameters,
        "config": proposed_lines(calibration),
    })
}

pub(super) fn report_lines(calibration: &Calibration) -> Vec<String> {
    let mut lines = vec![format!(
        "{} beams on {} flat surfaces in {} pan segments, residual {:.1} mm",
        calibration.beams,
        calibration.planes,
        calibration.pan_segments,
        1e3 * calibration.residual_m
    )];
    if let Some((present, proposed)) = calibration.up_down_mismatch_m {
        lines.push(format!(
            "surfaces of upward and downward travels differ by {:.1} mm, by {:.1} mm with the new values",
            1e3 * present,
            1e3 * proposed
        ));
    }
    for e in &calibration.estimates {
        let (name, unit, factor) = name_and_unit(e.parameter);
        let present = factor * e.present;
        lines.push(if e.observable {
            let (value, sigma) = (factor * e.value, factor * e.sigma);
            let within = if is_changed(e) { "" } else { ", right within its error" };
            format!("{name}: {value:.4} +- {sigma:.4} {unit} (in force: {present:.4}{within})")
        } else {
            let sigma = factor * e.sigma;
            format!("{name}: not observable in these sweeps (+- {sigma:.4} {unit}; in force: {present:.4})")
        });
    }
    lines.push(
        "an error of the head's zero (ptu.tilt_zero_deg) is indistinguishable from pitch and counted as pitch"
            .to_owned(),
    );
    let proposed = proposed_lines(calibration);
    if proposed.is_empty() {
        lines.push(
            "nothing to change: what these sweeps determine is right within its error".to_owned(),
        );
    }
    lines.extend(proposed);
    lines
}

#[cfg(test)]
mod tests {
    use super::{
        Calibration, CalibrationParameter, ParameterEstimate, has_proposals, proposed_lines,
        report_lines,
    };
    use crate::config::{ConfigFile, ConfigLayers, Settings};
    use std::path::PathBuf;

    /// Of values 0.001, 0.002 ... where 0 is in force.
    fn calibration(sigmas_off: f64) -> Calibration {
        let estimate = |(n, parameter)| {
            let value = 0.001 * (f64::from(n) + 1.0);
            ParameterEstimate {
                parameter,
                present: 0.0,
                value,
                sigma: value / sigmas_off,
                observable: true,
            }
        };
        Calibration {
            estimates: (0..).zip(CalibrationParameter::ALL).map(estimate).collect(),
            pan_segments: 3,
            planes: 5,
            beams: 1000,
            residual_m: 0.002,
            up_down_mismatch_m: None,
        }
    }

    #[test]
    fn only_what_differs_by_more_than_its_error_is_proposed() {
        let right = calibration(1.9);
        assert_eq!(proposed_lines(&right), [""; 0]);
        assert!(!has_proposals(&right));
        let lines = report_lines(&right);
        let said = |what| lines.iter().filter(|line| line.contains(what)).count();
        assert_eq!(said("right within its error)"), right.estimates.len());
        assert_eq!(said("nothing to change"), 1, "{lines:?}");

        let wrong = calibration(2.1);
        assert_eq!(proposed_lines(&wrong).len(), 4);
        assert!(has_proposals(&wrong));
        assert!(
            !report_lines(&wrong)
                .iter()
                .any(|l| l.contains("right within"))
        );

        // A triple has the present value for what is right.
        let mut one = calibration(1.9);
        let x = |e: &&mut ParameterEstimate| e.parameter == CalibrationParameter::X;
        let x = one.estimates.iter_mut().find(x).expect("an estimate");
        (x.value, x.sigma) = (0.03, 0.01);
        assert_eq!(
            proposed_lines(&one),
            ["mount.xyz_m = [0.0300, 0.0000, 0.0000]"]
        );
        // What the sweeps do not determine is not proposed, whatever its value.
        for e in &mut one.estimates {
            e.observable = false;
        }
        assert_eq!(proposed_lines(&one), [""; 0]);
    }

    #[test]
    fn the_proposed_lines_are_read_back_as_what_was_found() {
        let calibration = calibration(1000.0);
        let found = |parameter| {
            let estimates = &calibration.estimates;
            let found = estimates.iter().find(|e| e.parameter == parameter);
            found.expect("an estimate").value
        };
        let mut layers = ConfigLayers::defaults();
        let file = ConfigFile {
            path: PathBuf::from("t.toml"),
            text: proposed_lines(&calibration).join("\n"),
        };
        assert_eq!(layers.add(&file), []);
        let settings = Settings::from_layers(&layers).expect("valid");
        let ([roll, pitch, yaw], [x, y, z]) =
            (settings.mount.laser_rpy_rad, settings.mount.laser_m);
        for (parameter, got) in [
            (CalibrationParameter::Roll, roll),
            (CalibrationParameter::Pitch, pitch),
            (CalibrationParameter::Yaw, yaw),
            (CalibrationParameter::X, x),
            (CalibrationParameter::Y, y),
            (CalibrationParameter::Z, z),
            (
                CalibrationParameter::TimeOffset,
                settings.sweep.time_offset_s,
            ),
            (
                CalibrationParameter::Backlash,
                settings.ptu.tilt_backlash_rad,
            ),
        ] {
            // The decimals of the lines.
            let error = (got - found(parameter)).abs();
            assert!(error < 6e-5, "{parameter:?}: {got}");
        }
    }
}
