//! The experiments of paper section V, and a furnished room for the shapes that the paper left for later: a seed in, the
//! columns of Tables I and II out.
//!
//! [`CorridorScene`], [`TestSite`] and [`FurnishedRoom`] simulate scenes with their truth, [`run_engine()`] runs the engine
//! and method of a [`TableColumn`], [`score()`] compares one answer with its truth, [`column_rows()`] counts.
//! [`remove_gaussians`] runs Algorithm 1, [`cylinder_attitudes`] is Fig. 4d; [`scene_picture`] is the content of the other
//! figures.

mod column_rows;
mod column_summary;
mod constants;
mod corridor;
mod error;
mod furnished_room;
mod ideal_cylinder;
mod outline;
mod paper_tables;
mod picture;
mod removal;
mod run_engine;
mod scene_pair;
mod score;
mod site_scene;
mod sweep_pair;
mod table_column;
mod test_site;

pub use column_rows::{ColumnRow, SceneResult, column_rows};
pub use column_summary::ColumnSummary;
pub use corridor::{BeamLayout, CorridorNoise, CorridorObject, CorridorScene, PointDensity};
pub use error::ScenePairError;
pub use furnished_room::FurnishedRoom;
pub use ideal_cylinder::{AxisAccuracy, CylinderAttitude, axis_accuracy, cylinder_attitudes};
pub use outline::{Polyline, gaussian_outline, shape_outline};
pub use paper_tables::{PAPER_COLUMNS, PaperColumn};
pub use picture::{AppearedPicture, ScenePicture, scene_picture};
pub use removal::{GaussianRemoval, RemovalStep, remove_gaussians};
pub use run_engine::run_engine;
pub use scene_pair::{NoveltyTruth, ScenePair};
pub use score::{SceneScore, score};
pub use table_column::TableColumn;
pub use test_site::TestSite;
