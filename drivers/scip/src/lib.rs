//! Hokuyo SCIP 2.0, the host's side, sans-IO: bytes and instants in, actions out.
//!
//! The laser (URG-04LX and relatives) turns at 10 Hz, anti-clockwise seen from above, and reports one range per *step*
//! of 360/1024 degrees. Every request is one line; every reply is its echo, a status, lines that each end in a sum
//! character, and an empty line:
//!
//! ```text
//! host    GD0044072501\n                    latest scan, steps 44 to 725, no clustering
//! sensor  GD0044072501\n00P\nJUGnD\n...\n\n    echo, status + sum, stamp + sum, lines of 64 characters + sum, empty line
//! ```
//!
//! | room | takes | gives |
//! |---|---|---|
//! | [`encoding`] | characters | numbers, sums |
//! | [`frame`] | bytes in any chunking | [`Message`]s |
//! | [`status`] | two characters | what they mean for that command |
//! | [`command`] | a request | its bytes; from a message, its reply |
//! | [`scan`] | values | a [`RawScan`] with its codes kept, typed [`Reading`]s |
//! | [`sensor`] | bytes, instants, requests | the dialogue's [`Action`]s |
//! | [`twin`] | the device's side: bytes and instants | bytes, from the protocol document alone |
//!
//! The crate has no clock, no thread and no port. The law of its use: **one input, then drain all actions, then the
//! next input.**
//!
//! ```
//! use std::time::Duration;
//! use scip::{Action, Sensor, SensorOptions};
//!
//! let mut sensor = Sensor::new(SensorOptions::default());
//! sensor.connect(Duration::ZERO);
//! // The first word is QT: the device may still be streaming for a host that crashed.
//! assert_eq!(sensor.poll_action(), Some(Action::Send(b"QT\n".to_vec())));
//! sensor.handle_bytes(b"QT\nE\n\n", Duration::from_millis(90)); // still speaking SCIP 1.1
//! assert_eq!(sensor.poll_action(), Some(Action::Send(b"SCIP2.0\n".to_vec())));
//! ```

pub mod command;
pub mod constants;
pub mod encoding;
pub mod error;
pub mod frame;
pub mod scan;
pub mod sensor;
pub mod stamp;
pub mod status;
pub mod twin;

pub use command::info::Info;
pub use command::parameters::Parameters;
pub use command::setting::Setting;
pub use error::{ReplyError, SensorError};
pub use frame::{Framer, Message};
pub use scan::{Coding, RawScan, Reading};
pub use sensor::{
    Action, Event, Identity, RecoveryCause, RecoveryStep, Rejection, Sensor, SensorOptions,
    StreamPlan,
};
pub use stamp::{STAMP_MODULUS_MS, stamp_advance_ms};
pub use status::{Command, Meaning, StatusCode};

/// Time since an origin the caller chose, on a clock that never goes back. All instants given to one [`Sensor`] must
/// share that origin.
pub type Instant = std::time::Duration;
