//! The statuses that the emulated laser answers with (scip2 section 6).

/// The two characters of a status line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ReplyStatus(pub(super) [u8; 2]);

impl ReplyStatus {
    pub(super) const DONE: Self = Self(*b"00");
    pub(super) const LASER_OFF: Self = Self(*b"10");
    /// SCIP2.2: not in this state.
    pub(super) const DENIED: Self = Self(*b"10");
    /// SCIP2.2: this model has no such setting.
    pub(super) const NOT_SUPPORTED: Self = Self(*b"0F");
    /// SCIP2.2: too few characters.
    pub(super) const TOO_SHORT: Self = Self(*b"0H");
    /// Only VV, II, RS and SCIP2.0 in the firmware update mode.
    pub(super) const FIRMWARE_UPDATE: Self = Self(*b"0I");
    pub(super) const RESUMED: Self = Self(*b"98");
    pub(super) const DATA: Self = Self(*b"99");
    pub(super) const BUFFER_SHORTAGE: Self = Self(*b"0B");
    pub(super) const TOO_FEW_PARAMETERS: Self = Self(*b"0C");
    pub(super) const TOO_MANY_PARAMETERS: Self = Self(*b"0D");
    pub(super) const UNDEFINED: Self = Self(*b"0E");
    pub(super) const STRING_TOO_LONG: Self = Self(*b"0G");
    pub(super) const STRING_CHARACTER: Self = Self(*b"0H");

    /// A status that is a number below 100.
    pub(super) const fn number(number: u8) -> Self {
        Self([b'0' + (number / 10) % 10, b'0' + number % 10])
    }
}
