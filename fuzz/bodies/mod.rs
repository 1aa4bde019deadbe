//! Fuzz bodies. cargo-fuzz runs them (`fuzz/fuzz_targets`), and `tests/fuzzed.rs` runs them from seeds within seconds. A body
//! panics where a property it checks does not hold.

pub(crate) mod blobs;
pub(crate) mod clouds;
pub(crate) mod config;
pub(crate) mod choices;
pub(crate) mod ptu_driver;
pub(crate) mod ptu_line;
pub(crate) mod ptu_emulator;
pub(crate) mod scip_driver;
pub(crate) mod scip_line;
pub(crate) mod scip_sums;
pub(crate) mod scip_emulator;
pub(crate) mod texts;

/// Name, body, seeds.
pub(crate) type FuzzBody = (&'static str, fn(&[u8]), fn() -> Vec<Vec<u8>>);

pub(crate) const ALL: [FuzzBody; 10] = [
    ("scip_driver", scip_driver::run, scip_driver::seeds),
    ("scip_line", scip_line::run, scip_line::seeds),
    ("scip_emulator", scip_emulator::run, scip_emulator::seeds),
    ("ptu_driver", ptu_driver::run, ptu_driver::seeds),
    ("ptu_line", ptu_line::run, ptu_line::seeds),
    ("ptu_emulator", ptu_emulator::run, ptu_emulator::seeds),
    ("config", config::run, config::seeds),
    ("clouds", clouds::run, clouds::seeds),
    ("blobs", blobs::run, blobs::seeds),
    ("texts", texts::run, texts::seeds),
];
