//! From two laser views of a place to what changed in it: what appeared or disappeared, where, how large, of which shape.
//!
//! Data walks one pipeline, and the modules below are listed in its order:
//! scans -> sweep -> mixture -> distance -> novelty -> shape. [`inspect`] is the pipeline as one function. A module may
//! use those listed above it, never those below. Everything is pure: no clock, no files, no global random generator;
//! the only threads are rayon's. Metres, radians and seconds; REP-103 axes (x forward, y left, z up).
//!
//! Two clouds in, a verdict out: an empty room of 8 x 6 x 3 m, and the same room with a ball of 60 cm in it.
//!
//! ```
//! use patrold_engine::geometry::View;
//! use patrold_engine::inspect::{EngineSettings, inspect, prepare};
//! use patrold_engine::nalgebra::{Point3, Vector3};
//! use patrold_engine::novelty::{NoveltyKind, Verdict};
//! use patrold_engine::shape::Class;
//!
//! /// What a laser in the middle of the room measures; `ball` is centre and radius, metres.
//! fn cloud(ball: Option<(Vector3<f64>, f64)>) -> Vec<Point3<f64>> {
//!     let mut points = Vec::new();
//!     for elevation_deg in -35..30 {
//!         for azimuth_deg in -120..120 {
//!             let (e, a) = (f64::from(elevation_deg).to_radians(), f64::from(azimuth_deg).to_radians());
//!             let ray = Vector3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin());
//!             let wall_m = (0..3).map(|k| [4.0, 3.0, 1.5][k] / ray[k].abs()).fold(f64::MAX, f64::min);
//!             let ball_m = ball.and_then(|(centre, radius)| {
//!                 let along = ray.dot(&centre);
//!                 let root = radius.powi(2) - centre.norm_squared() + along.powi(2);
//!                 (root > 0.0).then(|| along - root.sqrt())
//!             });
//!             points.push(Point3::from(ray * ball_m.unwrap_or(wall_m).min(wall_m)));
//!         }
//!     }
//!     points
//! }
//!
//! # fn main() -> Result<(), patrold_engine::novelty::NoveltyError> {
//! let settings = EngineSettings::standard();
//! let before = View::from_points(cloud(None), Point3::origin());
//! let now = View::from_points(cloud(Some((Vector3::new(2.0, 0.5, -0.4), 0.3))), Point3::origin());
//!
//! let seed = 1;
//! let reference = prepare(&before, &settings, seed)?;
//! let found = inspect(&reference, &now, &settings, seed, &mut |_stage| {})?;
//!
//! assert_eq!(found.detection.verdict, Verdict::Changed);
//! assert_eq!(found.detection.novelties[0].kind, NoveltyKind::Appeared);
//! let shape = &found.retrievals[0].as_ref().expect("enough points").best;
//! assert_eq!(shape.class, Class::Sphere);
//! # Ok(())
//! # }
//! ```

pub use nalgebra;

pub mod geometry;
pub mod formats;
pub mod scan;
pub mod sweep;
pub mod mixture;
pub mod distance;
pub mod novelty;
pub mod shape;
pub mod inspect;
pub mod lost_steps;
pub mod report;
pub mod blob;
