//! Recording of a sweep's dialogue.

use super::Station;
use crate::devices::error::DeviceError;
use crate::devices::recording::{BEGIN_ATTEMPTS, DialogueTap, IDLE_LIMIT};
use std::time::Duration;

impl Station {
    /// The dialogue of the last sweep, as docs/recording.md has it; also of one that failed. `None`: it was not recorded, or it was
    /// taken already.
    pub fn take_dialogue(&mut self) -> Option<Vec<u8>> {
        self.dialogue.take()
    }

    /// Begins to record where both drivers are idle and nothing of theirs is under way. Returns the recording and the instant at
    /// which the sweep begins. Where a device does not come to rest the recording has stopped, and the sweep goes on without it.
    ///
    /// # Errors
    /// A device failed meanwhile.
    pub(super) fn begin_recording(&mut self) -> Result<(Duration, DialogueTap), DeviceError> {
        self.dialogue = None;
        let mut attempts = BEGIN_ATTEMPTS;
        loop {
            let began_at = self.links.now();
            let tap = DialogueTap::new(began_at);
            self.links.record(&tap);
            let until = began_at + IDLE_LIMIT;
            while !tap.has_both() && self.links.now() < until {
                self.next_message(until);
            }
            // What they said before.
            self.process_pending();
            if let Some(error) = self.state.failure() {
                return Err(error);
            }
            if tap.has_both() && !tap.has_spoken() {
                return Ok((began_at, tap));
            }
            tap.stop();
            attempts -= 1;
            if attempts == 0 {
                return Ok((self.links.now(), tap));
            }
        }
    }
}
