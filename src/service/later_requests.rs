//! Requests whose clients do not wait for the outcome: where they are, and for a while what became of them.

use super::api_reply::refusal_status;
use super::constants::{FINISHED_REQUEST_KEPT_FOR, MAX_FINISHED_REQUESTS};
use super::replies::{ErrorReply, RefusalReply, RequestReply, ServiceReply, WorkProgress};
use crate::patrol::event::PatrolRequest;
use crate::patrol::machine::RequestStage;
use std::collections::VecDeque;
use std::time::Instant;

/// In the order in which they came.
#[derive(Debug)]
pub(super) struct LaterRequests {
    /// Begins the ids of this run of the service: one of an earlier run never names a request of this one.
    run: String,
    entries: VecDeque<LaterRequest>,
}

#[derive(Debug)]
struct LaterRequest {
    request: PatrolRequest,
    /// Its client asked to end it.
    cancelled: bool,
    outcome: Option<(LaterOutcome, Instant)>,
}

#[derive(Debug)]
enum LaterOutcome {
    Replied(ServiceReply),
    /// Ended before its sweep; nothing is stored.
    Dropped,
}

/// Where a request is that has no outcome yet.
pub(super) type CurrentStage = Option<(RequestStage, WorkProgress)>;

impl LaterRequests {
    pub(super) fn new(started: jiff::Timestamp) -> Self {
        Self {
            run: format!("{:x}", started.as_millisecond()),
            entries: VecDeque::new(),
        }
    }

    /// The id of a new request.
    pub(super) fn add(&mut self, request: PatrolRequest) -> String {
        let id = self.id(request.id);
        self.entries.push_back(LaterRequest {
            request,
            cancelled: false,
            outcome: None,
        });
        id
    }

    fn id(&self, number: u64) -> String {
        format!("{}-{number}", self.run)
    }

    /// The number of a request that is known still.
    pub(super) fn number(&self, id: &str) -> Option<u64> {
        let entry = |entry: &&LaterRequest| self.id(entry.request.id) == id;
        self.entries.iter().find(entry).map(|e| e.request.id)
    }

    fn entry(&mut self, number: u64) -> Option<&mut LaterRequest> {
        self.entries.iter_mut().find(|e| e.request.id == number)
    }

    /// Whether there is such a request, and it had no outcome.
    pub(super) fn finish(&mut self, number: u64, reply: ServiceReply, now: Instant) -> bool {
        self.set_outcome(number, LaterOutcome::Replied(reply), now)
    }

    /// As [`finish`](Self::finish): it was ended before its sweep.
    pub(super) fn drop_request(&mut self, number: u64, now: Instant) -> bool {
        self.set_outcome(number, LaterOutcome::Dropped, now)
    }

    fn set_outcome(&mut self, number: u64, outcome: LaterOutcome, now: Instant) -> bool {
        let Some(entry) = self.entry(number).filter(|e| e.outcome.is_none()) else {
            return false;
        };
        entry.outcome = Some((outcome, now));
        self.forget(now);
        true
    }

    pub(super) fn set_cancelled(&mut self, number: u64) {
        if let Some(entry) = self.entry(number) {
            entry.cancelled = true;
        }
    }

    /// Forgets the oldest finished ones, beyond the time and the number that are kept.
    pub(super) fn forget(&mut self, now: Instant) {
        let finished = self.entries.iter().filter(|e| e.outcome.is_some()).count();
        let mut surplus = finished.saturating_sub(MAX_FINISHED_REQUESTS);
        self.entries.retain(|entry| {
            let Some((_, at)) = &entry.outcome else {
                return true;
            };
            if surplus > 0 {
                surplus -= 1;
                return false;
            }
            now.saturating_duration_since(*at) < FINISHED_REQUEST_KEPT_FOR
        });
    }

    /// What a client gets of a request; `current` is the stage that the patrol has it in, `None` while it waits.
    pub(super) fn reply(&self, number: u64, current: CurrentStage) -> Option<RequestReply> {
        let entry = self.entries.iter().find(|e| e.request.id == number)?;
        let mut reply = RequestReply {
            id: self.id(number),
            task: entry.request.task.as_str().to_owned(),
            waypoint: entry.request.waypoint.clone(),
            state: "waiting".to_owned(),
            cancelled: entry.cancelled,
            progress: None,
            visit: None,
            teach: None,
            refusal: None,
        };
        let Some((outcome, _)) = &entry.outcome else {
            if let Some((stage, progress)) = current {
                stage.as_str().clone_into(&mut reply.state);
                reply.progress = Some(progress);
            }
            return Some(reply);
        };
        "done".clone_into(&mut reply.state);
        match outcome {
            LaterOutcome::Dropped => "cancelled".clone_into(&mut reply.state),
            LaterOutcome::Replied(ServiceReply::Visit(visit)) => reply.visit = Some(visit.clone()),
            LaterOutcome::Replied(ServiceReply::Teach(teach)) => reply.teach = Some(teach.clone()),
            // Nobody asks for a bare sweep without waiting for it.
            LaterOutcome::Replied(ServiceReply::Sweep(_)) => {}
            LaterOutcome::Replied(ServiceReply::Refused(why)) => {
                "refused".clone_into(&mut reply.state);
                reply.refusal = Some(RefusalReply {
                    status: refusal_status(why).as_u16(),
                    reply: ErrorReply::from(why),
                });
            }
        }
        Some(reply)
    }
}

#[cfg(test)]
mod tests {
    use super::LaterRequests;
    use crate::patrol::event::{PatrolRequest, PatrolTask, RefusalReason};
    use crate::patrol::machine::RequestStage;
    use crate::service::replies::{ServiceReply, WorkProgress};
    use std::time::{Duration, Instant};

    fn request(id: u64) -> PatrolRequest {
        PatrolRequest {
            id,
            task: PatrolTask::Visit,
            waypoint: format!("w{id}"),
        }
    }

    fn refused() -> ServiceReply {
        ServiceReply::Refused(RefusalReason::Busy)
    }

    #[test]
    fn an_id_of_another_run_or_of_nothing_names_no_request() {
        let mut requests = LaterRequests::new("2026-01-01T00:00:00Z".parse().expect("a time"));
        let mut later = LaterRequests::new("2026-01-01T00:00:01Z".parse().expect("a time"));
        let id = requests.add(request(1));
        let other = later.add(request(1));
        assert_ne!(id, other);
        assert_eq!(requests.number(&id), Some(1));
        assert_eq!(later.number(&id), None);
        for none in ["", "1", "-1", &format!("{id}0"), "../1"] {
            assert_eq!(requests.number(none), None, "{none}");
        }
    }

    #[test]
    fn a_request_has_the_state_of_its_stage_and_then_its_outcome() {
        let now = Instant::now();
        let mut requests = LaterRequests::new(jiff::Timestamp::UNIX_EPOCH);
        for number in 1..=3 {
            requests.add(request(number));
        }
        let stage = |requests: &LaterRequests, number, stage: Option<RequestStage>| {
            let current = stage.map(|stage| (stage, WorkProgress::default()));
            let reply = requests.reply(number, current).expect("known");
            assert_eq!(reply.waypoint, format!("w{number}"));
            reply.state
        };
        assert_eq!(stage(&requests, 1, None), "waiting");
        assert_eq!(
            stage(&requests, 2, Some(RequestStage::Sweeping)),
            "sweeping"
        );
        assert!(requests.finish(1, refused(), now));
        assert!(!requests.drop_request(1, now), "it has its outcome");
        assert!(requests.drop_request(3, now));
        assert!(!requests.finish(9, refused(), now));
        assert_eq!(stage(&requests, 1, Some(RequestStage::Judging)), "refused");
        assert_eq!(stage(&requests, 2, None), "waiting");
        assert_eq!(stage(&requests, 3, None), "cancelled");
        let refusal = requests.reply(1, None).and_then(|r| r.refusal);
        assert_eq!(refusal.map(|r| r.status), Some(503));
    }

    #[test]
    fn finished_ones_are_kept_for_an_hour_and_unfinished_ones_for_good() {
        let start = Instant::now();
        let mut requests = LaterRequests::new(jiff::Timestamp::UNIX_EPOCH);
        requests.add(request(1));
        requests.add(request(2));
        requests.finish(2, refused(), start);
        let known = |requests: &LaterRequests, number| requests.reply(number, None).is_some();
        requests.forget(start + Duration::from_secs(3599));
        assert!(known(&requests, 1) && known(&requests, 2));
        requests.forget(start + Duration::from_secs(3600));
        assert!(known(&requests, 1) && !known(&requests, 2));
        for number in 3..=103 {
            requests.add(request(number));
            requests.finish(number, refused(), start);
        }
        assert!(known(&requests, 1) && !known(&requests, 3) && known(&requests, 4));
    }
}
