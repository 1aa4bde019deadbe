//! Takes settings and commands, runs the patrol: devices, client requests, timers and signals in one loop.

mod acceptance;
mod active_request;
mod api;
mod api_body;
mod api_reply;
mod api_state;
#[cfg(test)]
mod captured_log;
mod connection;
mod connection_slots;
mod connections;
mod constants;
mod controller;
mod database_check;
mod error;
mod judgement;
mod later_requests;
mod lock;
mod logging;
mod message;
mod message_id;
mod operator;
mod reading_result;
mod record_time;
mod reference_cache;
pub mod replies;
mod run;
mod running_restore;
mod scanner;
mod scanner_thread;
mod socket;
mod station_scanner;
mod storage_watch;
mod store_api;
mod store_writer;
mod systemd;
#[cfg(test)]
mod visit_tests;
mod wall_clock;
mod work_estimate;
mod write_limit;

pub use acceptance::Acceptance;
pub use api_reply::SWEEP_INFO_HEADER;
pub use error::ServiceError;
pub use lock::StoreLock;
pub use logging::LogLevelHandle;
pub use message::ServiceCommand;
pub use operator::operator;
pub use record_time::record_time_now;
pub use run::{ServiceParts, run, run_until, serve};
pub use scanner::{ConnectError, DeviceNoteSink, Scanner, ScannerConnector, ScannerError};
pub use station_scanner::StationConnector;
pub use work_estimate::planned_sweep;
