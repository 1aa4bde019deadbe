//! The whole pipeline in one call: from a reference and a current view to verdict, novelties and shapes.

mod constants;
mod engine;
mod inspection;
mod settings;

pub use engine::{Engine, UnknownEngine};
pub use inspection::{Inspection, InspectionStage, inspect, prepare};
pub use settings::EngineSettings;
