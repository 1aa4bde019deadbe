//! Pairs judged wrongly, as JSON and as lines for people.

use crate::cli::experiment::number;
use crate::cli::table;
use patrold_lab::evaluate::{ListedNovelty, PairScore};
use serde::Serialize;

/// A pair judged wrongly: a wrong verdict, or a false novelty.
#[derive(Debug, Serialize)]
pub(super) struct PairMiss {
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
    u_th: f64,
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

impl PairMiss {
    pub(super) fn new(score: &PairScore) -> Self {
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
            u_th: score.u_th,
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

    /// For people, with what runs it again after the options `run`.
    pub(super) fn line(&self, run: &str) -> String {
        let novelties: Vec<String> = self.novelties.iter().map(MissedPairNovelty::text).collect();
        format!(
            "{run} --pair {} --view {} --engine {}: {} in {}, {}, pose {}: {} ({}); d {:.5} of U_th {:.5}, unexplained {:.5}, \
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
            self.u_th,
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
