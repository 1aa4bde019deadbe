//! From the raw data of a sweep to a verdict or a reference: what runs on the blocking pool.

use crate::config::Settings;
use crate::patrol::event::Task;
use crate::store::StoredReference;
use patrold_engine::formats::write_ply;
use patrold_engine::geometry::View;
use patrold_engine::inspect::{inspect, prepare};
use patrold_engine::lost_steps::{Doubt, Suspicion, doubt};
use patrold_engine::mixture::Mixture;
use patrold_engine::novelty::{Reference, Verdict};
use patrold_engine::report::{NoveltyRecord, Report};
use patrold_engine::sweep::{Quality, RawSweep, Sweep, assemble, encode};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::task::JoinError;

/// References kept ready between visits; each takes some tens of megabytes.
const KEPT_READY: usize = 8;

/// A sweep worth keeping.
#[derive(Debug)]
pub struct Kept {
    /// What was seen.
    pub view: View,
    /// Bytes of the raw data.
    pub raw: Vec<u8>,
    /// How good it is.
    pub quality: Quality,
}

/// What the sweep was good for.
#[derive(Debug)]
pub enum Finding {
    /// A visit's verdict.
    Visit(Box<Judgement>),
    /// A reference's mixture.
    Reference(Mixture),
    /// Points, as PLY, and why they would not be judged.
    Points(Vec<u8>, Option<String>),
}

/// A verdict and what it rests on.
#[derive(Debug)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// The report; its novelties are in the reference's frame.
    pub report: Report,
}

/// All that came of a sweep: what can be kept of it, and what was found or why nothing.
#[derive(Debug)]
pub struct Judged {
    /// The sweep, where the raw data gives one.
    pub kept: Option<Kept>,
    /// Bytes of the raw data that give none.
    pub unassembled: Option<Vec<u8>>,
    /// What was found.
    pub finding: Result<Finding, String>,
    /// Why the head is to be homed and the place swept again before anything is said of it.
    pub doubt: Option<String>,
}

impl Judged {
    /// What is left of a judgement that ended in a panic: no verdict, and the panic's own words.
    pub fn broken(error: JoinError) -> Self {
        let words = match error.try_into_panic() {
            Ok(panic) => match panic.downcast::<String>() {
                Ok(text) => *text,
                Err(panic) => panic
                    .downcast::<&str>()
                    .map_or_else(|_| "no words".to_owned(), |text| (*text).to_owned()),
            },
            Err(cancelled) => cancelled.to_string(),
        };
        Self {
            kept: None,
            unassembled: None,
            finding: Err(format!("the engine failed: {}", words.replace('\n', " "))),
            doubt: None,
        }
    }
}

/// References made ready, newest last; shared by all visits under the same settings.
#[derive(Debug, Clone, Default)]
pub struct ReadyReferences(Arc<Mutex<VecDeque<ReadyReference>>>);

/// Sequence number in the store, and the reference.
type ReadyReference = (i64, Arc<Reference>);

impl ReadyReferences {
    fn get(&self, stored: &StoredReference, settings: &Settings) -> Result<Arc<Reference>, String> {
        let found = {
            let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let known = kept.iter().find(|(id, _)| *id == stored.id);
            known.map(|(_, reference)| Arc::clone(reference))
        };
        if let Some(reference) = found {
            return Ok(reference);
        }
        let made = prepare(&stored.view, &settings.engine(None), settings.mixture.seed)
            .map_err(|error| format!("reference {}: {error}", stored.version))?;
        let made = Arc::new(made);
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_back((stored.id, Arc::clone(&made)));
        if kept.len() > KEPT_READY {
            kept.pop_front();
        }
        Ok(made)
    }
}

/// Judges a sweep for `task`; a visit needs the waypoint's stored reference. `again`: an earlier sweep of this visit did not
/// fit at the head's angles, and the head was homed since.
pub fn judge(
    task: Task,
    waypoint: &str,
    raw: &RawSweep,
    again: bool,
    stored: Option<&StoredReference>,
    settings: &Settings,
    ready: &ReadyReferences,
) -> Judged {
    let sweep = match assemble(raw) {
        Ok(sweep) => sweep,
        Err(error) => {
            return Judged {
                kept: None,
                unassembled: Some(encode(raw)),
                finding: Err(error.to_string()),
                doubt: None,
            };
        }
    };
    let fault = sweep.quality.fault(settings.sweep.max_missing_lines);
    let view = &sweep.view;
    let mut doubted = None;
    let finding = match (task, fault) {
        (Task::Sweep, fault) => Ok(Finding::Points(write_ply(&view.points), fault)),
        (_, Some(fault)) => Err(fault),
        (Task::Teach, None) => prepare(
            view,
            &settings.engine(Some(waypoint)),
            settings.mixture.seed,
        )
        .map(|reference| Finding::Reference(reference.mixture))
        .map_err(|error| error.to_string()),
        (Task::Visit, None) => stored
            .ok_or_else(|| "no reference at hand".to_owned())
            .and_then(|stored| {
                let (finding, doubt) = compare(waypoint, &sweep, stored, settings, ready)?;
                match doubt {
                    // After a calibration a view that is turned is a robot that stands askew.
                    None | Some(Doubt::Turned(_)) if again => Ok(finding),
                    None => Ok(finding),
                    Some(doubt) => {
                        let of_the_head = !matches!(doubt, Doubt::Elsewhere(_));
                        doubted = (of_the_head && !again).then(|| doubt.reason().to_owned());
                        Err(doubt.reason().to_owned())
                    }
                }
            }),
    };
    let kept = Kept {
        raw: encode(raw),
        quality: sweep.quality,
        view: sweep.view,
    };
    Judged {
        kept: Some(kept),
        unassembled: None,
        finding,
        doubt: doubted,
    }
}

fn compare(
    waypoint: &str,
    sweep: &Sweep,
    stored: &StoredReference,
    settings: &Settings,
    ready: &ReadyReferences,
) -> Result<(Finding, Option<Doubt>), String> {
    let view = &sweep.view;
    let reference = ready.get(stored, settings)?;
    let seed = settings.mixture.seed;
    let engine = settings.engine(Some(waypoint));
    let inspection =
        inspect(&reference, view, &engine, seed, &mut |_| ()).map_err(|error| error.to_string())?;
    let suspicion = Suspicion {
        pan_rad: settings.ptu.suspect_pan_rad,
        tilt_rad: settings.ptu.suspect_tilt_rad,
    };
    let doubt = doubt(&reference, sweep, &inspection.detection, &suspicion);
    let points = [stored.view.points.len(), view.points.len()];
    let mut report = Report::new(&inspection, points, settings.novelty.engine.word(), seed);
    let detection = &inspection.detection;
    let reference_from_current = detection.registration.current_from_reference.inverse();
    let found = detection.novelties.iter().zip(&inspection.retrievals);
    report.novelties = found
        .map(|(novelty, shape)| {
            NoveltyRecord::new_in(novelty, shape.as_ref(), &reference_from_current)
        })
        .collect();
    let verdict = detection.verdict;
    let judgement = Box::new(Judgement { verdict, report });
    Ok((Finding::Visit(judgement), doubt))
}

#[cfg(test)]
mod tests {
    use super::Judged;

    #[test]
    fn an_engine_that_panics_gives_a_reason_instead_of_silence() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .expect("a runtime");
        for figure in [None, Some(7)] {
            let judging = runtime.spawn_blocking(move || -> Judged {
                match figure {
                    None => panic!("no figures\nat all"),
                    Some(figure) => panic!("figure {figure}"),
                }
            });
            let ended = runtime.block_on(judging);
            let judged = ended.unwrap_or_else(Judged::broken);
            let told = judged.finding.expect_err("no verdict");
            let expected = figure.map_or("no figures at all", |_| "figure 7");
            assert_eq!(told, format!("the engine failed: {expected}"));
            assert!(judged.kept.is_none());
        }
    }
}
