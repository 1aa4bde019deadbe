//! Replies to clients, and clients that disconnect before they have one.

use super::Controller;
use crate::patrol::event::{PatrolEvent, PatrolRequest};
use crate::patrol::severity::Severity;
use crate::service::message_id;
use crate::service::replies::{ServiceReply, VisitReply};
use std::time::Instant;

impl Controller {
    pub(super) fn reply(&mut self, request: &PatrolRequest) {
        let spent_ms = self.step_ms();
        let mut reply = match (self.recorded_reply.take(), self.active.take()) {
            (Some(recorded), _) => recorded,
            (None, Some(active)) => active.into_sweep_reply(),
            (None, None) => return,
        };
        match &mut reply {
            ServiceReply::Visit(visit) => {
                visit.timing_ms.record = spent_ms;
                log_visit(visit);
            }
            ServiceReply::Teach(teach) => {
                teach.timing_ms.record = spent_ms;
                let (waypoint, version) = (&teach.waypoint, teach.version);
                tracing::info!(MESSAGE_ID = message_id::REFERENCE_TAKEN, WAYPOINT = %waypoint, "{waypoint}: reference version {version} taken");
            }
            ServiceReply::Sweep(_) | ServiceReply::Refused(_) => {}
        }
        self.send_reply(request.id, reply);
    }

    pub(super) fn send_reply(&mut self, id: u64, reply: ServiceReply) {
        match self.reply_channels.remove(&id) {
            // The client may have disconnected; the log has the outcome.
            Some(channel) => drop(channel.send(reply)),
            None => drop(self.later.finish(id, reply, Instant::now())),
        }
    }

    pub(super) fn drop_disconnected_clients(&mut self) {
        let closed = self
            .reply_channels
            .iter()
            .filter(|(_, channel)| channel.is_closed());
        let mut disconnected: Vec<u64> = closed.map(|(id, _)| *id).collect();
        // The last of the queue first: dropping the first would start the next.
        disconnected.sort_unstable_by(|a, b| b.cmp(a));
        for id in disconnected {
            self.reply_channels.remove(&id);
            self.handle(PatrolEvent::ClientGone(id));
        }
    }

    pub(super) fn abandon(&mut self, request: &PatrolRequest) {
        self.teach_options.remove(&request.id);
        self.forget_deferred(request.id);
        self.active
            .take_if(|active| active.request.id == request.id);
        self.raw_sweep = None;
        self.judging = false;
        let (task, waypoint) = (request.task.as_str(), &request.waypoint);
        let name = format!("{task} {waypoint}");
        let why = match self.later.drop_request(request.id, Instant::now()) {
            true => "cancelled by its client",
            false => "the client disconnected",
        };
        let text = format!("{} dropped: {why}", name.trim_end());
        self.log_event(Severity::Warning, "service", text);
    }
}

fn log_visit(visit: &VisitReply) {
    let (waypoint, verdict, reason) = (&visit.waypoint, &visit.verdict, &visit.reason);
    let (d_gmm, alarm_id) = (visit.d_gmm, visit.alarm.map(|alarm| alarm.id));
    if let Some(why) = &visit.not_stored_because {
        // The journal is then the only place that outlives this process: it gets the whole answer.
        let answer = serde_json::to_string(visit).unwrap_or_default();
        tracing::error!(
            MESSAGE_ID = message_id::VISIT_NOT_STORED, WAYPOINT = %waypoint, VERDICT = %verdict, STORED = false, ANSWER = %answer,
            "{waypoint}: {verdict}: {reason}; not stored: {why}"
        );
        return;
    }
    if let Some(why) = &visit.evidence_missing_because {
        tracing::error!(MESSAGE_ID = message_id::EVIDENCE_NOT_STORED, WAYPOINT = %waypoint, "{waypoint}: the sweep of visit {} is not stored yet: {why}",
            visit.visit_id.unwrap_or_default());
    }
    let kind = message_id::of_verdict(verdict);
    match alarm_id {
        Some(id) => {
            let alarms: Vec<String> = visit.alarms.iter().map(ToString::to_string).collect();
            let alarms = alarms.join(", ");
            tracing::warn!(
                WAYPOINT = %waypoint, VERDICT = %verdict, D_GMM = d_gmm, ALARM_ID = id, MESSAGE_ID = kind,
                "{waypoint}: {verdict}, {alarms}: {reason}"
            );
        }
        None => tracing::info!(
            WAYPOINT = %waypoint, VERDICT = %verdict, D_GMM = d_gmm, MESSAGE_ID = kind,
            "{waypoint}: {verdict}: {reason}"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::log_visit;
    use crate::service::captured_log::captured;
    use crate::service::message_id;
    use crate::service::replies::{AlarmReply, StepTiming, VisitReply};
    use patrold_engine::report::CoverageRecord;

    fn visit(verdict: &str) -> VisitReply {
        VisitReply {
            waypoint: "hall".to_owned(),
            verdict: verdict.to_owned(),
            reason: "because".to_owned(),
            visit_id: Some(3),
            stored: true,
            not_stored_because: None,
            evidence_missing_because: None,
            alarm: None,
            alarms: Vec::new(),
            cleared: Vec::new(),
            d_gmm: Some(0.5),
            u_th: 0.1,
            pose_correction: None,
            coverage: CoverageRecord::none("no sweep"),
            reference_version: 1,
            frame: "hall/1".to_owned(),
            novelties: Vec::new(),
            sweep: None,
            timing_ms: StepTiming::default(),
        }
    }

    fn kinds(visit: &VisitReply) -> Vec<String> {
        let log = captured(|| log_visit(visit));
        let kind = |line: &str| Some(line.split_once("MESSAGE_ID=\"")?.1[..32].to_owned());
        log.lines().filter_map(kind).collect()
    }

    #[test]
    fn a_visit_is_logged_under_the_kind_of_its_verdict() {
        assert_eq!(kinds(&visit("quiet")), [message_id::VISIT_QUIET]);
        assert_eq!(
            kinds(&visit("not_observed")),
            [message_id::VISIT_NOT_OBSERVED]
        );
        let changed = VisitReply {
            alarm: Some(AlarmReply {
                id: 9,
                raised: true,
            }),
            ..visit("changed")
        };
        assert_eq!(kinds(&changed), [message_id::VISIT_CHANGED]);
    }

    #[test]
    fn what_the_disk_did_not_take_has_kinds_of_its_own() {
        let reason = || Some("no space".to_owned());
        let unstored = VisitReply {
            not_stored_because: reason(),
            ..visit("changed")
        };
        assert_eq!(kinds(&unstored), [message_id::VISIT_NOT_STORED]);
        let without_evidence = VisitReply {
            evidence_missing_because: reason(),
            ..visit("quiet")
        };
        assert_eq!(
            kinds(&without_evidence),
            [message_id::EVIDENCE_NOT_STORED, message_id::VISIT_QUIET]
        );
    }
}
