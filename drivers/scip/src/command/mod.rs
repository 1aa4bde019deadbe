//! The requests that the driver sends. Each file has one command (or a family): its bytes, and how its reply is read.
//!
//! | file | commands | reply |
//! |---|---|---|
//! | `switch_protocol` | `SCIP2.0` | - |
//! | [`version`] | `VV` | [`VersionReply`](version::VersionReply) |
//! | [`parameters`] | `PP` | [`ParameterReply`](parameters::ParameterReply) |
//! | [`info`] | `II` | [`InfoReply`](info::InfoReply) |
//! | `quit` | `QT` | - |
//! | `reset` | `RS` | - |
//! | `bit_rate` | `SS` | - |
//! | `time_adjust` | `TM0`, `TM1`, `TM2` | timer, ms |
//! | [`stream`] | `MD`, `MS`, `ME` | [`StreamReply`](stream::StreamReply) |
//!
//! [`span`] holds the steps of a scan, `keyed_lines` reads `KEY:value` lines, `scan_data` reads stamps and values.

pub(crate) mod bit_rate;
pub mod info;
mod keyed_lines;
pub mod parameters;
pub(crate) mod quit;
pub(crate) mod request;
pub(crate) mod reset;
mod scan_data;
pub mod span;
pub mod stream;
pub(crate) mod switch_protocol;
pub(crate) mod time_adjust;
pub mod version;

pub use request::ScipRequest;
