//! How well d_GMM separates quiet pairs from changed ones, over all and for each kind of place.

use super::places::PlaceKind;
use super::plan::PairSet;
use super::rate_rows::group_of;
use super::run_engine::EngineInput;
use super::score::PairScore;
use crate::statistics::{Rate, area_under_curve, mean, quantile};
use patrold_engine::inspect::Engine;
use patrold_engine::novelty::Verdict;
use serde::Serialize;

/// Quiet pairs against changed ones of one set, engine and input.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SeparationRow {
    /// `tuned`, `held_out_places` or `held_out_sensor`.
    pub set: &'static str,
    /// Name of the engine.
    pub engine: &'static str,
    /// What the engine got: points alone (`bare`) or a whole sweep (`sweep`).
    pub view: &'static str,
    /// The changed pairs: `large` or `balls`.
    pub group: &'static str,
    /// `all`, or a kind of place.
    pub of: String,
    /// Number of quiet pairs.
    pub quiet: usize,
    /// Number of changed pairs.
    pub changed: usize,
    /// Area under the curve of d_GMM: how often a changed pair has more than a quiet one.
    pub auc: f64,
    /// The same of d_GMM over U_th, which differs where each place has its own.
    pub auc_of_ratio: f64,
    /// Quiet pairs with the verdict `changed`.
    pub alarmed: Rate,
    /// Changed pairs with the verdict `changed` and at least one correct novelty.
    pub found: Rate,
    /// Mean intersection over union of listed and true points of the changed pairs.
    pub iou: Option<f64>,
    /// Least, median and greatest U_th of both, unit of the ground distance.
    pub u_th: [f64; 3],
    /// Quiet visits to their places that were not observed, in all.
    pub unobserved_visits: usize,
}

/// The rows of all groups that have quiet and changed pairs.
pub fn separation_rows(scores: &[PairScore]) -> Vec<SeparationRow> {
    let mut rows = Vec::new();
    for set in PairSet::ALL {
        for engine in Engine::ALL {
            for input in [EngineInput::Bare, EngineInput::Sweep] {
                let own: Vec<&PairScore> = scores
                    .iter()
                    .filter(|s| (s.plan.set, s.engine, s.input) == (set, engine, input))
                    .collect();
                for group in ["large", "balls"] {
                    rows.extend(row(group, None, &own));
                    rows.extend(PlaceKind::all().filter_map(|kind| row(group, Some(kind), &own)));
                }
            }
        }
    }
    rows
}

/// The row of the pairs in this kind of place, or in all; `None` without quiet or without changed pairs.
fn row(group: &'static str, place: Option<PlaceKind>, own: &[&PairScore]) -> Option<SeparationRow> {
    let of_group = |group: &str| -> Vec<&PairScore> {
        let fits = |s: &&&PairScore| {
            group_of(s.plan.change) == group && place.is_none_or(|kind| s.plan.place == kind)
        };
        own.iter().filter(fits).copied().collect()
    };
    let (quiet, changed) = (of_group("quiet"), of_group(group));
    let first = quiet.first()?;
    let area = |value: fn(&PairScore) -> f64| {
        let values = |of: &[&PairScore]| of.iter().map(|s| value(s)).collect::<Vec<_>>();
        area_under_curve(&values(&quiet), &values(&changed))
    };
    let alarmed = quiet.iter().filter(|s| s.verdict == Verdict::Changed);
    let found = changed.iter().filter(|s| s.is_found());
    let both = || quiet.iter().chain(&changed);
    let [least, median, greatest] =
        [0.0, 0.5, 1.0].map(|share| quantile(both().map(|s| s.u_th), share));
    Some(SeparationRow {
        set: first.plan.set.as_str(),
        engine: first.engine.as_str(),
        view: first.input.as_str(),
        group,
        of: place.map_or("all".to_owned(), |kind| format!("place {}", kind.as_str())),
        auc: area(|s| s.d_gmm)?,
        auc_of_ratio: area(|s| s.d_gmm / s.u_th)?,
        alarmed: Rate::new(alarmed.count(), quiet.len()),
        found: Rate::new(found.count(), changed.len()),
        iou: mean(changed.iter().filter_map(|s| s.iou)),
        u_th: [least?, median?, greatest?],
        unobserved_visits: both().map(|s| s.unobserved_visits).sum(),
        quiet: quiet.len(),
        changed: changed.len(),
    })
}
