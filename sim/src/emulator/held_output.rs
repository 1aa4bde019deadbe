//! Output of a device that its client has not taken yet.

use super::constants::MAX_HELD_BYTES;

/// While some is held the device's own queue waits, which loses whole replies when it is full: no byte is lost inside one.
#[derive(Debug, Default)]
pub(super) struct HeldOutput(Vec<u8>);

impl HeldOutput {
    /// Whether the device may give more.
    pub(super) fn has_room(&self) -> bool {
        self.0.len() < MAX_HELD_BYTES
    }

    pub(super) fn add(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// The client took so many.
    pub(super) fn taken(&mut self, count: usize) {
        self.0.drain(..count.min(self.0.len()));
    }

    /// An unplugged line holds nothing.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_taken_waits_in_order_and_then_the_device_does() {
        let mut held = HeldOutput::default();
        held.add(b"MD00");
        held.taken(2);
        held.add(b"44");
        assert_eq!((held.bytes(), held.has_room()), (&b"0044"[..], true));
        held.taken(9);
        assert_eq!(held.bytes(), b"");
        held.add(&[b'x'; MAX_HELD_BYTES - 1]);
        assert!(held.has_room());
        held.add(b"x");
        assert!(!held.has_room());
        held.taken(1);
        assert!(held.has_room());
        held.clear();
        assert_eq!(held.bytes(), b"");
    }
}
