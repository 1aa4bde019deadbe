//! What a client says about an alarm.

use super::Controller;
use crate::service::message::AckRequest;
use crate::service::message_id;
use crate::service::record_time::record_time_now;
use crate::service::replies::AckReply;
use crate::store::StoreError;
use tokio::sync::oneshot;

impl Controller {
    /// On disk before the client hears of it.
    pub(super) fn acknowledge(
        &mut self,
        request: AckRequest,
        reply_to: oneshot::Sender<Result<AckReply, StoreError>>,
    ) {
        self.services.writer.submit(
            move |ledger| {
                let (by, note) = (request.by, request.note.as_deref());
                let alarm = ledger.store.acknowledge_and_answer(
                    request.id,
                    &by,
                    note,
                    request.answer,
                    &record_time_now(),
                )?;
                tracing::info!(
                    MESSAGE_ID = message_id::ALARM_ACKNOWLEDGED,
                    ALARM_ID = alarm.id,
                    "alarm {} acknowledged by {by}",
                    alarm.id
                );
                Ok(AckReply {
                    alarm: alarm.id,
                    state: alarm.state,
                    by,
                })
            },
            // The client may have disconnected.
            move |reply| drop(reply_to.send(reply)),
        );
    }
}
