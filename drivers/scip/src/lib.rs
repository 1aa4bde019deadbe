//! Hokuyo SCIP 2.0: the host's side of the protocol, sans-IO, and an emulator of the laser.
//!
//! The laser (URG-04LX and relatives) turns at 10 Hz, anti-clockwise seen from above, and reports one range per *step*
//! of 360/1024 degrees. Every request is one line; every reply is its echo, a status, lines that each end in a sum
//! character, and an empty line (`docs/protocols/scip2.md`):
//!
//! ```text
//! host   MD0044072501000\n                      scans of steps 44 to 725, no clustering, until QT
//! laser  MD0044072501000\n00P\n\n               echo, status + sum, empty line
//! laser  MD0044072501000\n99b\nJUGnD\n...\n\n   echo, status + sum, stamp + sum, lines of 64 characters + sum, empty line
//! ```
//!
//! [`ScipDriver`] runs the dialogue: requests, bytes and instants in, [`LaserAction`]s out. [`command`] has each
//! request with its reply, [`Framer`] cuts bytes into [`ScipMessage`]s, [`emulator`] is the device's side. The crate has
//! no clock, thread or port. After every input, drain all actions before the next one:
//!
//! ```
//! use scip::{LaserAction, ScipDriver, ScipOptions};
//! use std::time::Duration;
//!
//! let mut driver = ScipDriver::new(ScipOptions::default());
//! driver.connect(Duration::ZERO);
//! // QT comes first: the device may still be streaming for a host that crashed.
//! assert_eq!(driver.poll_action(), Some(LaserAction::Send(b"QT\n".to_vec())));
//! driver.handle_bytes(b"QT\nE\n\n", Duration::from_millis(90)); // still in SCIP 1.1
//! assert_eq!(driver.poll_action(), Some(LaserAction::Send(b"SCIP2.0\n".to_vec())));
//! ```

pub mod command;
pub mod constants;
mod driver;
pub mod emulator;
pub mod encoding;
mod error;
mod frame;
mod scan;
mod stamp;
mod status;

pub use command::parameters::LaserParameters;
pub use driver::{
    LaserAction, LaserEvent, LaserIdentity, LaserLine, RecoveryCause, RecoveryStep, Rejection,
    ScipDriver, ScipError, ScipOptions, StreamPlan,
};
pub use error::{EscapedBytes, ReplyError};
pub use frame::{Framer, ScipMessage};
pub use scan::{LaserScan, ValueCoding};
pub use stamp::{STAMP_MODULUS_MS, stamp_advance_ms};
pub use status::{ParameterError, ScipCommand, StatusCode, StatusMeaning};
