//! What a calibration found, for people and for programs.

use patrold_engine::sweep::{Calibration, Estimate, Parameter};
use serde_json::{Value, json};

/// Standard deviations by which a place must differ from what a ruler gave to be proposed.
const PLACE_SIGMAS: f64 = 3.0;

/// Name, unit, and units per metre, radian or second.
fn told(parameter: Parameter) -> (&'static str, &'static str, f64) {
    let deg = 1f64.to_degrees();
    match parameter {
        Parameter::Roll => ("roll", "deg", deg),
        Parameter::Pitch => ("pitch", "deg", deg),
        Parameter::Yaw => ("yaw", "deg", deg),
        Parameter::X => ("x", "m", 1.0),
        Parameter::Y => ("y", "m", 1.0),
        Parameter::Z => ("z", "m", 1.0),
        Parameter::TimeOffset => ("time_offset", "ms", 1e3),
        Parameter::Backlash => ("backlash", "deg", deg),
        Parameter::RangeOffset => ("range_offset", "m", 1.0),
    }
}

fn estimate(found: &Calibration, parameter: Parameter) -> Option<&Estimate> {
    found.estimates.iter().find(|e| e.parameter == parameter)
}

/// The value to write, in the unit of the configuration: the one in force where the sweeps do not tell a better one.
fn proposed(found: &Calibration, parameter: Parameter) -> f64 {
    let (_, _, factor) = told(parameter);
    let Some(e) = estimate(found, parameter) else {
        return 0.0;
    };
    let place = matches!(parameter, Parameter::X | Parameter::Y | Parameter::Z);
    let measured = place && (e.value - e.present).abs() <= PLACE_SIGMAS * e.sigma;
    let value = if e.observable && !measured {
        e.value
    } else {
        e.present
    };
    factor * value
}

/// Lines of configuration: only keys of which the sweeps tell something.
fn proposals(found: &Calibration) -> Vec<String> {
    let any = |parameters: &[Parameter]| {
        let mut known = parameters.iter().filter_map(|p| estimate(found, *p));
        known.any(|e| e.observable)
    };
    let moved = |parameters: &[Parameter]| {
        parameters.iter().any(|p| {
            let present = estimate(found, *p).map_or(0.0, |e| e.present);
            proposed(found, *p) != told(*p).2 * present
        })
    };
    let triple = |p: [Parameter; 3], places: usize| {
        let [a, b, c] = p.map(|p| proposed(found, p));
        format!("[{a:.places$}, {b:.places$}, {c:.places$}]")
    };
    let turns = [Parameter::Roll, Parameter::Pitch, Parameter::Yaw];
    let places = [Parameter::X, Parameter::Y, Parameter::Z];
    let mut lines = Vec::new();
    if any(&turns) {
        lines.push(format!("mount.rpy_deg = {}", triple(turns, 3)));
    }
    if moved(&places) {
        lines.push(format!("mount.xyz_m = {}", triple(places, 4)));
    }
    if any(&[Parameter::Backlash]) {
        let backlash = proposed(found, Parameter::Backlash);
        lines.push(format!("ptu.tilt_backlash_deg = {backlash:.4}"));
    }
    if any(&[Parameter::TimeOffset]) {
        let time = proposed(found, Parameter::TimeOffset);
        lines.push(format!("sweep.time_offset_ms = {time:.3}"));
    }
    lines
}

/// For programs.
pub fn report(found: &Calibration, sweeps: usize) -> Value {
    let parameters: Vec<Value> = found
        .estimates
        .iter()
        .map(|e| {
            let (name, unit, factor) = told(e.parameter);
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
    let apart = found
        .up_against_down_m
        .map(|(present, proposed)| json!({"present": 1e3 * present, "proposed": 1e3 * proposed}));
    json!({
        "sweeps": sweeps,
        "legs": found.legs,
        "planes": found.planes,
        "beams": found.beams,
        "residual_mm": 1e3 * found.residual_m,
        "up_against_down_mm": apart,
        "parameters": parameters,
        "config": proposals(found),
    })
}

/// For people.
pub fn lines(found: &Calibration) -> Vec<String> {
    let mut lines = vec![format!(
        "{} beams on {} flat surfaces of {} legs, {:.1} mm off them",
        found.beams,
        found.planes,
        found.legs,
        1e3 * found.residual_m
    )];
    if let Some((present, proposed)) = found.up_against_down_m {
        lines.push(format!(
            "surfaces of travels up and down lie {:.1} mm apart, {:.1} mm with the new values",
            1e3 * present,
            1e3 * proposed
        ));
    }
    for e in &found.estimates {
        let (name, unit, factor) = told(e.parameter);
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
        "a turn of the head's zero (ptu.tilt_zero_deg) looks like pitch, and is counted as such"
            .to_owned(),
    );
    lines.extend(proposals(found));
    lines
}
