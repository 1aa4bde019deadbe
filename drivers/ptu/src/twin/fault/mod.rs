//! Faults as text: `kind[:key=value,...]`.
//!
//! | kind | keys | what happens |
//! |---|---|---|
//! | `lost-steps` | `axis steps count every` | the rotor jumps by `steps` counts (20), the count stays |
//! | `stuck` | `axis hidden` | the count stands still; with `hidden=true` the count runs and the rotor stands |
//! | `slow` | `axis factor` | all speeds of the axis times `factor` (0.5) |
//! | `overshoot` | `axis steps` | the axis runs `steps` counts (20) past each target and comes back |
//! | `event` | `which count every within` | an unsolicited `!P`, `!T` or `!D` (`which=P`); `within=N` lets N bytes of the next replies pass first, so that it stands in their middle |
//! | `text` | `text count every` | unsolicited text on a line of its own |
//! | `echo` | | echo is on again |
//! | `verbose` | | verbose replies are back |
//! | `velocity` `slaved` `limits-off` `monitor` | | as after `CV`, `S`, `LD`, `M` of somebody else |
//! | `moving` | `pan tilt` | somebody else sent the head there |
//! | `unit-id` | `id` | the unit has this network id (5) and is not selected |
//! | `baud` | `rate` | the unit speaks at another rate (19200); what the host hears is garbage if the line tells its rate |
//! | `axis-error` | | the axes are not calibrated; an E-series unit refuses targets with `! Axis Error` |
//! | `supply` | `volts degf` | `O` tells these volts (21) and degrees Fahrenheit (150) |
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
