//! Every constant that decides something about what was heard, with its unit and origin.

/// Bytes kept from the beginning, to judge who answers. Own choice: some replies of any device.
pub(crate) const HEARD_BYTES: usize = 512;

/// Bytes of that in a message, from the beginning or the end. Own choice: half a line of text.
pub(crate) const EXCERPT_BYTES: usize = 40;

/// Share of bytes that no text has (neither printable ASCII nor CR, LF, tab) from which a line is no text. Own choice: a
/// wrong line rate or noise spoils most bytes, a bad contact one in a hundred.
pub(crate) const MIN_UNPRINTABLE_SHARE: f64 = 0.1;
