//! Fuzz bodies. cargo-fuzz runs them (`fuzz/fuzz_targets`), and `tests/fuzzed.rs` runs them from seeds within seconds. A body
//! panics where a property it checks does not hold.

pub mod blobs;
pub mod clouds;
pub mod config;
pub mod choices;
pub mod ptu_driver;
pub mod ptu_line;
pub mod ptu_emulator;
pub mod scip_driver;
pub mod scip_line;
pub mod scip_sums;
pub mod scip_emulator;
pub mod texts;

/// Name, body, seeds.
pub type FuzzBody = (&'static str, fn(&[u8]), fn() -> Vec<Vec<u8>>);

pub const ALL: [FuzzBody; 10] = [
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
