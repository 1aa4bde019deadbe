//! `patrold reproduce table1|table2`: the paper's tables beside ours.

mod command;
mod figures;
mod numbers;
mod projection;
mod tell;

pub use command::{ReproduceArgs, run};
