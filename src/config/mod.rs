//! Configuration files in, checked settings out. Each key is defined once in `keys.rs`; all errors of all files are
//! reported together, with file and line; each value knows its origin.

mod contradictions;
mod engine;
mod error;
mod key_lookup;
mod keys;
mod last_good;
mod layers;
mod load;
mod mount;
mod origins;
mod reading;
mod schema;
mod settings;
mod template;
mod toml_text;
mod value;
mod warnings;
mod waypoint_keys;

pub use engine::ground_name;
pub use error::{ConfigError, ConfigProblem};
pub use key_lookup::edit_distance;
pub use keys::{ConfigKey, KEYS};
pub use last_good::{keep_last_good, load_last_good};
pub use layers::{ConfigFile, ConfigLayers, ValueOrigin};
pub use load::{LoadedConfig, drop_in_folder, load, load_leniently};
pub use origins::SettingOrigins;
pub use schema::json_schema;
pub use settings::{
    AlarmConfig, ApiConfig, LaserConfig, LogConfig, MixtureConfig, MountConfig, NoveltyConfig,
    PtuConfig, RobotConfig, Settings, ShapeConfig, StoreConfig, SweepConfig, SweepMode,
    WaypointConfig,
};
pub use template::template;
pub use toml_text::{devices_drop_in, threshold_drop_in};
pub use value::{ConfigValue, ValueKind};
