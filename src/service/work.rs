//! The request in hand: what has been gathered for it, how it goes to disk, what is told about it.

use super::judge::{Finding, Judged, Judgement, Kept};
use super::replies::{
    AlarmReply, Reply, StepTiming, SweepAbout, SweepReply, TeachReply, VisitReply,
};
use crate::config::Settings;
use crate::patrol::event::{Refusal, Request};
use crate::store::{
    NewReference, NewVisit, Recorded, Stamp, Store, StoreError, StoredReference, SweepRecord,
};
use patrold_engine::novelty::Verdict;
use serde_json::json;
use std::sync::Arc;

/// What has been gathered for one request.
#[derive(Debug)]
pub struct Work {
    /// The request.
    pub request: Request,
    /// The settings that were in force when its sweep began.
    pub settings: Arc<Settings>,
    /// The waypoint's reference.
    pub reference: Option<Arc<StoredReference>>,
    /// A first sweep was doubted; this is the second, after a calibration.
    pub swept_again: bool,
    /// What came of its sweep.
    pub judged: Option<Judged>,
    /// How long the steps took.
    pub timing: StepTiming,
}

impl Work {
    /// Nothing gathered yet.
    pub fn new(request: Request, settings: Arc<Settings>) -> Self {
        Self {
            request,
            settings,
            reference: None,
            swept_again: false,
            judged: None,
            timing: StepTiming::default(),
        }
    }

    /// Puts the outcome on disk; `instead` is why the place was not observed, where nothing could be judged.
    ///
    /// # Errors
    /// The disk or the database refuses, or there is nothing to keep.
    pub fn record(
        &self,
        store: &mut Store,
        instead: Option<&str>,
        stamp: &Stamp,
    ) -> Result<Reply, Refusal> {
        let judged = self.judged.as_ref();
        let kept = judged.and_then(|j| j.kept.as_ref());
        let finding = judged.and_then(|j| j.finding.as_ref().ok());
        let done = match (instead, finding, kept) {
            (Some(reason), _, kept) => self.record_visit(store, None, reason, kept, stamp),
            (None, Some(Finding::Visit(judgement)), kept) => {
                let reason = &judgement.report.reason;
                self.record_visit(store, Some(judgement), reason, kept, stamp)
            }
            (None, Some(Finding::Reference(mixture)), Some(kept)) => {
                let quality = json!(kept.quality).to_string();
                let new = NewReference {
                    waypoint: &self.request.waypoint,
                    sweep: sweep_record(kept, &quality),
                    mixture,
                    engine: &self.settings.engine_json(),
                    seed: self.settings.mixture.seed,
                };
                store.teach(&new, stamp).map(|version| {
                    Reply::Teach(Box::new(TeachReply {
                        waypoint: self.request.waypoint.clone(),
                        version,
                        points: kept.view.points.len(),
                        components: mixture.len(),
                        sweep: kept.quality.clone(),
                        timing_ms: self.timing,
                    }))
                })
            }
            _ => return Err(Refusal::Failed("nothing to keep".to_owned())),
        };
        done.map_err(refusal)
    }

    fn record_visit(
        &self,
        store: &mut Store,
        judgement: Option<&Judgement>,
        reason: &str,
        kept: Option<&Kept>,
        stamp: &Stamp,
    ) -> Result<Reply, StoreError> {
        let settings = &self.settings;
        let waypoint = &self.request.waypoint;
        let report = judgement.map(|j| &j.report);
        let quality = kept
            .map(|k| json!(k.quality).to_string())
            .unwrap_or_default();
        let verdict = judgement.map_or(Verdict::NotObserved, |j| j.verdict);
        let novelties = report.map_or(&[][..], |r| &r.novelties);
        let u_th = report.map_or_else(|| settings.u_th(Some(waypoint)), |r| r.u_th);
        let visit = NewVisit {
            waypoint,
            reference_id: self.reference.as_ref().map(|r| r.id),
            sweep: match kept {
                Some(kept) => Some(sweep_record(kept, &quality)),
                None => self.unassembled().map(raw_record),
            },
            verdict,
            reason,
            d_gmm: report.map(|r| r.d_gmm),
            u_th,
            seed: settings.mixture.seed,
            engine: &settings.engine_json(),
            report: &report.map_or_else(|| "{}".to_owned(), |r| json!(r).to_string()),
            novelties,
            same_place_m: settings.alarms.same_place_m,
        };
        let recorded = store.record_visit(&visit, stamp)?;
        let version = self.reference.as_ref().map_or(0, |r| r.version);
        Ok(Reply::Visit(Box::new(VisitReply {
            waypoint: waypoint.clone(),
            verdict: verdict.word().to_owned(),
            reason: reason.to_owned(),
            visit_id: recorded.visit_id,
            alarm: alarm(&recorded),
            cleared: recorded.cleared,
            d_gmm: report.map(|r| r.d_gmm),
            u_th,
            pose_correction: report.map(|r| r.pose_correction.clone()),
            reference_version: version,
            frame: format!("{waypoint}/{version}"),
            novelties: novelties.to_vec(),
            sweep: kept.map(|k| k.quality.clone()),
            timing_ms: self.timing,
        })))
    }

    fn unassembled(&self) -> Option<&[u8]> {
        self.judged.as_ref()?.unassembled.as_deref()
    }

    /// The answer to a bare sweep, which leaves nothing on disk.
    pub fn points(self) -> Reply {
        let (Some(judged), timing_ms) = (self.judged, self.timing) else {
            return Reply::Refused(Refusal::Failed("no sweep at hand".to_owned()));
        };
        match (judged.kept, judged.finding) {
            (Some(kept), Ok(Finding::Points(ply, fault))) => Reply::Sweep(Box::new(SweepReply {
                ply,
                about: SweepAbout {
                    points: kept.view.points.len(),
                    origin: kept.view.origin.coords.into(),
                    sweep: kept.quality,
                    fault,
                    timing_ms,
                },
            })),
            _ => Reply::Refused(Refusal::Failed("the sweep gave no points".to_owned())),
        }
    }
}

fn sweep_record<'a>(kept: &'a Kept, quality: &'a str) -> SweepRecord<'a> {
    SweepRecord {
        view: Some(&kept.view),
        raw: Some(&kept.raw),
        quality,
    }
}

/// A sweep that gave no view, kept to see why.
fn raw_record(raw: &[u8]) -> SweepRecord<'_> {
    SweepRecord {
        view: None,
        raw: Some(raw),
        quality: "null",
    }
}

fn alarm(recorded: &Recorded) -> Option<AlarmReply> {
    let raised = recorded.raised.map(|id| AlarmReply { id, raised: true });
    let folded = recorded.folded.map(|id| AlarmReply { id, raised: false });
    raised.or(folded)
}

/// What the asker is told about a failure of the store.
pub fn refusal(error: StoreError) -> Refusal {
    let text = error.to_string();
    match error {
        StoreError::UnknownWaypoint { .. } => Refusal::UnknownWaypoint(text),
        StoreError::NoReference { .. } => Refusal::NoReference(text),
        _ => Refusal::Failed(text),
    }
}
