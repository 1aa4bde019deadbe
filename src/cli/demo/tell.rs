//! What the demo tells in the end: the alarm log, and each truth with what was told of it.

use super::building::Place;
use super::rounds::Rounds;
use super::truth::{self, Told};
use crate::cli::failure::Failure;
use crate::cli::{alarm_report, table};
use crate::service::replies::VisitReply;
use crate::store::{AlarmFilter, AlarmRow, Store};
use patrold_engine::report::NoveltyRecord;
use serde_json::json;
use std::path::Path;

/// One place held against the truth.
struct PlaceJudged {
    waypoint: &'static str,
    told: Vec<Told>,
    /// Novelties that tell of nothing true.
    stray: Vec<NoveltyRecord>,
    alarmed: bool,
}

/// The whole demo held against the truth.
pub struct Judged {
    places: Vec<PlaceJudged>,
    quiet: Vec<VisitReply>,
    alarms: Vec<AlarmRow>,
}

/// Reads the alarm log and holds it against the truth of the changed round.
///
/// # Errors
/// The log does not read.
pub fn judge(places: &[Place], rounds: Rounds, state: &Path) -> Result<Judged, Failure> {
    let log = Store::open_for_reading(state)?.alarms(&AlarmFilter::default())?;
    let mut judged = Vec::new();
    for place in places {
        let raised: Vec<&AlarmRow> = log
            .iter()
            .filter(|a| a.waypoint == place.waypoint)
            .collect();
        let told: Vec<NoveltyRecord> = raised.iter().flat_map(|a| a.novelties.clone()).collect();
        let (told, stray) = truth::judge(truth::of(place)?, &told);
        judged.push(PlaceJudged {
            waypoint: place.waypoint,
            told,
            stray,
            alarmed: raised.len() == 1,
        });
    }
    Ok(Judged {
        places: judged,
        quiet: rounds.quiet,
        alarms: log,
    })
}

impl Judged {
    /// Whether every quiet visit was quiet, every change is one alarm, every true thing was told with a sane shape,
    /// and nothing else.
    pub fn exactly_the_truth(&self) -> bool {
        let whole = |place: &PlaceJudged| {
            place.alarmed
                && place.stray.is_empty()
                && place
                    .told
                    .iter()
                    .all(|t| t.novelty.is_some() && t.sane_shape)
        };
        self.quiet.iter().all(|v| v.verdict == "quiet") && self.places.iter().all(whole)
    }

    /// For people.
    pub fn prose(&self) -> String {
        let mut rows = table::table(&["waypoint", "truth", "told", "off (m)", "shape (m)", ""]);
        for place in &self.places {
            for told in &place.told {
                rows.add_row(cells(place.waypoint, told));
            }
            for stray in &place.stray {
                let told = format!("{} at {}", stray.kind, table::place(stray.centre));
                rows.add_row([place.waypoint, "nothing", &told, "", "", "FALSE"]);
            }
        }
        let verdict = if self.exactly_the_truth() {
            "exactly the true changes were alarmed"
        } else {
            "the alarms are NOT exactly the true changes"
        };
        format!(
            "\nalarm log\n{}\n\nagainst the truth\n{rows}\n\n{verdict}",
            alarm_report::alarm_table(&self.alarms)
        )
    }

    /// For programs.
    pub fn report(&self, seed: u64, time_scale: f64) -> serde_json::Value {
        let places: Vec<_> = self
            .places
            .iter()
            .map(|p| json!({"waypoint": p.waypoint, "alarmed": p.alarmed, "told": p.told, "stray": p.stray}))
            .collect();
        let quiet: Vec<_> = self
            .quiet
            .iter()
            .map(|v| json!({"waypoint": v.waypoint, "verdict": v.verdict, "reason": v.reason, "d_gmm": v.d_gmm}))
            .collect();
        json!({
            "correct": self.exactly_the_truth(),
            "seed": seed,
            "time_scale": time_scale,
            "quiet": quiet,
            "changed": places,
            "alarms": self.alarms,
        })
    }
}

fn cells(waypoint: &str, told: &Told) -> [String; 6] {
    let shape = told.novelty.as_ref().and_then(|n| n.shape.as_ref());
    [
        waypoint.to_owned(),
        format!("{} {}", told.truth.name, told.truth.kind),
        told.novelty
            .as_ref()
            .map_or_else(|| "not told".to_owned(), |n| n.kind.clone()),
        told.off_m
            .map_or_else(String::new, |off| format!("{off:.2}")),
        shape.map_or_else(String::new, |s| {
            format!("{} {}", s.class, table::place(s.size))
        }),
        if told.novelty.is_some() && told.sane_shape {
            "ok"
        } else {
            "MISSED"
        }
        .to_owned(),
    ]
}
