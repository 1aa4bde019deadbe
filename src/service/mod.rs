//! Takes settings and a shutdown, runs the patrol: devices, requests, timers and signals in one loop.

mod api;
mod conduct;
mod constants;
mod error;
mod judge;
mod ledger;
mod lock;
mod logging;
mod message;
pub mod replies;
mod robot;
mod robot_thread;
mod run;
mod socket;
mod stamp;
mod station;
mod steady;
mod systemd;
mod work;
#[cfg(test)]
mod visits;

pub use api::ABOUT_SWEEP;
pub use error::ServiceError;
pub use logging::{LogLevel, start as start_logging};
pub use message::Control;
pub use robot::{Away, Connect, Fault, Notes, Robot};
pub use run::{Plan, run, run_until, serve};
pub use stamp::stamp_now;
pub use station::StationConnect;
