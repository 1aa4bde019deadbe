//! Judges a sweep: from its raw data to a verdict, a reference or points. Runs on the blocking pool.

use super::reference_cache::ReferenceCache;
use crate::config::Settings;
use crate::patrol::event::PatrolTask;
use crate::store::{ReadyReference, StoredReference};
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::View;
use patrold_engine::inspect::{inspect, prepare};
use patrold_engine::lost_steps::{LostStepThresholds, Mismatch, find_mismatch};
use patrold_engine::novelty::{Reference, ReferenceMixture, Verdict};
use patrold_engine::report::{InspectionReport, NoveltyRecord};
use patrold_engine::sweep::{RawSweep, Sweep, SweepQuality, assemble, encode_raw_sweep};
use std::sync::Arc;
use tokio::task::JoinError;

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
    Reference(ReferenceMixture),
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
    /// The reference, where its mixture was made anew and is to be stored.
    pub(super) made_anew: Option<Arc<ReadyReference>>,
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
            made_anew: None,
        }
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
                made_anew: None,
            };
        }
    };
    let fault = sweep.quality.fault(settings.sweep.max_missing_lines);
    let view = &sweep.view;
    let mut suspected_lost_steps = None;
    let mut made_anew = None;
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
        .map(|reference| SweepFinding::Reference(reference.gamma))
        .map_err(|error| error.to_string()),
        (PatrolTask::Visit, None) => stored
            .ok_or_else(|| "no reference at hand".to_owned())
            .and_then(|stored| {
                let ready = references.get(waypoint, stored, settings)?;
                made_anew = ready.made_anew.is_some().then(|| Arc::clone(&ready));
                let (finding, mismatch) =
                    compare(waypoint, &sweep, stored, &ready.reference, settings)?;
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
        made_anew,
    }
}

fn compare(
    waypoint: &str,
    sweep: &Sweep,
    stored: &StoredReference,
    reference: &Reference,
    settings: &Settings,
) -> Result<(SweepFinding, Option<Mismatch>), String> {
    let view = &sweep.view;
    let seed = settings.mixture.seed;
    let engine = settings.engine_settings(Some(waypoint));
    let inspection =
        inspect(reference, view, &engine, seed, &mut |_| ()).map_err(|error| error.to_string())?;
    let thresholds = LostStepThresholds {
        pan_rad: settings.ptu.suspect_pan_rad,
        tilt_rad: settings.ptu.suspect_tilt_rad,
    };
    let mismatch = find_mismatch(reference, sweep, &inspection.detection, &thresholds);
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
