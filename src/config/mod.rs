//! Takes configuration files, gives checked settings: every key stands once in [`keys`], every mistake is
//! told at once with its line, and every value knows where it came from.

mod check;
mod contradictions;
mod engine;
mod keys;
mod layers;
mod load;
mod mount;
mod reading;
mod settings;
mod template;
mod value;

pub use check::{Mistake, Problem};
pub use keys::{KEYS, Key, WAYPOINT_KEYS};
pub use layers::{Layers, Origin, Source};
pub use load::{DEFAULT_FILE, Loaded, load};
pub use settings::{
    AlarmSettings, ApiSettings, EngineMode, LaserSettings, LogSettings, MixtureSettings,
    MountSettings, NoveltySettings, PtuSettings, RobotSettings, Settings, ShapeSettings,
    StoreSettings, SweepMode, SweepSettings, WaypointSettings,
};
pub use template::template;
pub use value::{Kind, Value};
