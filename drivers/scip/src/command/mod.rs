//! One command, one file: each request knows its bytes and reads its own reply.
//!
//! | file | commands | reply |
//! |---|---|---|
//! | [`switch_protocol`] | `SCIP2.0` | - |
//! | [`version`] | `VV` | [`Version`](version::Version) |
//! | [`parameters`] | `PP` | [`ParameterReply`](parameters::ParameterReply) |
//! | [`info`] | `II` | [`Info`](info::Info) |
//! | [`laser`] | `BM`, `QT` | - |
//! | [`reset`] | `RS`, `RT` | - |
//! | [`time_adjust`] | `TM0`, `TM1`, `TM2` | timer, ms |
//! | [`single`] | `GD`, `GS`, `GE` | [`RawScan`](crate::RawScan) |
//! | [`stream`] | `MD`, `MS`, `ME` | [`StreamReply`](stream::StreamReply) |
//! | [`bit_rate`], [`motor_speed`], [`sensitivity`], [`rehearsal`] | `SS`, `CR`, `HS`, `DB` | - |
//! | [`setting`] | any of those, and `RT` | - |
//!
//! [`span`] says which steps a scan covers, [`keyed`] reads `KEY:value` lines, [`blocks`] reads stamps and values.

pub mod bit_rate;
pub mod blocks;
pub mod info;
pub mod keyed;
pub mod laser;
pub mod motor_speed;
pub mod parameters;
pub mod rehearsal;
pub mod request;
pub mod reset;
pub mod sensitivity;
pub mod setting;
pub mod single;
pub mod span;
pub mod stream;
pub mod switch_protocol;
pub mod time_adjust;
pub mod version;

pub use request::Request;
