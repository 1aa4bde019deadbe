//! Every figure that decides something in this module, its unit and where it comes from.

use std::time::Duration;

/// Longest span of virtual time that the emulation passes in one piece. The head's twin remembers two seconds of its
/// motion, and a scan looks one turn and a half back.
pub const EMULATION_PIECE: Duration = Duration::from_millis(500);

/// Wall time after which an emulated port looks around even if nothing is due.
pub const EMULATOR_LOOK: Duration = Duration::from_millis(20);
