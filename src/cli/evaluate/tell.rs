//! The table for people, the lines of misses, the JSON.

use crate::cli::table;
use comfy_table::presets;
use patrold_engine::novelty::Kind;
use patrold_lab::evaluate::{Listed, Outcome, Rate, Row, summarise};
use serde::Serialize;

/// What the command tells.
#[derive(Debug, Serialize)]
pub struct Report {
    seed: u64,
    pairs: usize,
    seconds: f64,
    rows: Vec<Row>,
    misses: Vec<Miss>,
}

/// A pair judged wrongly: another verdict than the true one, or something false listed.
#[derive(Debug, Serialize)]
struct Miss {
    pair: String,
    change: String,
    place: &'static str,
    sensor: &'static str,
    pose_error: &'static str,
    engine: &'static str,
    view: &'static str,
    verdict: &'static str,
    reason: String,
    d_gmm: f64,
    unexplained: f64,
    share: f64,
    disagreement: f64,
    iou: Option<f64>,
    true_points: usize,
    seen_points: usize,
    beyond_points: usize,
    shift_error_m: f64,
    turn_error_deg: f64,
    unobservable: Vec<String>,
    novelties: Vec<MissNovelty>,
}

#[derive(Debug, Serialize)]
struct MissNovelty {
    kind: &'static str,
    points: usize,
    true_points: usize,
    support: f64,
    contribution: f64,
    centre: [f64; 3],
    extent: [f64; 3],
}

impl Report {
    /// The report of these outcomes.
    pub fn new(outcomes: &[Outcome], seed: u64, pairs: usize, seconds: f64) -> Self {
        let wrong = outcomes.iter().filter(|o| !o.good());
        Self {
            seed,
            pairs,
            seconds,
            rows: summarise(outcomes),
            misses: wrong.map(Miss::of).collect(),
        }
    }

    /// The tables, one for each way of judging.
    pub fn prose(&self, timed: bool) -> String {
        let mut parts = vec![format!(
            "{} pairs, seed {}, {:.0} s; rates in % with 95 % intervals (Wilson)",
            self.pairs, self.seed, self.seconds
        )];
        let way = |r: &Row| (r.set, r.engine, r.view, r.group);
        for rows in self.rows.chunk_by(|a, b| way(a) == way(b)) {
            if let Some(first) = rows.first() {
                let title = format!(
                    "{} {} pairs: {} engine, {}",
                    first.set.replace('_', " "),
                    first.group,
                    first.engine,
                    first.view
                );
                parts.push(format!("\n{title}\n{}", rates(rows, timed)));
            }
        }
        parts.join("\n")
    }

    /// One line for each miss.
    pub fn misses(&self) -> String {
        let lines: Vec<String> = self.misses.iter().map(|m| m.line(self.seed)).collect();
        lines.join("\n")
    }
}

fn rates(rows: &[Row], timed: bool) -> String {
    let quiet = rows.iter().all(|r| r.group == "quiet");
    let mut headings = vec![
        "pairs of",
        "n",
        if quiet { "false alarms" } else { "alarms" },
        "not observed",
    ];
    if !quiet {
        headings.extend(["found", "IoU", "IoU seen", "precision"]);
    }
    headings.extend(["shift p50/p95 cm", "turn p50/p95 deg", "unobs."]);
    if timed {
        headings.push("ms");
    }
    let mut table = table::table(&headings);
    table.load_style(presets::ASCII_MARKDOWN);
    for row in rows {
        let pair =
            |v: [Option<f64>; 2], scale: f64| v.map(|v| number(v.map(|v| v * scale))).join(" / ");
        let mut cells = vec![
            row.of.clone(),
            row.pairs.to_string(),
            percent(&row.changed),
            percent(&row.not_observed),
        ];
        if !quiet {
            cells.extend([
                row.found.as_ref().map_or("-".to_owned(), percent),
                number(row.iou),
                number(row.iou_seen),
                row.precision.as_ref().map_or("-".to_owned(), percent),
            ]);
        }
        cells.extend([
            pair(row.shift_error_m, 100.0),
            pair(row.turn_error_deg, 1.0),
            row.unobservable.to_string(),
        ]);
        if timed {
            cells.push(
                row.verdict_ms
                    .map_or("-".to_owned(), |ms| format!("{ms:.0}")),
            );
        }
        table.add_row(cells);
    }
    table.to_string()
}

fn percent(rate: &Rate) -> String {
    let p = |x: f64| x * 100.0;
    format!(
        "{}/{} {:.1} ({:.1}-{:.1})",
        rate.count,
        rate.of,
        p(rate.rate),
        p(rate.low),
        p(rate.high)
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |v| format!("{v:.2}"))
}

impl Miss {
    fn of(outcome: &Outcome) -> Self {
        Self {
            pair: outcome.planned.name(),
            change: outcome.told.clone(),
            place: outcome.planned.place.word(),
            sensor: outcome.planned.sensor.word(),
            pose_error: outcome.planned.pose.word(),
            engine: outcome.engine.word(),
            view: outcome.given.word(),
            verdict: outcome.verdict.word(),
            reason: outcome.reason.clone(),
            d_gmm: outcome.d_gmm,
            unexplained: outcome.unexplained,
            share: outcome.share,
            disagreement: outcome.disagreement,
            iou: outcome.iou,
            true_points: outcome.true_points,
            seen_points: outcome.seen_points,
            beyond_points: outcome.beyond_points,
            shift_error_m: outcome.shift_error_m,
            turn_error_deg: outcome.turn_error_deg,
            unobservable: outcome.unobservable.clone(),
            novelties: outcome.listed.iter().map(MissNovelty::of).collect(),
        }
    }

    fn line(&self, seed: u64) -> String {
        let novelties: Vec<String> = self.novelties.iter().map(MissNovelty::words).collect();
        format!(
            "--seed {seed} --pair {} --view {} --engine {}: {} in {}, {}, pose {}: {} ({}); d {:.5}, unexplained {:.5}, \
             share {:.2}, disagreement {:.2}, off {:.1} cm {:.2} deg{}, IoU {}, true points {} ({} seen, {} before nothing and out of its proof); {}",
            self.pair,
            self.view,
            self.engine,
            self.change,
            self.place,
            self.sensor,
            self.pose_error,
            self.verdict,
            self.reason,
            self.d_gmm,
            self.unexplained,
            self.share,
            self.disagreement,
            100.0 * self.shift_error_m,
            self.turn_error_deg,
            if self.unobservable.is_empty() {
                ""
            } else {
                " (but for what is unobservable)"
            },
            number(self.iou),
            self.true_points,
            self.seen_points,
            self.beyond_points,
            if novelties.is_empty() {
                "nothing listed".to_owned()
            } else {
                novelties.join("; ")
            }
        )
    }
}

impl MissNovelty {
    fn of(listed: &Listed) -> Self {
        Self {
            kind: match listed.kind {
                Kind::Appeared => "appeared",
                Kind::Disappeared => "disappeared",
            },
            points: listed.points,
            true_points: listed.true_points,
            support: listed.support,
            contribution: listed.contribution,
            centre: listed.centre,
            extent: listed.extent,
        }
    }

    fn words(&self) -> String {
        format!(
            "{} {} points ({} true) support {:.0} at {} size {}",
            self.kind,
            self.points,
            self.true_points,
            self.support,
            table::place(self.centre),
            table::place(self.extent)
        )
    }
}
