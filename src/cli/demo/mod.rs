//! `patrold demo`: the whole job with no hardware, judged against the truth.

mod building;
mod command;
mod rounds;
mod stage;
mod tell;
mod truth;

pub use command::{DemoArgs, run};
