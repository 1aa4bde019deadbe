//! The recording of one sweep: what ports and station do, in the order in which they do it.

use super::constants::MAX_DIALOGUE_BYTES;
use super::container::{DialogueHeader, EntryWriter, encode};
use super::dialogue::{DialogueEnd, DialogueEntryKind};
use crate::devices::error::Device;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Shared by both ports and the station. Clones share the recording. It reaches each driver behind the commands that were sent
/// before, so that none of them is recorded as a command of the sweep.
#[derive(Debug, Clone)]
pub(crate) struct DialogueTap(Arc<Mutex<TapState>>);

#[derive(Debug, Default)]
struct TapState {
    recording: bool,
    began_at: Duration,
    laser: TappedDriver,
    head: TappedDriver,
    entries: EntryWriter,
    is_full: bool,
}

/// A driver of a recording.
#[derive(Debug, Default)]
struct TappedDriver {
    /// Encoded, from the moment it was idle; its inputs are recorded from then on.
    idle: Option<Vec<u8>>,
    /// It gave an event since.
    has_spoken: bool,
}

impl TapState {
    fn driver(&mut self, device: Device) -> &mut TappedDriver {
        match device {
            Device::Laser => &mut self.laser,
            Device::Head => &mut self.head,
        }
    }

    /// Beyond the bound nothing is noted any more: a dialogue with a hole in it is none.
    fn push(&mut self, tag: u8, device: Device, at: Duration, bytes: Option<&[u8]>) {
        let more = bytes.map_or(0, <[u8]>::len);
        self.is_full |= self.entries.bytes() + more > MAX_DIALOGUE_BYTES;
        if !self.is_full {
            self.entries.push(tag, device, at, bytes);
        }
    }
}

impl DialogueTap {
    fn state(&self) -> MutexGuard<'_, TapState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A recording that begins at `now`: each driver joins it when it is idle.
    pub(crate) fn new(now: Duration) -> Self {
        Self(Arc::new(Mutex::new(TapState {
            recording: true,
            began_at: now,
            entries: EntryWriter::new(now),
            ..TapState::default()
        })))
    }

    /// Drops what was noted; nothing is noted any more.
    pub(crate) fn stop(&self) {
        *self.state() = TapState::default();
    }

    /// Whether both drivers have joined.
    pub(crate) fn has_both(&self) -> bool {
        let state = self.state();
        state.laser.idle.is_some() && state.head.idle.is_some()
    }

    /// Whether a driver that joined gave an event since.
    pub(crate) fn has_spoken(&self) -> bool {
        let state = self.state();
        state.laser.has_spoken || state.head.has_spoken
    }

    /// Lets a driver join that has given all its outputs; `idle` is its state, if it is idle. False where nothing is recorded any
    /// more.
    pub(crate) fn join(&self, device: Device, idle: impl FnOnce() -> Option<Vec<u8>>) -> bool {
        let mut state = self.state();
        if state.recording && state.driver(device).idle.is_none() {
            state.driver(device).idle = idle();
        }
        state.recording
    }

    /// Notes an input or an output of a driver that has joined.
    pub(super) fn note_driver(
        &self,
        device: Device,
        kind: &DialogueEntryKind,
        at: Duration,
        bytes: Option<&[u8]>,
    ) {
        let mut state = self.state();
        if state.driver(device).idle.is_some() {
            state.push(kind.tag(), device, at, bytes);
        }
    }

    /// Notes that a driver gave an event.
    pub(super) fn note_spoken(&self, device: Device) {
        self.state().driver(device).has_spoken = true;
    }

    /// Notes what the sweep did.
    pub(crate) fn note_sweep(&self, device: Device, kind: &DialogueEntryKind, at: Duration) {
        let mut state = self.state();
        if state.recording {
            state.push(kind.tag(), device, at, None);
        }
    }

    /// Ends the recording; `None` where there was none. `plan` is that of the sweep, encoded.
    pub(crate) fn finish(&self, plan: &[u8], end: DialogueEnd) -> Option<Vec<u8>> {
        let state = std::mem::take(&mut *self.state());
        let end = if state.is_full {
            DialogueEnd::TooLong
        } else {
            end
        };
        let header = DialogueHeader {
            plan,
            laser: state.laser.idle.as_deref()?,
            head: state.head.idle.as_deref()?,
            began_at: state.began_at,
            end: &end,
        };
        Some(encode(&header, &state.entries))
    }
}

#[cfg(test)]
mod tests {
    use super::super::dialogue::{DialogueEnd, DialogueEntryKind as Kind, SweepDialogue};
    use super::{DialogueTap, MAX_DIALOGUE_BYTES};
    use crate::devices::error::Device;
    use std::time::Duration;

    #[test]
    fn a_driver_is_recorded_from_when_it_is_idle_and_a_long_dialogue_is_cut_at_its_bound() {
        let at = Duration::from_secs(1);
        let tap = DialogueTap::new(at);
        let received = Kind::Received(Vec::new());
        let note = |device, bytes: &[u8]| tap.note_driver(device, &received, at, Some(bytes));
        note(Device::Laser, b"before");
        assert!(tap.join(Device::Laser, || None));
        note(Device::Laser, b"busy");
        assert!(tap.join(Device::Laser, || Some(vec![1])));
        assert!(tap.join(Device::Laser, || panic!("it has joined")));
        note(Device::Laser, b"laser");
        note(Device::Head, b"busy");
        assert!(!tap.has_both() && !tap.has_spoken());
        assert!(tap.join(Device::Head, || Some(vec![2])));
        tap.note_spoken(Device::Head);
        assert!(tap.has_both() && tap.has_spoken());
        let megabyte = vec![b'x'; 1 << 20];
        for _ in 0..MAX_DIALOGUE_BYTES >> 20 {
            note(Device::Head, &megabyte);
        }
        note(Device::Laser, b"after the hole");
        let bytes = tap.finish(&[3], DialogueEnd::Complete).expect("recorded");
        assert!(bytes.len() < MAX_DIALOGUE_BYTES + 100);
        let dialogue = SweepDialogue::from_bytes(&bytes).expect("read");
        assert_eq!((dialogue.laser, dialogue.head), (vec![1], vec![2]));
        assert_eq!(dialogue.end, DialogueEnd::TooLong);
        assert_eq!(dialogue.entries.len(), MAX_DIALOGUE_BYTES >> 20);
        assert_eq!(dialogue.entries[0].kind, Kind::Received(b"laser".to_vec()));
        assert_eq!(
            tap.finish(&[3], DialogueEnd::Complete),
            None,
            "it has ended"
        );
        assert!(!tap.join(Device::Laser, || panic!("it has ended")));
    }
}
