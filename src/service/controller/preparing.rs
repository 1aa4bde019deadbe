//! What a request needs before its sweep: the reference and the incidents of its waypoint, and leave to teach.

use super::{Controller, send};
use crate::patrol::event::{PatrolRequest, PatrolTask};
use crate::service::active_request::refusal_reason;
use crate::service::judgement::VisitBasis;
use crate::service::message::{ServiceMessage, TeachOptions};
use crate::store::{Store, StoreError};

impl Controller {
    pub(super) fn prepare(&mut self, request: PatrolRequest) {
        if self.waits_for_restore(&request) {
            return;
        }
        let (id, task, waypoint) = (request.id, request.task, request.waypoint.clone());
        let active = self.active_for(request);
        let teach = active.teach.clone();
        self.active = Some(active);
        let inbox = self.services.inbox.clone();
        self.services.writer.submit(
            move |ledger| {
                // The incidents of a visit that is held are known once it is stored.
                let upkeep = ledger.is_behind().then(|| ledger.maintain());
                let basis = basis_of(&ledger.store, task, &waypoint, &teach);
                (upkeep, basis.map_err(refusal_reason))
            },
            move |(upkeep, basis)| {
                if let Some(report) = upkeep {
                    send(&inbox, ServiceMessage::Storage(Box::new(report)));
                }
                send(&inbox, ServiceMessage::Prepared(id, basis));
            },
        );
    }
}

/// What a visit is compared with; for a teach the reference before it, if there is one and it can be read.
fn basis_of(
    store: &Store,
    task: PatrolTask,
    waypoint: &str,
    teach: &TeachOptions,
) -> Result<Option<Box<VisitBasis>>, StoreError> {
    if task == PatrolTask::Teach {
        store.check_teach(waypoint, &teach.accept, teach.new_name)?;
        let before = store.reference(waypoint).ok();
        return Ok(before.map(|reference| {
            Box::new(VisitBasis {
                reference,
                incidents: Vec::new(),
            })
        }));
    }
    Ok(Some(Box::new(VisitBasis {
        reference: store.reference(waypoint)?,
        incidents: store.incidents(waypoint)?,
    })))
}
