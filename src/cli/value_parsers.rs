//! Parsers of option values that several commands have.

use crate::patrol::name::waypoint_name_error;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use nalgebra::Point3;
use patrold_engine::inspect::Engine;

/// The names of the engines, with their help.
pub(super) fn engine_values() -> [PossibleValue; 3] {
    Engine::ALL.map(|engine| {
        let help = match engine {
            Engine::Standard => "patrold's own",
            Engine::Paper => "The paper's chain, fitted from the reference",
            Engine::PaperIndependent => "The published recipe to the letter",
        };
        PossibleValue::new(engine.as_str()).help(help)
    })
}

/// Reads the name of an engine.
pub(super) fn engine() -> impl TypedValueParser<Value = Engine> {
    PossibleValuesParser::new(engine_values()).try_map(|name| name.parse::<Engine>())
}

/// Reads a name that a waypoint can have.
pub(super) fn parse_waypoint_name(text: &str) -> Result<String, String> {
    match waypoint_name_error(text) {
        Some(why) => Err(why),
        None => Ok(text.to_owned()),
    }
}

/// Reads a whole number from 1.
pub(super) fn parse_positive(text: &str) -> Result<usize, String> {
    match text.parse::<u32>() {
        Ok(n) if n > 0 => Ok(n as usize),
        _ => Err("expected a number from 1".to_owned()),
    }
}

/// Reads a number of device seconds per second of wall time.
pub(super) fn parse_time_scale(text: &str) -> Result<f64, String> {
    let scale = text.parse::<f64>().ok();
    scale
        .filter(|x| (0.001..=1000.0).contains(x))
        .ok_or_else(|| "expected a number from 0.001 to 1000".to_owned())
}

/// Reads a length of at least 0 metres.
pub(super) fn parse_metres(text: &str) -> Result<f64, String> {
    let metres = text.parse::<f64>().ok();
    metres
        .filter(|m| m.is_finite() && *m >= 0.0)
        .ok_or_else(|| format!("expected metres, from 0, got {text:?}"))
}

/// Reads two numbers `X,Y`.
pub(super) fn parse_floor_point(text: &str) -> Result<[f64; 2], String> {
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let point = text
        .split_once(',')
        .and_then(|(x, y)| Some([number(x)?, number(y)?]));
    point.ok_or_else(|| format!("expected two numbers X,Y, got {text:?}"))
}

/// Reads three numbers `X,Y,Z`.
pub(super) fn parse_point(text: &str) -> Result<Point3<f64>, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>().ok().filter(|x| x.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(|| format!("expected three numbers X,Y,Z, got {text:?}"))?;
    match numbers[..] {
        [x, y, z] => Ok(Point3::new(x, y, z)),
        _ => Err(format!(
            "expected three numbers X,Y,Z, got {}",
            numbers.len()
        )),
    }
}
