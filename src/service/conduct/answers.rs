//! Who asked, what they are told, and that nobody waits any more.

use super::Conductor;
use crate::patrol::event::{Event, Request};
use crate::service::replies::{Reply, VisitReply};
use crate::store::Level;

impl Conductor {
    pub(super) fn reply(&mut self, request: &Request) {
        let spent = self.lap_ms();
        let mut reply = match (self.outcome.take(), self.work.take()) {
            (Some(outcome), _) => outcome,
            (None, Some(work)) => work.points(),
            (None, None) => return,
        };
        match &mut reply {
            Reply::Visit(visit) => {
                visit.timing_ms.record = spent;
                log_visit(visit);
            }
            Reply::Teach(teach) => {
                teach.timing_ms.record = spent;
                let (waypoint, version) = (&teach.waypoint, teach.version);
                tracing::info!(WAYPOINT = %waypoint, "{waypoint}: reference version {version} taken");
            }
            Reply::Sweep(_) | Reply::Refused(_) => {}
        }
        self.answer(request.id, reply);
    }

    pub(super) fn answer(&mut self, id: u64, reply: Reply) {
        if let Some(answer) = self.answers.remove(&id) {
            // An asker that went away hears nothing; the log knows.
            let _ = answer.send(reply);
        }
    }

    /// Tells the patrol of every asker that hung up.
    pub(super) fn look_for_askers(&mut self) {
        let closed = self.answers.iter().filter(|(_, a)| a.is_closed());
        let mut gone: Vec<u64> = closed.map(|(id, _)| *id).collect();
        // Those behind first, or they would be begun when the one before them is dropped.
        gone.sort_unstable_by(|a, b| b.cmp(a));
        for id in gone {
            self.answers.remove(&id);
            self.handle(Event::AskerGone(id));
        }
    }

    pub(super) fn forget(&mut self, request: &Request) {
        self.work.take_if(|work| work.request.id == request.id);
        self.raw = None;
        self.judging = false;
        let (task, waypoint) = (request.task.word(), &request.waypoint);
        let what = format!("{task} {waypoint}");
        let text = format!("{} dropped: whoever asked went away", what.trim_end());
        self.note(Level::Warning, "service", text);
    }
}

fn log_visit(visit: &VisitReply) {
    let (waypoint, verdict, reason) = (&visit.waypoint, &visit.verdict, &visit.reason);
    let (d_gmm, alarm_id) = (visit.d_gmm, visit.alarm.map(|alarm| alarm.id));
    match alarm_id {
        Some(id) => tracing::warn!(
            WAYPOINT = %waypoint, VERDICT = %verdict, D_GMM = d_gmm, ALARM_ID = id,
            "{waypoint}: {verdict}, alarm {id}: {reason}"
        ),
        None => tracing::info!(
            WAYPOINT = %waypoint, VERDICT = %verdict, D_GMM = d_gmm,
            "{waypoint}: {verdict}: {reason}"
        ),
    }
}
