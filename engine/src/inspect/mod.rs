//! Takes a reference and a view, gives the inspection: the whole pipeline in one call.

mod constants;
mod inspection;
mod settings;

pub use inspection::{Inspection, Stage, inspect, prepare};
pub use settings::EngineSettings;
