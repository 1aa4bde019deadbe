//! What was heard on a serial line while a driver connects, and what it shows whichever device was expected: nothing, garbage,
//! the driver's own bytes, a modem, a laser that streams. What only one device says is known by its own driver.

mod constants;
mod heard_bytes;
mod known_lines;

pub use heard_bytes::HeardBytes;
pub use known_lines::{is_modem_code, is_scan_echo};
