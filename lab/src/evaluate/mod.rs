//! Simulated pairs of sweeps with their truth, judged by the engine: a seed in, rates out.
//!
//! A pair is fixed by the seed, its class of change and its number ([`plan`]); [`SimulatedPair::simulate`] draws its place,
//! change and sweeps; [`run_engine()`] runs the engine; [`score()`] compares the answer with the truth; [`rate_rows()`] counts, and
//! [`separation_rows()`] asks how well d_GMM separates quiet from changed pairs. U_th is the engine's own, or comes from quiet
//! visits to the place of each pair ([`quiet_threshold()`]).

mod builder;
mod changes;
mod constants;
mod doorway;
mod dump;
mod furniture;
mod pair;
mod place;
mod places;
mod plan;
mod point_labels;
mod quiet_threshold;
mod rate_rows;
mod run_engine;
mod score;
mod seeded_rng;
mod sensor;
mod separation_rows;

pub use changes::ChangeClass;
pub use dump::{ManifestEntry, NamedFile, dump};
pub use pair::{PairError, SimulatedPair};
pub use places::PlaceKind;
pub use plan::{PairCounts, PairPlan, PairSet, PoseErrorClass, plan};
pub use point_labels::PointLabel;
pub use quiet_threshold::{QuietThreshold, quiet_threshold, quiet_visits};
pub use rate_rows::{RateRow, rate_rows};
pub use run_engine::{EngineInput, KeptReference, run_engine};
pub use score::{ListedNovelty, PairScore, score};
pub use sensor::SensorKind;
pub use separation_rows::{SeparationRow, separation_rows};
