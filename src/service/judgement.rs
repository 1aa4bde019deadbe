//! Judges a sweep: from its raw data to a verdict, a reference or points. Runs on the blocking pool.

use crate::config::Settings;
use crate::patrol::event::PatrolTask;
use crate::store::StoredReference;
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::View;
use patrold_engine::inspect::{inspect, prepare};
use patrold_engine::lost_steps::{LostStepThresholds, Mismatch, find_mismatch};
use patrold_engine::mixture::Mixture;
use patrold_engine::novelty::{Reference, Verdict};
use patrold_engine::report::{InspectionReport, NoveltyRecord};
use patrold_engine::sweep::{RawSweep, Sweep, SweepQuality, assemble, encode_raw_sweep};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::task::JoinError;

/// Each takes some tens of megabytes.
const MAX_CACHED_REFERENCES: usize = 8;

#[derive(Debug)]
pub(super) struct AssembledSweep {
    pub(super) view: View,
    /// Encoded raw data.
    pub(super) raw: Vec<u8>,
    pub(super) quality: SweepQuality,
}

/// One variant per [`PatrolTask`].
#[derive(Debug)]
pub(super) enum SweepFinding {
    Visit(Box<VisitFinding>),
    Reference(Mixture),
    /// The points as PLY; `fault` is why a visit would not judge them.
    Points {
        ply: Vec<u8>,
        fault: Option<String>,
    },
}

#[derive(Debug)]
pub(super) struct VisitFinding {
    pub(super) verdict: Verdict,
    /// Its novelties are in the reference's frame.
    pub(super) report: InspectionReport,
}

#[derive(Debug)]
pub(super) struct SweepJudgement {
    /// `None` where the raw data gives no sweep.
    pub(super) assembled: Option<AssembledSweep>,
    /// Encoded raw data that gave no sweep.
    pub(super) unassembled_raw: Option<Vec<u8>>,
    pub(super) finding: Result<SweepFinding, String>,
    /// Why the head is to be homed and the place swept again before there is a finding.
    pub(super) suspected_lost_steps: Option<String>,
}

impl SweepJudgement {
    /// Judging that panicked or was cancelled.
    pub(super) fn from_join_error(error: JoinError) -> Self {
        let message = match error.try_into_panic() {
            Ok(panic) => match panic.downcast::<String>() {
                Ok(text) => *text,
                Err(panic) => panic.downcast::<&str>().map_or_else(
                    |_| "panic without a message".to_owned(),
                    |text| (*text).to_owned(),
                ),
            },
            Err(cancelled) => cancelled.to_string(),
        };
        Self {
            assembled: None,
            unassembled_raw: None,
            finding: Err(format!("the engine failed: {}", message.replace('\n', " "))),
            suspected_lost_steps: None,
        }
    }
}

/// Prepared references, newest last; shared by all visits under the same settings.
#[derive(Debug, Clone, Default)]
pub(super) struct ReferenceCache(Arc<Mutex<VecDeque<CachedReference>>>);

/// Sequence number in the store, and the reference.
type CachedReference = (i64, Arc<Reference>);

impl ReferenceCache {
    fn get(&self, stored: &StoredReference, settings: &Settings) -> Result<Arc<Reference>, String> {
        let hit = {
            let cached = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let entry = cached.iter().find(|(id, _)| *id == stored.id);
            entry.map(|(_, reference)| Arc::clone(reference))
        };
        if let Some(reference) = hit {
            return Ok(reference);
        }
        let reference = prepare(
            &stored.view,
            &settings.engine_settings(None),
            settings.mixture.seed,
        )
        .map_err(|error| format!("reference {}: {error}", stored.version))?;
        let reference = Arc::new(reference);
        let mut cached = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        cached.push_back((stored.id, Arc::clone(&reference)));
        if cached.len() > MAX_CACHED_REFERENCES {
            cached.pop_front();
        }
        Ok(reference)
    }
}

/// A visit needs the stored reference. `repeated`: an earlier sweep of this visit suggested lost steps, and the head was
/// homed since.
pub(super) fn judge_sweep(
    task: PatrolTask,
    waypoint: &str,
    raw: &RawSweep,
    repeated: bool,
    stored: Option<&StoredReference>,
    settings: &Settings,
    references: &ReferenceCache,
) -> SweepJudgement {
    let sweep = match assemble(raw) {
        Ok(sweep) => sweep,
        Err(error) => {
            return SweepJudgement {
                assembled: None,
                unassembled_raw: Some(encode_raw_sweep(raw)),
                finding: Err(error.to_string()),
                suspected_lost_steps: None,
            };
        }
    };
    let fault = sweep.quality.fault(settings.sweep.max_missing_lines);
    let view = &sweep.view;
    let mut suspected_lost_steps = None;
    let finding = match (task, fault) {
        (PatrolTask::Sweep, fault) => Ok(SweepFinding::Points {
            ply: write_ply(&view.points),
            fault,
        }),
        (_, Some(fault)) => Err(fault),
        (PatrolTask::Teach, None) => prepare(
            view,
            &settings.engine_settings(Some(waypoint)),
            settings.mixture.seed,
        )
        .map(|reference| SweepFinding::Reference(reference.mixture))
        .map_err(|error| error.to_string()),
        (PatrolTask::Visit, None) => stored
            .ok_or_else(|| "no reference at hand".to_owned())
            .and_then(|stored| {
                let (finding, mismatch) = compare(waypoint, &sweep, stored, settings, references)?;
                match mismatch {
                    // After homing, a rotated view means that the robot itself is rotated.
                    None | Some(Mismatch::Rotated(_)) if repeated => Ok(finding),
                    None => Ok(finding),
                    Some(mismatch) => {
                        let lost_steps = !matches!(mismatch, Mismatch::OtherPlace(_));
                        suspected_lost_steps =
                            (lost_steps && !repeated).then(|| mismatch.reason().to_owned());
                        Err(mismatch.reason().to_owned())
                    }
                }
            }),
    };
    let assembled = AssembledSweep {
        raw: encode_raw_sweep(raw),
        quality: sweep.quality,
        view: sweep.view,
    };
    SweepJudgement {
        assembled: Some(assembled),
        unassembled_raw: None,
        finding,
        suspected_lost_steps,
    }
}

fn compare(
    waypoint: &str,
    sweep: &Sweep,
    stored: &StoredReference,
    settings: &Settings,
    references: &ReferenceCache,
) -> Result<(SweepFinding, Option<Mismatch>), String> {
    let view = &sweep.view;
    let reference = references.get(stored, settings)?;
    let seed = settings.mixture.seed;
    let engine = settings.engine_settings(Some(waypoint));
    let inspection =
        inspect(&reference, view, &engine, seed, &mut |_| ()).map_err(|error| error.to_string())?;
    let thresholds = LostStepThresholds {
        pan_rad: settings.ptu.suspect_pan_rad,
        tilt_rad: settings.ptu.suspect_tilt_rad,
    };
    let mismatch = find_mismatch(&reference, sweep, &inspection.detection, &thresholds);
    let points = [stored.view.points.len(), view.points.len()];
    let mut report =
        InspectionReport::new(&inspection, points, settings.novelty.engine.as_str(), seed);
    let detection = &inspection.detection;
    let reference_from_current = detection.registration.current_from_reference.inverse();
    let retrieved = detection.novelties.iter().zip(&inspection.retrievals);
    report.novelties = retrieved
        .map(|(novelty, shape)| {
            NoveltyRecord::new_in_frame(novelty, shape.as_ref(), &reference_from_current)
        })
        .collect();
    let verdict = detection.verdict;
    let finding = Box::new(VisitFinding { verdict, report });
    Ok((SweepFinding::Visit(finding), mismatch))
}

#[cfg(test)]
mod tests {
    use super::SweepJudgement;

    #[test]
    fn a_panic_of_the_engine_becomes_a_reason() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .expect("a runtime");
        for number in [None, Some(7)] {
            let judging = runtime.spawn_blocking(move || -> SweepJudgement {
                match number {
                    None => panic!("a text\nof two lines"),
                    Some(number) => panic!("number {number}"),
                }
            });
            let ended = runtime.block_on(judging);
            let judgement = ended.unwrap_or_else(SweepJudgement::from_join_error);
            let reason = judgement.finding.expect_err("no finding");
            let expected = number.map_or("a text of two lines", |_| "number 7");
            assert_eq!(reason, format!("the engine failed: {expected}"));
            assert!(judgement.assembled.is_none());
        }
    }
}
