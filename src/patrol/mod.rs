//! Takes a view and a waypoint's reference, gives the inspection: the whole corridor in one call, and its
//! report in the contract's words. Beside it the patrol's state machine: events in, actions out.

mod constants;
mod figure;
pub mod action;
pub mod event;
pub mod machine;
mod inspect;
mod lost_steps;
mod record;
mod report;
mod settings;

pub use inspect::{Inspection, Stage, inspect, prepare};
pub use lost_steps::{Doubt, Suspicion, doubt};
pub use record::{MethodsRecord, NoveltyRecord, ShapeRecord, class_word};
pub use report::{PoseCorrection, Report, SideReport};
pub use settings::EngineSettings;
