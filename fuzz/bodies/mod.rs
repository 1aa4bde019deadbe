//! What is done with bytes from nowhere. One set of bodies, run by cargo-fuzz (`fuzz/fuzz_targets`) and, from seeds and
//! in seconds, by the ordinary test `tests/fuzzed.rs`. A body panics where something it watches does not hold.

pub mod blobs;
pub mod clouds;
pub mod config;
pub mod feed;
pub mod ptu_driver;
pub mod ptu_line;
pub mod ptu_twin;
pub mod scip_driver;
pub mod scip_line;
pub mod scip_sums;
pub mod scip_twin;
pub mod texts;

/// A body: its name, what it does with bytes, and bytes to begin with.
pub type Body = (&'static str, fn(&[u8]), fn() -> Vec<Vec<u8>>);

/// Every body.
pub const ALL: [Body; 10] = [
    ("scip_driver", scip_driver::run, scip_driver::seeds),
    ("scip_line", scip_line::run, scip_line::seeds),
    ("scip_twin", scip_twin::run, scip_twin::seeds),
    ("ptu_driver", ptu_driver::run, ptu_driver::seeds),
    ("ptu_line", ptu_line::run, ptu_line::seeds),
    ("ptu_twin", ptu_twin::run, ptu_twin::seeds),
    ("config", config::run, config::seeds),
    ("clouds", clouds::run, clouds::seeds),
    ("blobs", blobs::run, blobs::seeds),
    ("texts", texts::run, texts::seeds),
];
