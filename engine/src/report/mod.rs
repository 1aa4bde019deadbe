//! Inspections as the serialisable records of `docs/contract.md`, for JSON and the log.

mod inspection_report;
mod novelty_record;
mod nullable;

pub use inspection_report::{
    CoverageRecord, InspectionReport, PoseCorrection, RemovalRecord, ViewCounts,
};
pub use novelty_record::{
    AlternativeRecord, MethodsRecord, NoveltyRecord, ShapeRecord, class_name,
};
