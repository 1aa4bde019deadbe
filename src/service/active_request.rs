//! The request being served: what has been gathered for it, its record in the store and its reply.

use super::judgement::{AssembledSweep, SweepFinding, SweepJudgement, VisitBasis, VisitFinding};
use super::message::TeachOptions;
use super::replies::{
    AlarmReply, AlarmSeen, ServiceReply, StepTiming, SweepInfo, SweepReply, TeachReply, VisitReply,
};
use crate::alarm::Relation;
use crate::config::Settings;
use crate::patrol::event::{PatrolRequest, RefusalReason};
use crate::store::{
    AlarmSighting, Ledger, NewMixture, NewReference, NewVisit, RecordTime, ReferenceFrame, Store,
    StoreError, StoredReference, SweepRecord, VisitOutcome, VisitRecord,
};
use patrold_engine::novelty::Verdict;
use patrold_engine::report::CoverageRecord;
use serde_json::json;
use std::sync::Arc;

#[derive(Debug)]
pub(super) struct ActiveRequest {
    pub(super) request: PatrolRequest,
    /// In force when its sweep began.
    pub(super) settings: Arc<Settings>,
    pub(super) basis: Option<Arc<VisitBasis>>,
    /// The first sweep suggested lost steps; this is the second, after homing.
    pub(super) repeated_sweep: bool,
    pub(super) judgement: Option<SweepJudgement>,
    /// What the devices said during its last sweep, where it was recorded.
    pub(super) dialogue: Option<Vec<u8>>,
    pub(super) timing: StepTiming,
    pub(super) teach: TeachOptions,
}

impl ActiveRequest {
    pub(super) fn new(
        request: PatrolRequest,
        settings: Arc<Settings>,
        teach: TeachOptions,
    ) -> Self {
        Self {
            request,
            settings,
            teach,
            basis: None,
            repeated_sweep: false,
            judgement: None,
            dialogue: None,
            timing: StepTiming::default(),
        }
    }

    fn stored_reference(&self) -> Option<&StoredReference> {
        self.basis.as_deref().map(|basis| &basis.reference)
    }

    /// Writes the outcome to the store; `not_observed` is the reason where nothing could be judged.
    pub(super) fn record(
        &self,
        ledger: &mut Ledger,
        not_observed: Option<&str>,
        now: &RecordTime,
    ) -> Result<ServiceReply, RefusalReason> {
        let recorded = self.record_finding(ledger, not_observed, now);
        // Last: an alarm waits for nothing.
        self.replace_mixture(&mut ledger.store, now);
        recorded
    }

    fn record_finding(
        &self,
        ledger: &mut Ledger,
        not_observed: Option<&str>,
        now: &RecordTime,
    ) -> Result<ServiceReply, RefusalReason> {
        let judgement = self.judgement.as_ref();
        let sweep = judgement.and_then(|j| j.assembled.as_ref());
        let finding = judgement.and_then(|j| j.finding.as_ref().ok());
        let recorded = match (not_observed, finding, sweep) {
            (Some(reason), _, sweep) => self.record_visit(ledger, None, reason, sweep, now),
            (None, Some(SweepFinding::Visit(finding)), sweep) => {
                self.record_visit(ledger, Some(finding), &finding.report.reason, sweep, now)
            }
            (None, Some(SweepFinding::Reference(mixture)), Some(sweep)) => {
                let quality = json!(sweep.quality).to_string();
                let (settings, seed) = (&self.settings, self.settings.mixture.seed);
                let engine = settings.engine_settings(Some(&self.request.waypoint));
                let new = NewReference {
                    waypoint: &self.request.waypoint,
                    sweep: sweep_record(sweep, &quality),
                    mixture,
                    model: &engine.novelty.reference_model(seed),
                    engine: &settings.engine_json(),
                    seed,
                    accepted: &self.teach.accept,
                    frame: ReferenceFrame::Own,
                };
                ledger.store.teach(&new, now).map(|version| {
                    ServiceReply::Teach(Box::new(TeachReply {
                        waypoint: self.request.waypoint.clone(),
                        version,
                        points: sweep.view.points.len(),
                        components: mixture.mixture.len(),
                        sweep: sweep.quality.clone(),
                        timing_ms: self.timing,
                    }))
                })
            }
            _ => return Err(RefusalReason::Failed("nothing to record".to_owned())),
        };
        recorded.map_err(refusal_reason)
    }

    /// Stores a mixture that the judgement made anew, so that it is made once. A failure is reported and does not stop the
    /// visit: the next one makes it again.
    fn replace_mixture(&self, store: &mut Store, now: &RecordTime) {
        let ready = self.judgement.as_ref().and_then(|j| j.made_anew.as_deref());
        let (Some(ready), Some(stored)) = (ready, self.stored_reference()) else {
            return;
        };
        let Some(made_anew) = &ready.made_anew else {
            return;
        };
        let waypoint = &self.request.waypoint;
        let new = NewMixture {
            waypoint,
            stored,
            ready,
            made_anew,
            engine: &self.settings.engine_json(),
            seed: self.settings.mixture.seed,
        };
        let text = new.text();
        match store.replace_mixture(&new, now) {
            Ok(true) => tracing::info!(WAYPOINT = %waypoint, "{text}"),
            Ok(false) => {
                tracing::info!(WAYPOINT = %waypoint, "{text}; another program stored one meanwhile");
            }
            Err(error) => tracing::error!(WAYPOINT = %waypoint, "{text}; not stored: {error}"),
        }
    }

    fn record_visit(
        &self,
        ledger: &mut Ledger,
        finding: Option<&VisitFinding>,
        reason: &str,
        assembled: Option<&AssembledSweep>,
        now: &RecordTime,
    ) -> Result<ServiceReply, StoreError> {
        let settings = &self.settings;
        let waypoint = &self.request.waypoint;
        let report = finding.map(|f| &f.report);
        let quality = assembled
            .map(|sweep| json!(sweep.quality).to_string())
            .unwrap_or_default();
        let verdict = finding.map_or(Verdict::NotObserved, |f| f.verdict);
        let novelties = report.map_or(&[][..], |r| &r.novelties);
        let u_th = report.map_or_else(|| settings.u_th(Some(waypoint)), |r| r.u_th);
        let coverage = report
            .and_then(|r| r.coverage.clone())
            .unwrap_or_else(|| CoverageRecord::none(reason));
        let visit = NewVisit {
            waypoint,
            reference_id: self.stored_reference().map(|r| r.id),
            sweep: self.sweep_of_visit(assembled, &quality),
            verdict,
            reason,
            d_gmm: report.map(|r| r.d_gmm),
            u_th,
            seed: settings.mixture.seed,
            engine: &settings.engine_json(),
            report: &report
                .map_or_else(|| json!({"coverage": coverage}), |r| json!(r))
                .to_string(),
            novelties,
            places: finding.map_or(&[], |f| &f.places),
            same_place_m: settings.alarms.same_place_m,
        };
        let (outcome, not_stored_because) = match ledger.record_visit(&visit, now) {
            Ok(VisitRecord::Stored(outcome)) => (Some(outcome), None),
            Ok(VisitRecord::Held(why)) => (
                None,
                Some(format!("{why}; held and written at the first chance")),
            ),
            Ok(VisitRecord::Dropped(why)) => (None, Some(format!("{why}; not held: too many are"))),
            // A lost database: there is no row to write to, and still an answer.
            Err(why @ StoreError::UnknownWaypoint { .. }) if finding.is_none() => {
                (None, Some(why.to_string()))
            }
            Err(error) => return Err(error),
        };
        let outcome = outcome.as_ref();
        let version = self.stored_reference().map_or(0, |r| r.version);
        Ok(ServiceReply::Visit(Box::new(VisitReply {
            waypoint: waypoint.clone(),
            verdict: verdict.as_str().to_owned(),
            reason: reason.to_owned(),
            visit_id: outcome.map(|outcome| outcome.visit_id),
            stored: outcome.is_some(),
            not_stored_because,
            evidence_missing_because: outcome.and_then(|o| o.evidence_missing.clone()),
            alarm: outcome.and_then(alarm_reply),
            alarms: outcome.map(alarms_seen).unwrap_or_default(),
            cleared: outcome
                .map(|o| o.effects.cleared.clone())
                .unwrap_or_default(),
            d_gmm: report.map(|r| r.d_gmm),
            u_th,
            pose_correction: report.map(|r| r.pose_correction.clone()),
            coverage,
            reference_version: version,
            frame: self
                .stored_reference()
                .map_or_else(|| format!("{waypoint}/0"), |r| r.positions_frame(waypoint)),
            novelties: novelties.to_vec(),
            sweep: assembled.map(|sweep| sweep.quality.clone()),
            timing_ms: self.timing,
        })))
    }

    /// What there is of its sweep: where it failed half way, the bytes that came.
    fn sweep_of_visit<'a>(
        &'a self,
        assembled: Option<&'a AssembledSweep>,
        quality: &'a str,
    ) -> Option<SweepRecord<'a>> {
        let judgement = self.judgement.as_ref();
        let dialogue = self.dialogue.as_deref();
        let Some(sweep) = assembled else {
            let raw = judgement.and_then(|j| j.unassembled_raw.as_deref());
            let is_any = raw.is_some() || dialogue.is_some();
            return is_any.then_some(SweepRecord {
                view: None,
                raw,
                dialogue,
                quality: "null",
            });
        };
        Some(SweepRecord {
            dialogue,
            ..sweep_record(sweep, quality)
        })
    }

    /// The answer to a bare sweep, which leaves nothing on disk.
    pub(super) fn into_sweep_reply(self) -> ServiceReply {
        let (Some(judgement), timing_ms) = (self.judgement, self.timing) else {
            return ServiceReply::Refused(RefusalReason::Failed("no sweep at hand".to_owned()));
        };
        match (judgement.assembled, judgement.finding) {
            (Some(sweep), Ok(SweepFinding::Points { ply, fault })) => {
                ServiceReply::Sweep(Box::new(SweepReply {
                    ply,
                    info: SweepInfo {
                        points: sweep.view.points.len(),
                        origin: sweep.view.origin.coords.into(),
                        sweep: sweep.quality,
                        fault,
                        timing_ms,
                    },
                }))
            }
            _ => {
                ServiceReply::Refused(RefusalReason::Failed("the sweep gave no points".to_owned()))
            }
        }
    }
}

fn sweep_record<'a>(sweep: &'a AssembledSweep, quality: &'a str) -> SweepRecord<'a> {
    SweepRecord {
        view: Some(&sweep.view),
        raw: Some(&sweep.raw),
        dialogue: None,
        quality,
    }
}

/// The first alarm that it raised, else the first that it saw again.
fn alarm_reply(recorded: &VisitOutcome) -> Option<AlarmReply> {
    let reply = |seen: &AlarmSighting| AlarmReply {
        id: seen.id,
        raised: seen.relation == Relation::Raised,
    };
    let mut alarms = recorded.effects.alarms.iter().map(reply);
    alarms.clone().find(|a| a.raised).or_else(|| alarms.next())
}

fn alarms_seen(recorded: &VisitOutcome) -> Vec<AlarmSeen> {
    let alarms = recorded.effects.alarms.iter();
    alarms
        .map(|seen| AlarmSeen {
            id: seen.id,
            relation: seen.relation.as_str().to_owned(),
            novelty: seen.position,
            distance_m: seen.distance_m,
        })
        .collect()
}

pub(super) fn refusal_reason(error: StoreError) -> RefusalReason {
    let text = error.to_string();
    match error {
        StoreError::UnknownWaypoint { .. } => RefusalReason::UnknownWaypoint(text),
        StoreError::NoReference { .. } => RefusalReason::NoReference(text),
        StoreError::StandingAlarms { .. } | StoreError::NotAcceptable { .. } => {
            RefusalReason::Undecided(text)
        }
        StoreError::NameLike { like, .. } => RefusalReason::NearName {
            known: like,
            why: text,
        },
        _ => RefusalReason::Failed(text),
    }
}
