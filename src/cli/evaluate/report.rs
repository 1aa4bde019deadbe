//! The report: tables, lines of misses, JSON.

use crate::cli::experiment::{markdown_table, number};
use crate::cli::table;
use patrold_lab::Rate;
use patrold_lab::evaluate::{ListedNovelty, PairScore, RateRow, rate_rows};
use serde::Serialize;

/// The report.
#[derive(Debug, Serialize)]
pub(super) struct EvaluateReport {
    seed: u64,
    pairs: usize,
    seconds: f64,
    rows: Vec<RateRow>,
    misses: Vec<PairMiss>,
}

/// A pair judged wrongly: a wrong verdict, or a false novelty.
#[derive(Debug, Serialize)]
struct PairMiss {
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
    novelties: Vec<MissedPairNovelty>,
}

#[derive(Debug, Serialize)]
struct MissedPairNovelty {
    kind: &'static str,
    points: usize,
    true_points: usize,
    support: f64,
    contribution: f64,
    centre: [f64; 3],
    extent: [f64; 3],
}

impl EvaluateReport {
    /// The report of these scores.
    pub(super) fn new(scores: &[PairScore], seed: u64, pairs: usize, seconds: f64) -> Self {
        let wrong = scores.iter().filter(|s| !s.is_correct());
        Self {
            seed,
            pairs,
            seconds,
            rows: rate_rows(scores),
            misses: wrong.map(PairMiss::new).collect(),
        }
    }

    /// The tables, one for each engine and input.
    pub(super) fn tables(&self, timed: bool) -> String {
        let mut parts = vec![format!(
            "{} pairs, seed {}, {:.0} s; rates in % with 95 % intervals (Wilson)",
            self.pairs, self.seed, self.seconds
        )];
        let table = |r: &RateRow| (r.set, r.engine, r.view, r.group);
        for rows in self.rows.chunk_by(|a, b| table(a) == table(b)) {
            if let Some(first) = rows.first() {
                let title = format!(
                    "{} {} pairs: {} engine, {}",
                    first.set.replace('_', " "),
                    first.group,
                    first.engine,
                    first.view
                );
                parts.push(format!("\n{title}\n{}", rate_table(rows, timed)));
            }
        }
        parts.join("\n")
    }

    /// One line for each miss.
    pub(super) fn misses(&self) -> String {
        let lines: Vec<String> = self.misses.iter().map(|m| m.line(self.seed)).collect();
        lines.join("\n")
    }
}

fn rate_table(rows: &[RateRow], timed: bool) -> String {
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
    let mut table = markdown_table(&headings);
    for row in rows {
        let pair = |v: [Option<f64>; 2], scale: f64| {
            v.map(|v| number(v.map(|v| v * scale), 2)).join(" / ")
        };
        let mut cells = vec![
            row.of.clone(),
            row.pairs.to_string(),
            percent(&row.changed),
            percent(&row.not_observed),
        ];
        if !quiet {
            cells.extend([
                row.found.as_ref().map_or("-".to_owned(), percent),
                number(row.iou, 2),
                number(row.iou_seen, 2),
                row.precision.as_ref().map_or("-".to_owned(), percent),
            ]);
        }
        cells.extend([
            pair(row.shift_error_m, 100.0),
            pair(row.turn_error_deg, 1.0),
            row.unobservable.to_string(),
        ]);
        if timed {
            cells.push(number(row.verdict_ms, 0));
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

impl PairMiss {
    fn new(score: &PairScore) -> Self {
        Self {
            pair: score.plan.name(),
            change: score.change_description.clone(),
            place: score.plan.place.as_str(),
            sensor: score.plan.sensor.as_str(),
            pose_error: score.plan.pose_error.as_str(),
            engine: score.engine.as_str(),
            view: score.input.as_str(),
            verdict: score.verdict.as_str(),
            reason: score.reason.clone(),
            d_gmm: score.d_gmm,
            unexplained: score.unexplained,
            share: score.share,
            disagreement: score.disagreement,
            iou: score.iou,
            true_points: score.true_points,
            seen_points: score.seen_points,
            beyond_points: score.beyond_points,
            shift_error_m: score.shift_error_m,
            turn_error_deg: score.turn_error_deg,
            unobservable: score.unobservable.clone(),
            novelties: score.listed.iter().map(MissedPairNovelty::new).collect(),
        }
    }

    fn line(&self, seed: u64) -> String {
        let novelties: Vec<String> = self.novelties.iter().map(MissedPairNovelty::text).collect();
        format!(
            "--seed {seed} --pair {} --view {} --engine {}: {} in {}, {}, pose {}: {} ({}); d {:.5}, unexplained {:.5}, \
             share {:.2}, disagreement {:.2}, off {:.1} cm {:.2} deg{}, IoU {}, true points {} ({} seen, {} beyond the free range); {}",
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
                " (observable directions alone)"
            },
            number(self.iou, 2),
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

impl MissedPairNovelty {
    fn new(listed: &ListedNovelty) -> Self {
        Self {
            kind: listed.kind.as_str(),
            points: listed.points,
            true_points: listed.true_points,
            support: listed.support,
            contribution: listed.contribution,
            centre: listed.centre,
            extent: listed.extent,
        }
    }

    fn text(&self) -> String {
        format!(
            "{} {} points ({} true) support {:.0} at {} size {}",
            self.kind,
            self.points,
            self.true_points,
            self.support,
            table::format_point(self.centre),
            table::format_point(self.extent)
        )
    }
}
