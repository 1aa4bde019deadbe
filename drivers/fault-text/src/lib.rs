//! Injected faults as text, `kind[:key=value,...]`: one grammar for all emulated devices and their ports.
//!
//! ```text
//! silence:at=300ms,for=2,count=3,every=10s     three times two seconds, 10 s apart, the first after 300 ms
//! ```
//!
//! Times are seconds, as `2.5`, `2.5s` or `300ms`. Spaces around separators do not count; `_` is `-` in a kind. Every kind
//! has the keys of [`FaultTimes`]; a device adds kinds with keys of their own ([`FaultKeys`]).

mod error;
mod keys;
mod times;

pub use error::FaultTextError;
pub use keys::{FaultKeys, FaultKind};
pub use times::{FaultTimes, parse_seconds, parse_time};
