//! Judges a sweep: from its raw data to a verdict, a reference or points. Runs on the blocking pool.

use super::constants::{BLOCKED_SHARE, BLOCKED_WITHIN_M, MIN_SHOWN_SHARE};
use super::reference_cache::ReferenceCache;
use crate::alarm::Incident;
use crate::config::Settings;
use crate::patrol::event::PatrolTask;
use crate::patrol::turn_history::SeenTurn;
use crate::store::{ReadyReference, StoredReference};
use nalgebra::Point3;
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::{Registration, View};
use patrold_engine::inspect::{inspect, prepare};
use patrold_engine::lost_steps::{Mismatch, find_mismatch, view_turn};
use patrold_engine::novelty::{
    NoveltyKind, PlaceView, Reference, ReferenceMixture, Verdict, WatchedPlace, observe_places,
};
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
    /// How it saw the places of the incidents, by number.
    pub(super) places: Vec<(i64, PlaceView)>,
}

#[derive(Debug)]
pub(super) struct SweepJudgement {
    /// `None` where the raw data gives no sweep.
    pub(super) assembled: Option<AssembledSweep>,
    /// Encoded raw data that gave no sweep.
    pub(super) unassembled_raw: Option<Vec<u8>>,
    pub(super) finding: Result<SweepFinding, String>,
    /// How far the view lies turned against the reference, where a pose lays it there.
    pub(super) turn: Option<SeenTurn>,
    /// Why the head is to be homed and the place swept again before there is a finding.
    pub(super) suspected_lost_steps: Option<String>,
    /// Why the sweep itself cannot be judged, independent of the scene.
    pub(super) sweep_fault: Option<String>,
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
            turn: None,
            suspected_lost_steps: None,
            sweep_fault: None,
            made_anew: None,
        }
    }
}

/// What a visit is compared with.
#[derive(Debug, Clone)]
pub(super) struct VisitBasis {
    pub(super) reference: StoredReference,
    /// The waypoint's incidents that it may see again.
    pub(super) incidents: Vec<Incident>,
}

/// A visit needs its basis. `repeated`: an earlier sweep of this visit suggested lost steps, and the head was
/// homed since.
pub(super) fn judge_sweep(
    task: PatrolTask,
    waypoint: &str,
    raw: &RawSweep,
    repeated: bool,
    basis: Option<&VisitBasis>,
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
                turn: None,
                suspected_lost_steps: None,
                sweep_fault: Some(error.to_string()),
                made_anew: None,
            };
        }
    };
    let fault = sweep.quality.fault(settings.sweep.max_missing_lines);
    let sweep_fault = fault.clone();
    let view = &sweep.view;
    let mut suspected_lost_steps = None;
    let mut turn = None;
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
        .map_err(|error| error.to_string())
        .and_then(|reference| {
            let before = basis.map(|basis| &basis.reference);
            let before = before.and_then(|stored| references.get(waypoint, stored, settings).ok());
            let before = before.map(|ready| ready.reference.visible_area_m2());
            match unfit_reference(view, reference.visible_area_m2(), before) {
                None => Ok(SweepFinding::Reference(reference.gamma)),
                Some(reason) => Err(reason),
            }
        }),
        (PatrolTask::Visit, None) => basis
            .ok_or_else(|| "no reference at hand".to_owned())
            .and_then(|basis| {
                let ready = references.get(waypoint, &basis.reference, settings)?;
                made_anew = ready.made_anew.is_some().then(|| Arc::clone(&ready));
                let (finding, fit) = compare(waypoint, &sweep, basis, &ready.reference, settings)?;
                match fit {
                    Ok(seen) => {
                        turn = Some(seen);
                        Ok(finding)
                    }
                    // After homing the head is not at fault: the verdict says what does not fit.
                    Err(Mismatch::Unregistered(_)) if repeated => Ok(finding),
                    Err(mismatch) => {
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
        turn,
        suspected_lost_steps,
        sweep_fault,
        made_anew,
    }
}

/// Why a sweep is no reference: something is before the sensor, or it shows far less than the one before.
fn unfit_reference(view: &View, area_m2: f64, before_m2: Option<f64>) -> Option<String> {
    let is_close = |p: &&Point3<f64>| (*p - view.origin).norm() < BLOCKED_WITHIN_M;
    let close = view.points.iter().filter(is_close).count() as f64;
    let share = close / view.points.len().max(1) as f64;
    if share >= BLOCKED_SHARE {
        return Some(format!(
            "blocked: {:.0} % of what it saw is within {BLOCKED_WITHIN_M} m; clear the view and teach again",
            100.0 * share
        ));
    }
    let before_m2 = before_m2.filter(|before| area_m2 < MIN_SHOWN_SHARE * before)?;
    Some(format!(
        "it shows {area_m2:.1} m2 of surface, the reference before {before_m2:.1} m2; clear the view and teach again, or forget the waypoint first"
    ))
}

fn compare(
    waypoint: &str,
    sweep: &Sweep,
    basis: &VisitBasis,
    reference: &Reference,
    settings: &Settings,
) -> Result<(SweepFinding, Result<SeenTurn, Mismatch>), String> {
    let view = &sweep.view;
    let seed = settings.mixture.seed;
    let engine = settings.engine_settings(Some(waypoint));
    let inspection =
        inspect(reference, view, &engine, seed, &mut |_| ()).map_err(|error| error.to_string())?;
    let max_tilt_rad = settings.ptu.suspect_tilt_rad;
    let fit = match find_mismatch(reference, sweep, &inspection.detection, max_tilt_rad) {
        Some(mismatch) => Err(mismatch),
        None => {
            let turn = view_turn(sweep, &inspection.detection);
            Ok(SeenTurn {
                waypoint: waypoint.to_owned(),
                frame_version: basis.reference.frame_version,
                pan_rad: turn.pan_rad,
                tilt_rad: turn.tilt_rad,
            })
        }
    };
    let points = [basis.reference.view.points.len(), view.points.len()];
    let mut report =
        InspectionReport::new(&inspection, points, settings.novelty.engine.as_str(), seed);
    let detection = &inspection.detection;
    let reference_from_current = detection.registration.current_from_reference.inverse();
    let retrieved = detection.novelties.iter().zip(&inspection.retrievals);
    report.novelties = retrieved
        .map(|(novelty, shape)| {
            let record =
                NoveltyRecord::new_in_frame(novelty, shape.as_ref(), &reference_from_current);
            NoveltyRecord {
                pose_sd: Some(pose_sd(novelty.kind, &record, &detection.registration)),
                ..record
            }
        })
        .collect();
    let watched: Vec<WatchedPlace> = basis.incidents.iter().map(Incident::place).collect();
    let views = observe_places(reference, detection, &watched, &engine.novelty);
    let ids = basis.incidents.iter().map(|incident| incident.id);
    let finding = Box::new(VisitFinding {
        verdict: detection.verdict,
        report,
        places: ids.zip(views).collect(),
    });
    Ok((SweepFinding::Visit(finding), fit))
}

/// Of a novelty's centre by the registration, along the axes of the reference's frame. What disappeared is in that frame.
fn pose_sd(kind: NoveltyKind, record: &NoveltyRecord, registration: &Registration) -> [f64; 3] {
    match kind {
        NoveltyKind::Disappeared => [0.0; 3],
        NoveltyKind::Appeared => {
            let covariance = registration.covariance_at(&Point3::from(record.centre));
            [0, 1, 2].map(|axis| covariance[(axis, axis)].max(0.0).sqrt())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SweepJudgement, unfit_reference};
    use nalgebra::Point3;
    use patrold_engine::geometry::View;

    #[test]
    fn a_blocked_or_much_smaller_reference_is_refused_with_its_figure() {
        let of = |close: usize, area_m2, before_m2| {
            let at = |i| Point3::new(if i < close { 0.349 } else { 0.351 }, 0.0, 0.0);
            let view = View::from_points((0..100).map(at).collect(), Point3::origin());
            unfit_reference(&view, area_m2, before_m2)
        };
        assert_eq!(of(49, 20.0, None), None);
        let blocked = of(50, 20.0, None).expect("refused");
        assert!(
            blocked.contains("50 % of what it saw is within 0.35 m"),
            "{blocked}"
        );
        assert_eq!(of(0, 10.1, Some(20.0)), None);
        let smaller = of(0, 9.9, Some(20.0)).expect("refused");
        assert!(
            smaller.contains("9.9 m2") && smaller.contains("20.0 m2"),
            "{smaller}"
        );
    }

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
