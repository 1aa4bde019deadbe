//! Rates of groups of pairs.

use super::changes::ChangeClass;
use super::constants::{MIN_VISIBLE_POINTS, POSE_CHI2_95};
use super::places::PlaceKind;
use super::plan::{PairSet, PoseErrorClass};
use super::run_engine::EngineInput;
use super::score::{ListedNovelty, PairScore};
use super::sensor::SensorKind;
use crate::statistics::{Rate, mean, median, quantile};
use patrold_engine::inspect::Engine;
use patrold_engine::novelty::Verdict;
use serde::Serialize;

/// The rates of one group of pairs with one engine and input.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RateRow {
    /// `tuned`, `held_out_places` or `held_out_sensor`.
    pub set: &'static str,
    /// Name of the engine.
    pub engine: &'static str,
    /// What the engine got: points alone (`bare`) or a whole sweep (`sweep`).
    pub view: &'static str,
    /// `quiet`, `large` or `balls`.
    pub group: &'static str,
    /// Subgroup: `all`, or a property and its value.
    pub of: String,
    /// Number of pairs.
    pub pairs: usize,
    /// Verdict `changed`.
    pub changed: Rate,
    /// Verdict `not_observed`.
    pub not_observed: Rate,
    /// Verdict `changed` with at least one correct novelty; null of quiet pairs.
    pub found: Option<Rate>,
    /// Mean intersection over union of listed and true points; null of quiet pairs.
    pub iou: Option<f64>,
    /// The same over what both visits could see.
    pub iou_seen: Option<f64>,
    /// Listed novelties that are correct; null where none is listed.
    pub precision: Option<Rate>,
    /// Median and 95th percentile of the registration error, metres.
    pub shift_error_m: [Option<f64>; 2],
    /// Median and 95th percentile of the registration error, degrees.
    pub turn_error_deg: [Option<f64>; 2],
    /// Pairs whose pose lies within the covariance that the registration states, at 95 %.
    pub pose_within: Rate,
    /// Least and lower quartile of the share of the surface that agrees, where every direction counts alike.
    pub share_by_direction: [Option<f64>; 2],
    /// Pairs with an unobservable direction in the registration.
    pub unobservable: usize,
    /// Median time from the current view to the verdict, milliseconds; meaningful with one thread only.
    pub verdict_ms: Option<f64>,
    /// Mean bytes of the reference as the store keeps it: its mixture, and its view.
    pub stored_bytes: [f64; 2],
}

/// The rows of all groups that have pairs.
pub fn rate_rows(scores: &[PairScore]) -> Vec<RateRow> {
    let mut rows = Vec::new();
    for set in PairSet::ALL {
        for engine in Engine::ALL {
            for input in [EngineInput::Bare, EngineInput::Sweep] {
                let own: Vec<&PairScore> = scores
                    .iter()
                    .filter(|s| (s.plan.set, s.engine, s.input) == (set, engine, input))
                    .collect();
                rows.extend(rows_of_run(&own));
            }
        }
    }
    rows
}

/// The rows of one set, engine and input.
fn rows_of_run(own: &[&PairScore]) -> Vec<RateRow> {
    let mut rows = Vec::new();
    let mut add = |group: &'static str, of: String, included: &dyn Fn(&PairScore) -> bool| {
        let chosen: Vec<&PairScore> = own
            .iter()
            .copied()
            .filter(|s| group_of(s.plan.change) == group && included(s))
            .collect();
        rows.extend(row(group, of, &chosen));
    };
    for group in ["quiet", "large", "balls"] {
        add(group, "all".to_owned(), &|_| true);
        if group != "quiet" {
            for change in ChangeClass::LARGE.into_iter().chain(ChangeClass::BALLS) {
                add(group, change.as_str().to_owned(), &|s| {
                    s.plan.change == change
                });
            }
        }
        if group == "large" {
            // What is visible only against no return, beyond the range up to which this proves free space, may be missed.
            let min = MIN_VISIBLE_POINTS;
            add(group, format!("seen by {min} points and more"), &|s| {
                s.seen_points >= min
            });
            add(group, format!("seen by fewer than {min}"), &|s| {
                s.seen_points < min
            });
        }
        for pose in PoseErrorClass::ALL {
            add(group, format!("pose {}", pose.as_str()), &|s| {
                s.plan.pose_error == pose
            });
        }
        for sensor in SensorKind::all() {
            add(group, format!("sensor {}", sensor.as_str()), &|s| {
                s.plan.sensor == sensor
            });
        }
        for kind in PlaceKind::all() {
            add(group, format!("place {}", kind.as_str()), &|s| {
                s.plan.place == kind
            });
        }
    }
    rows
}

pub(super) fn group_of(change: ChangeClass) -> &'static str {
    match change {
        ChangeClass::Quiet => "quiet",
        c if c.ball().is_some() => "balls",
        _ => "large",
    }
}

fn row(group: &'static str, of: String, chosen: &[&PairScore]) -> Option<RateRow> {
    let first = chosen.first()?;
    let pairs = chosen.len();
    let rate = |included: &dyn Fn(&PairScore) -> bool| {
        Rate::new(chosen.iter().filter(|s| included(s)).count(), pairs)
    };
    let verdict = |v: Verdict| rate(&|s| s.verdict == v);
    let listed: Vec<&ListedNovelty> = chosen.iter().flat_map(|s| &s.listed).collect();
    let correct = listed.iter().filter(|l| l.is_correct()).count();
    let median_and_95 = |value: &dyn Fn(&PairScore) -> f64| {
        [0.5, 0.95].map(|share| quantile(chosen.iter().map(|s| value(s)), share))
    };
    Some(RateRow {
        set: first.plan.set.as_str(),
        engine: first.engine.as_str(),
        view: first.input.as_str(),
        group,
        of,
        pairs,
        changed: verdict(Verdict::Changed),
        not_observed: verdict(Verdict::NotObserved),
        found: (group != "quiet").then(|| rate(&PairScore::is_found)),
        iou: mean(chosen.iter().filter_map(|s| s.iou)),
        iou_seen: mean(chosen.iter().filter_map(|s| s.iou_seen)),
        precision: (!listed.is_empty()).then(|| Rate::new(correct, listed.len())),
        shift_error_m: median_and_95(&|s| s.shift_error_m),
        turn_error_deg: median_and_95(&|s| s.turn_error_deg),
        pose_within: rate(&|s| s.pose_chi2 <= POSE_CHI2_95),
        share_by_direction: [0.0, 0.25]
            .map(|share| quantile(chosen.iter().map(|s| s.share_by_direction), share)),
        unobservable: chosen.iter().filter(|s| !s.unobservable.is_empty()).count(),
        verdict_ms: median(chosen.iter().map(|s| s.verdict_ms)),
        stored_bytes: [0, 1].map(|part| {
            mean(chosen.iter().map(|s| s.stored_bytes[part] as f64)).unwrap_or_default()
        }),
    })
}
