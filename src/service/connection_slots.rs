//! How many connections there may be, and which one makes room for the next.

use super::constants::MAX_CONNECTIONS;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;
use tokio::task::AbortHandle;
use tokio::time::Instant;

/// A place for each connection.
#[derive(Debug, Clone, Default)]
pub(super) struct Slots(Arc<SharedSlots>);

#[derive(Debug, Default)]
struct SharedSlots {
    taken: Mutex<TakenSlots>,
    /// A connection has ended, or waits for a request again.
    changed: Notify,
}

#[derive(Debug, Default)]
struct TakenSlots {
    last_number: u64,
    by_number: HashMap<u64, SlotState>,
}

#[derive(Debug)]
struct SlotState {
    /// Since when no whole request has come; `None` while one is answered.
    waiting_since: Option<Instant>,
    task: Option<AbortHandle>,
}

impl Slots {
    fn lock(&self) -> MutexGuard<'_, TakenSlots> {
        self.0.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns when there is a free slot.
    pub(super) async fn make_room(&self) {
        loop {
            let changed = self.0.changed.notified();
            {
                let mut taken = self.lock();
                if taken.by_number.len() < MAX_CONNECTIONS || taken.close_longest_waiting() {
                    return;
                }
            }
            changed.await;
        }
    }

    pub(super) fn take(&self) -> ConnectionSlot {
        let mut taken = self.lock();
        taken.last_number += 1;
        let number = taken.last_number;
        let state = SlotState {
            waiting_since: Some(Instant::now()),
            task: None,
        };
        taken.by_number.insert(number, state);
        ConnectionSlot {
            slots: self.clone(),
            number,
        }
    }

    pub(super) fn set_task(&self, number: u64, task: AbortHandle) {
        if let Some(state) = self.lock().by_number.get_mut(&number) {
            state.task = Some(task);
        }
    }
}

impl TakenSlots {
    fn close_longest_waiting(&mut self) -> bool {
        let waiting = self.by_number.iter();
        let since = waiting.filter_map(|(number, state)| Some((state.waiting_since?, *number)));
        let Some((_, number)) = since.min() else {
            return false;
        };
        let closed = self.by_number.remove(&number);
        if let Some(task) = closed.and_then(|state| state.task) {
            task.abort();
        }
        true
    }
}

/// The slot of one connection; free again when it is dropped.
#[derive(Debug)]
pub(super) struct ConnectionSlot {
    slots: Slots,
    number: u64,
}

impl ConnectionSlot {
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// A whole request has come: until the guard is dropped the connection is not closed for another one.
    pub(super) fn begin_answer(&self) -> AnswerGuard<'_> {
        self.set_waiting_since(None);
        AnswerGuard(self)
    }

    fn set_waiting_since(&self, since: Option<Instant>) {
        if let Some(state) = self.slots.lock().by_number.get_mut(&self.number) {
            state.waiting_since = since;
        }
    }
}

impl Drop for ConnectionSlot {
    fn drop(&mut self) {
        self.slots.lock().by_number.remove(&self.number);
        self.slots.0.changed.notify_one();
    }
}

/// A request that is being answered.
#[derive(Debug)]
pub(super) struct AnswerGuard<'a>(&'a ConnectionSlot);

impl Drop for AnswerGuard<'_> {
    fn drop(&mut self) {
        self.0.set_waiting_since(Some(Instant::now()));
        self.0.slots.0.changed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_CONNECTIONS, Slots};
    use std::time::Duration;
    use tokio::time::{advance, timeout};

    #[tokio::test(start_paused = true)]
    async fn the_one_that_waits_longest_makes_room_and_one_with_a_request_never() {
        let slots = Slots::default();
        let mut taken = Vec::new();
        for _ in 0..MAX_CONNECTIONS {
            slots.make_room().await;
            taken.push(slots.take());
            advance(Duration::from_millis(1)).await;
        }
        // The first has a request, and the second had one just now.
        let answering = taken[0].begin_answer();
        drop(taken[1].begin_answer());
        let is_taken = |at: usize| slots.lock().by_number.contains_key(&taken[at].number);
        slots.make_room().await;
        assert!(is_taken(0) && is_taken(1) && !is_taken(2) && is_taken(3));
        drop(slots.take());

        let others: Vec<_> = taken[1..].iter().map(|slot| slot.begin_answer()).collect();
        let last = slots.take();
        let last_answers = last.begin_answer();
        let limit = Duration::from_secs(1);
        assert!(
            timeout(limit, slots.make_room()).await.is_err(),
            "all have one"
        );
        drop(answering);
        timeout(limit, slots.make_room()).await.expect("one waits");
        assert!(!slots.lock().by_number.contains_key(&taken[0].number));
        drop((others, last_answers));
    }
}
