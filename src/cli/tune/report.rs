//! The study of a waypoint as JSON and as text.

use crate::alarm::{AlarmCounts, HistogramBin, ThresholdEffect, ThresholdStudy};
use crate::cli::local_time::local_time;
use crate::cli::table;
use crate::cli::threshold_warning::never_alarms_text;
use serde::Serialize;
use serde_json::{Value, json};

/// Rows of the histogram for every power of ten.
const BINS_PER_DECADE: usize = 4;
/// Width of the longest bar, characters.
const BAR_CHARS: f64 = 30.0;

/// What thresholds would have done at one waypoint.
#[derive(Debug, Serialize)]
pub(super) struct WaypointStudy {
    pub(super) waypoint: String,
    /// Ground distance of all figures.
    pub(super) ground: &'static str,
    /// The threshold in force.
    pub(super) u_th: f64,
    pub(super) quiet: u64,
    pub(super) changed: u64,
    pub(super) alarms: AlarmCounts,
    pub(super) histogram: Vec<Value>,
    pub(super) candidates: Vec<ThresholdEffect>,
    pub(super) suggestion: Suggestion,
    /// The threshold of the examples.
    pub(super) looked_at: Option<f64>,
    /// The newest alarms that would be gone.
    pub(super) gone: Vec<Example>,
    /// The newest quiet visits that would have alarmed.
    pub(super) alarming: Vec<Example>,
    pub(super) warnings: Vec<String>,
}

/// The threshold that a rate of false alarms asks for.
#[derive(Debug, Default, Serialize)]
pub(super) struct Suggestion {
    pub(super) false_alarm_rate: f64,
    /// `None` where there was no visit.
    pub(super) u_th: Option<f64>,
}

/// A visit or an alarm, with what it saw.
#[derive(Debug, Serialize)]
pub(super) struct Example {
    pub(super) id: i64,
    pub(super) at: String,
    pub(super) things: Vec<String>,
}

impl WaypointStudy {
    pub(super) fn new(
        waypoint: &str,
        ground: &'static str,
        u_th: f64,
        study: &ThresholdStudy,
    ) -> Self {
        let in_force = study.effects().iter().find(|effect| effect.u_th == u_th);
        let never = in_force.is_some_and(ThresholdEffect::never_alarms);
        let warning = never.then(|| never_alarms_text(waypoint, u_th, study.alarms().all));
        let histogram = bins(study).into_iter().map(|(bin, changed)| {
            json!({"from": bin.from, "to": finite(bin.to), "quiet": bin.count, "changed": changed})
        });
        Self {
            waypoint: waypoint.to_owned(),
            ground,
            u_th,
            quiet: study.quiet().total(),
            changed: study.changed().total(),
            alarms: study.alarms(),
            histogram: histogram.collect(),
            candidates: study.effects().to_vec(),
            suggestion: Suggestion::default(),
            looked_at: None,
            gone: Vec::new(),
            alarming: Vec::new(),
            warnings: warning.into_iter().collect(),
        }
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Bins of quiet visits, each with the changed ones in it, from the first to the last that is not empty.
pub(super) fn bins(study: &ThresholdStudy) -> Vec<(HistogramBin, u64)> {
    let quiet = study.quiet().bins(BINS_PER_DECADE);
    let changed = study.changed().bins(BINS_PER_DECADE);
    let both: Vec<_> = quiet
        .into_iter()
        .zip(changed.iter().map(|bin| bin.count))
        .collect();
    let filled = |(bin, changed): &(HistogramBin, u64)| bin.count + changed > 0;
    match (both.iter().position(filled), both.iter().rposition(filled)) {
        (Some(first), Some(last)) => both[first..=last].to_vec(),
        _ => Vec::new(),
    }
}

pub(super) fn tune_text(study: &WaypointStudy) -> String {
    let unit = if study.ground == "fm" { "" } else { " m" };
    let AlarmCounts {
        all,
        confirmed,
        false_alarms,
    } = study.alarms;
    let mut lines = vec![format!(
        "{}: {} quiet and {} changed visits, {all} alarms ({confirmed} confirmed, {false_alarms} false); U_th in force {}{unit}",
        study.waypoint,
        study.quiet,
        study.changed,
        short(study.u_th)
    )];
    lines.extend(
        study
            .warnings
            .iter()
            .map(|warning| format!("  warning: {warning}")),
    );
    if study.quiet + study.changed == 0 {
        return lines.join("\n");
    }
    lines.push(histogram_table(study));
    lines.push(candidate_table(study));
    let rate = study.suggestion.false_alarm_rate;
    if let Some(u_th) = study.suggestion.u_th {
        lines.push(format!(
            "  at most {rate} of visits to an unchanged place alarm from U_th {}{unit} on",
            short(u_th)
        ));
    }
    if let Some(u_th) = study.looked_at {
        let u_th = short(u_th);
        lines.extend(examples(
            &study.gone,
            &format!("alarms that U_th {u_th} would not have raised"),
        ));
        lines.extend(examples(
            &study.alarming,
            &format!("quiet visits that would have alarmed with U_th {u_th}"),
        ));
    }
    lines.join("\n")
}

fn examples(examples: &[Example], what: &str) -> Vec<String> {
    if examples.is_empty() {
        return Vec::new();
    }
    let line = |example: &Example| {
        let at = local_time(&example.at, false);
        format!("    {} ({at}): {}", example.id, example.things.join("; "))
    };
    let heading = format!("  {what}, the newest:");
    std::iter::once(heading)
        .chain(examples.iter().rev().map(line))
        .collect()
}

fn histogram_table(study: &WaypointStudy) -> String {
    let mut rows = table::table(&["d_GMM from", "to", "quiet", "changed", ""]);
    let count = |bin: &Value, of: &str| bin[of].as_u64().unwrap_or(0);
    let most = study
        .histogram
        .iter()
        .map(|bin| count(bin, "quiet") + count(bin, "changed"))
        .max();
    let scale = BAR_CHARS / most.unwrap_or(1).max(1) as f64;
    // One visit shows.
    let bar = |n: u64, with: &str| with.repeat((scale * n as f64).ceil() as usize);
    for bin in &study.histogram {
        let (quiet, changed) = (count(bin, "quiet"), count(bin, "changed"));
        let edge = |of: &str| bin[of].as_f64().map_or_else(|| "-".to_owned(), short);
        rows.add_row([
            edge("from"),
            edge("to"),
            quiet.to_string(),
            changed.to_string(),
            format!("{}{}", bar(quiet, "."), bar(changed, "#")),
        ]);
    }
    rows.to_string()
}

fn candidate_table(study: &WaypointStudy) -> String {
    let mut rows = table::table(&[
        "U_th",
        "alarms gone",
        "confirmed ones",
        "false ones",
        "quiet visits alarming",
        "",
    ]);
    // Those that differ from the next lower one in what they do, and those that were asked for.
    let mut before = None;
    for effect in &study.candidates {
        let does = (effect.gone, effect.alarming);
        let in_force = effect.u_th == study.u_th;
        let suggested = study.suggestion.u_th == Some(effect.u_th);
        let asked = study.looked_at == Some(effect.u_th);
        if before.replace(does) == Some(does) && !in_force && !suggested && !asked {
            continue;
        }
        let mut notes = Vec::new();
        for (is, note) in [
            (in_force, "in force"),
            (suggested, "suggested"),
            (asked && !suggested, "asked for"),
            (effect.never_alarms(), "never alarms"),
        ] {
            notes.extend(is.then_some(note));
        }
        rows.add_row([
            short(effect.u_th),
            effect.gone.all.to_string(),
            effect.gone.confirmed.to_string(),
            effect.gone.false_alarms.to_string(),
            effect.alarming.to_string(),
            notes.join(", "),
        ]);
    }
    rows.to_string()
}

/// Three digits.
fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{x:.digits$}");
    if digits == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_have_three_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.0005, "0.0005"),
            (0.000_123_456, "0.000123"),
            (1.0, "1"),
            (1234.0, "1234"),
            (1e-7, "0.0000001"),
        ] {
            assert_eq!(short(x), text);
        }
    }
}
