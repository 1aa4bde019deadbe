//! Takes an inspection, gives the records that JSON and the log show, in the words of `docs/contract.md`.

mod figure;
mod record;
mod report;

pub use record::{MethodsRecord, NoveltyRecord, ShapeRecord, class_word};
pub use report::{PoseCorrection, Report, SideReport};
