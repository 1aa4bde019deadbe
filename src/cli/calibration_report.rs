//! The report of a calibration, as JSON and as text.

use patrold_engine::sweep::{Calibration, CalibrationParameter, ParameterEstimate};
use serde_json::{Value, json};

/// Standard deviations by which a position must differ from the configured one to be proposed: a ruler may measure it
/// better.
const MIN_POSITION_CHANGE_SIGMAS: f64 = 3.0;

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
    let is_position = POSITION.contains(&parameter);
    let keep_present =
        is_position && (e.value - e.present).abs() <= MIN_POSITION_CHANGE_SIGMAS * e.sigma;
    let value = if e.observable && !keep_present {
        e.value
    } else {
        e.present
    };
    factor * value
}

/// Configuration lines, for keys that the sweeps determine.
fn proposed_lines(calibration: &Calibration) -> Vec<String> {
    let any_observable = |parameters: &[CalibrationParameter]| {
        let mut estimates = parameters
            .iter()
            .filter_map(|p| find_estimate(calibration, *p));
        estimates.any(|e| e.observable)
    };
    let any_changed = |parameters: &[CalibrationParameter]| {
        parameters.iter().any(|p| {
            let present = find_estimate(calibration, *p).map_or(0.0, |e| e.present);
            proposed_value(calibration, *p) != name_and_unit(*p).2 * present
        })
    };
    let triple = |p: [CalibrationParameter; 3], decimals: usize| {
        let [a, b, c] = p.map(|p| proposed_value(calibration, p));
        format!("[{a:.decimals$}, {b:.decimals$}, {c:.decimals$}]")
    };
    let mut lines = Vec::new();
    if any_observable(&ROTATION) {
        lines.push(format!("mount.rpy_deg = {}", triple(ROTATION, 3)));
    }
    if any_changed(&POSITION) {
        lines.push(format!("mount.xyz_m = {}", triple(POSITION, 4)));
    }
    if any_observable(&[CalibrationParameter::Backlash]) {
        let backlash = proposed_value(calibration, CalibrationParameter::Backlash);
        lines.push(format!("ptu.tilt_backlash_deg = {backlash:.4}"));
    }
    if any_observable(&[CalibrationParameter::TimeOffset]) {
        let time_offset = proposed_value(calibration, CalibrationParameter::TimeOffset);
        lines.push(format!("sweep.time_offset_ms = {time_offset:.3}"));
    }
    lines
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
            format!("{name}: {value:.4} +- {sigma:.4} {unit} (in force: {present:.4})")
        } else {
            let sigma = factor * e.sigma;
            format!("{name}: not observable in these sweeps (+- {sigma:.4} {unit}; in force: {present:.4})")
        });
    }
    lines.push(
        "an error of the head's zero (ptu.tilt_zero_deg) is indistinguishable from pitch and counted as pitch"
            .to_owned(),
    );
    lines.extend(proposed_lines(calibration));
    lines
}

#[cfg(test)]
mod tests {
    use super::{Calibration, CalibrationParameter, ParameterEstimate, proposed_lines};
    use crate::config::{ConfigFile, ConfigLayers, Settings};
    use std::path::PathBuf;

    #[test]
    fn the_proposed_lines_are_read_back_as_what_was_found() {
        let estimate = |(n, parameter)| ParameterEstimate {
            parameter,
            present: 0.0,
            value: 0.001 * (n as f64 + 1.0),
            sigma: 1e-6,
            observable: true,
        };
        let calibration = Calibration {
            estimates: (0..).zip(CalibrationParameter::ALL).map(estimate).collect(),
            pan_segments: 3,
            planes: 5,
            beams: 1000,
            residual_m: 0.002,
            up_down_mismatch_m: None,
        };
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
