//! An alarm that a client accepts.

use super::hand_over::runtime;
use super::{ServiceMessage, Stepped};
use crate::service::message::AcceptRequest;
use crate::service::running_restore::{RestorePhase, RunningRestore};
use crate::store::StoreError;
use tokio::sync::oneshot;

#[test]
fn an_accept_is_refused_during_a_restore_and_what_it_found_goes_to_its_client() {
    let runtime = runtime();
    let _context = runtime.enter();
    let mut service = Stepped::new("");
    let request = || AcceptRequest {
        id: 7,
        by: "ana".to_owned(),
    };
    let (client, mut reply) = oneshot::channel();
    let accept = ServiceMessage::Accept(request(), client);
    service.controller.handle_message(accept);
    let prepared = service.next(|m| matches!(m, ServiceMessage::AcceptPrepared(..)));
    service.controller.handle_message(prepared);
    service.settle();
    let reply = reply.try_recv().expect("a reply");
    assert!(
        matches!(reply, Err(StoreError::UnknownAlarm(7))),
        "{reply:?}"
    );

    let (asked, _) = oneshot::channel();
    service.controller.restore = Some(RunningRestore {
        from: "/backup".into(),
        client: asked,
        phase: RestorePhase::Beside,
        deferred: None,
    });
    let unknown = || Box::new(Err(StoreError::UnknownAlarm(7)));
    for begins in [true, false] {
        let (client, mut reply) = oneshot::channel();
        let message = if begins {
            ServiceMessage::Accept(request(), client)
        } else {
            ServiceMessage::AcceptPrepared(unknown(), request(), client)
        };
        service.controller.handle_message(message);
        let reply = reply.try_recv().expect("a reply").expect_err("refused");
        assert!(
            reply.to_string().contains("restore is under way"),
            "{reply}"
        );
    }
}
