//! Faults as text: `kind[:key=value,...]`.
//!
//! | kind | keys | what happens |
//! |---|---|---|
//! | `lost-steps` | `axis steps count every` | the rotor jumps by `steps` counts (20), the count stays |
//! | `stuck` | `axis hidden` | the count stands still; with `hidden=true` the count runs and the rotor stands |
//! | `slow` | `axis factor` | all speeds of the axis times `factor` (0.5) |
//! | `event` | `which count every` | an unsolicited `!P`, `!T` or `!D` (`which=P`) |
//! | `text` | `text count every` | unsolicited text on a line of its own |
//! | `echo` | | echo is on again |
//! | `verbose` | | verbose replies are back |
//! | `silence` | `deaf` | nothing is sent; with `deaf=true` nothing is heard either |
//! | `lost-byte` | `count skip` | the next `count` (1) output bytes are lost, letting `skip` through before each |
//! | `garbage-byte` | `count skip` | as above, replaced by a random byte |
//! | `reset-fails` | `count` | the next `count` (1) calibrations fail |
//! | `power-cycle` | | power off and on; `for` is how long it is off |
//! | `wrong-baud` | | garbage both ways |
//!
//! Common keys: `at` (instant of virtual time, s; default now), `for` (s; default for ever). `count` repeats one-time
//! faults every `every` seconds (1). `axis` is `pan`, `tilt` or `both` (the default).

mod board;
mod spec;

pub(super) use board::{Board, Strike};
pub use spec::{FaultError, FaultKind, FaultSpec};
