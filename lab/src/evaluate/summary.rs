//! Rows of rates from outcomes.

use super::changes::Change;
use super::constants::LEAST_POINTS;
use super::judge::{Engine, Given};
use super::places::Kind;
use super::plan::{PoseError, Set};
use super::rates::{Rate, mean, quantile};
use super::score::{Listed, Outcome};
use super::sensor::Sensor;
use patrold_engine::novelty::Verdict;
use serde::Serialize;

/// The rates of one group of pairs, judged in one way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `tuned`, or what is held out: `held_out_places`, `held_out_sensor`.
    pub set: &'static str,
    /// Judged by which engine.
    pub engine: &'static str,
    /// Points alone (`bare`) or a sweep of our own (`sweep`).
    pub view: &'static str,
    /// Which pairs: `quiet`, `large`, `balls`.
    pub group: &'static str,
    /// Which of them: by what, and its value.
    pub of: String,
    /// How many.
    pub pairs: usize,
    /// Verdict `changed`.
    pub changed: Rate,
    /// Verdict `not_observed`.
    pub not_observed: Rate,
    /// Verdict `changed` and at least one listed novelty right. Null of quiet pairs.
    pub found: Option<Rate>,
    /// Mean intersection over union of listed and true points. Null of quiet pairs.
    pub iou: Option<f64>,
    /// The same over what both visits could see.
    pub iou_seen: Option<f64>,
    /// Listed novelties of which at least half the points truly came or went. Null where none is listed.
    pub precision: Option<Rate>,
    /// Median and 95 % of the registration's error, metres.
    pub shift_error_m: [Option<f64>; 2],
    /// Median and 95 % of the registration's error, degrees.
    pub turn_error_deg: [Option<f64>; 2],
    /// Pairs whose registration told a direction as unobservable.
    pub unobservable: usize,
    /// Median time from view to verdict, milliseconds: of the clock, so of use with one thread alone.
    pub verdict_ms: Option<f64>,
}

/// Every row that has pairs.
pub fn summarise(outcomes: &[Outcome]) -> Vec<Row> {
    let mut rows = Vec::new();
    for set in Set::ALL {
        for engine in [Engine::Standard, Engine::Paper] {
            for given in [Given::Bare, Given::Sweep] {
                let own: Vec<&Outcome> = outcomes
                    .iter()
                    .filter(|o| (o.planned.set, o.engine, o.given) == (set, engine, given))
                    .collect();
                rows.extend(of_way(&own));
            }
        }
    }
    rows
}

fn of_way(own: &[&Outcome]) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |group: &'static str, of: String, holds: &dyn Fn(&Outcome) -> bool| {
        let chosen: Vec<&Outcome> = own
            .iter()
            .copied()
            .filter(|o| group_of(o.planned.change) == group && holds(o))
            .collect();
        rows.extend(row(group, of, &chosen));
    };
    for group in ["quiet", "large", "balls"] {
        add(group, "all".to_owned(), &|_| true);
        if group != "quiet" {
            for change in Change::LARGE.into_iter().chain(Change::BALLS) {
                add(group, change.word().to_owned(), &|o| {
                    o.planned.change == change
                });
            }
        }
        if group == "large" {
            // What shows before nothing alone, too far off for that to prove anything, may honestly be missed.
            let least = LEAST_POINTS;
            add(group, format!("seen by {least} points and more"), &|o| {
                o.seen_points >= least
            });
            add(group, format!("seen by fewer than {least}"), &|o| {
                o.seen_points < least
            });
        }
        for pose in PoseError::ALL {
            add(group, format!("pose {}", pose.word()), &|o| {
                o.planned.pose == pose
            });
        }
        for sensor in Sensor::all() {
            add(group, format!("sensor {}", sensor.word()), &|o| {
                o.planned.sensor == sensor
            });
        }
        for kind in Kind::all() {
            add(group, format!("place {}", kind.word()), &|o| {
                o.planned.place == kind
            });
        }
    }
    rows
}

fn group_of(change: Change) -> &'static str {
    match change {
        Change::Quiet => "quiet",
        c if c.ball().is_some() => "balls",
        _ => "large",
    }
}

fn row(group: &'static str, of: String, chosen: &[&Outcome]) -> Option<Row> {
    let first = chosen.first()?;
    let n = chosen.len();
    let count =
        |holds: &dyn Fn(&Outcome) -> bool| Rate::new(chosen.iter().filter(|o| holds(o)).count(), n);
    let verdict = |v: Verdict| count(&|o| o.verdict == v);
    let listed: Vec<&Listed> = chosen.iter().flat_map(|o| &o.listed).collect();
    let right = listed.iter().filter(|l| l.right()).count();
    let both = |value: &dyn Fn(&Outcome) -> f64| {
        [0.5, 0.95].map(|share| quantile(chosen.iter().map(|o| value(o)), share))
    };
    Some(Row {
        set: first.planned.set.word(),
        engine: first.engine.word(),
        view: first.given.word(),
        group,
        of,
        pairs: n,
        changed: verdict(Verdict::Changed),
        not_observed: verdict(Verdict::NotObserved),
        found: (group != "quiet").then(|| {
            count(&|o| o.verdict == Verdict::Changed && o.listed.iter().any(Listed::right))
        }),
        iou: mean(chosen.iter().filter_map(|o| o.iou)),
        iou_seen: mean(chosen.iter().filter_map(|o| o.iou_seen)),
        precision: (!listed.is_empty()).then(|| Rate::new(right, listed.len())),
        shift_error_m: both(&|o| o.shift_error_m),
        turn_error_deg: both(&|o| o.turn_error_deg),
        unobservable: chosen.iter().filter(|o| !o.unobservable.is_empty()).count(),
        verdict_ms: quantile(chosen.iter().map(|o| o.verdict_ms), 0.5),
    })
}
