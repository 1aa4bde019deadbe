//! The report: tables, lines of misses, JSON.

use super::miss::PairMiss;
use crate::cli::experiment::{markdown_table, number};
use patrold_lab::Rate;
use patrold_lab::evaluate::{PairScore, RateRow, SeparationRow, rate_rows, separation_rows};
use serde::Serialize;

/// The report.
#[derive(Debug, Serialize)]
pub(super) struct EvaluateReport {
    #[serde(flatten)]
    head: EvaluateHead,
    rows: Vec<RateRow>,
    separation: Vec<SeparationRow>,
    misses: Vec<PairMiss>,
}

/// What was run.
#[derive(Debug, Serialize)]
pub(super) struct EvaluateHead {
    /// Seed of the pairs.
    pub seed: u64,
    /// Number of pairs.
    pub pairs: usize,
    /// What was kept of the references: `view` (and mixture) or `mixture`.
    pub reference: &'static str,
    /// Quiet visits to the place of each pair that its U_th comes from; `None`: U_th is the engine's own.
    pub quiet_visits: Option<u32>,
    /// The pose error of all pairs; `None`: each pair has that of its plan.
    pub pose_error: Option<String>,
    /// Duration of the run.
    pub seconds: f64,
}

impl EvaluateReport {
    /// The report of these scores.
    pub(super) fn new(head: EvaluateHead, scores: &[PairScore]) -> Self {
        let wrong = scores.iter().filter(|s| !s.is_correct());
        Self {
            head,
            rows: rate_rows(scores),
            separation: separation_rows(scores),
            misses: wrong.map(PairMiss::new).collect(),
        }
    }

    /// The tables, one for each engine and input.
    pub(super) fn tables(&self, timed: bool) -> String {
        let EvaluateHead {
            seed,
            pairs,
            reference,
            quiet_visits,
            seconds,
            ..
        } = &self.head;
        let u_th = match quiet_visits {
            Some(n) => format!("U_th from {n} quiet visits to the place of each pair"),
            None => "U_th of the engine".to_owned(),
        };
        let mut parts = vec![format!(
            "{pairs} pairs, seed {seed}, {seconds:.0} s, reference kept as {reference}, {u_th}; rates in % with 95 % intervals (Wilson)"
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
        let table = |r: &SeparationRow| (r.set, r.engine, r.view, r.group);
        for rows in self.separation.chunk_by(|a, b| table(a) == table(b)) {
            if let Some(first) = rows.first() {
                let title = format!(
                    "{} d_GMM of quiet and {} pairs: {} engine, {}",
                    first.set.replace('_', " "),
                    first.group,
                    first.engine,
                    first.view
                );
                parts.push(format!("\n{title}\n{}", separation_table(rows)));
            }
        }
        parts.join("\n")
    }

    /// One line for each miss.
    pub(super) fn misses(&self) -> String {
        let EvaluateHead {
            seed,
            quiet_visits,
            pose_error,
            ..
        } = &self.head;
        let u_th = quiet_visits.map_or(String::new(), |n| {
            format!(" --u-th quiet --quiet-visits {n}")
        });
        let pose = pose_error
            .as_ref()
            .map_or(String::new(), |class| format!(" --pose-error {class}"));
        let run = format!("--seed {seed}{u_th}{pose}");
        let lines: Vec<String> = self.misses.iter().map(|m| m.line(&run)).collect();
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
    headings.extend([
        "shift p50/p95 cm",
        "turn p50/p95 deg",
        "within",
        "agrees min/p25",
        "unobs.",
        "kB mixture / view",
    ]);
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
            format!("{:.2}", row.pose_within.rate),
            pair(row.share_by_direction, 1.0),
            row.unobservable.to_string(),
            row.stored_bytes
                .map(|b| format!("{:.1}", b / 1e3))
                .join(" / "),
        ]);
        if timed {
            cells.push(number(row.verdict_ms, 0));
        }
        table.add_row(cells);
    }
    table.to_string()
}

fn separation_table(rows: &[SeparationRow]) -> String {
    let mut table = markdown_table(&[
        "pairs of",
        "quiet",
        "changed",
        "AUC of d",
        "AUC of d / U_th",
        "false alarms",
        "found",
        "IoU",
        "U_th min/p50/max",
        "visits not observed",
    ]);
    for row in rows {
        table.add_row([
            row.of.clone(),
            row.quiet.to_string(),
            row.changed.to_string(),
            number(Some(row.auc), 3),
            number(Some(row.auc_of_ratio), 3),
            percent(&row.alarmed),
            percent(&row.found),
            number(row.iou, 2),
            row.u_th.map(|u| format!("{u:.5}")).join(" / "),
            row.unobserved_visits.to_string(),
        ]);
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
