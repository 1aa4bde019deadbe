//! What the service asks of the robot's devices. The devices room is one robot; a test may bring another.

use crate::config::Settings;
use crate::devices::Cancel;
use crate::store::Level;
use patrold_engine::sweep::RawSweep;
use serde_json::Value;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

/// Devices that are connected and homed. Dropping it turns the laser off, stops the head and lets the ports go.
pub trait Robot: Send {
    /// Who answers: models, serial numbers, firmware, as JSON for the status.
    fn describe(&mut self) -> Value;

    /// Looks whether the devices are still there, while nothing is asked of them; returns at once.
    ///
    /// # Errors
    /// What went wrong, where they must be opened anew.
    fn watch(&mut self) -> Result<(), Fault> {
        Ok(())
    }

    /// The head's angles do not fit the scene: it is homed before the next sweep.
    fn distrust(&mut self) {}

    /// Waits until devices that went away are back, and homes the head where its position is doubted. Blocks.
    ///
    /// # Errors
    /// Why they are not; where they are not merely absent they must be connected anew.
    fn resume(&mut self, _cancel: &Cancel) -> Result<(), Away> {
        Err(Away {
            reason: "it cannot be resumed".to_owned(),
            absent: false,
        })
    }

    /// Takes a sweep; blocks until it is done.
    ///
    /// # Errors
    /// What went wrong; the laser is off and the head stands then.
    fn sweep(
        &mut self,
        settings: &Settings,
        waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> Result<RawSweep, Fault>;

    /// Brings the head back to where the last sweep began, while that is judged; blocks. How long it took, on the devices'
    /// clock; `None` where it stays.
    fn go_back(&mut self, _cancel: &Cancel) -> Option<Duration> {
        None
    }
}

/// Why there is no robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Away {
    /// One line: device, what happened, what to do.
    pub reason: String,
    /// Whether a device is just not there: looking again soon costs nothing and moves nothing.
    pub absent: bool,
}

/// Why a robot gave no sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// One line: device, what happened, what to do.
    pub reason: String,
    /// Whether the devices must be opened and homed anew before the next sweep.
    pub lost: bool,
}

/// Connects robots.
pub trait Connect: Send {
    /// Connects and homes the devices; blocks until they are ready. What is worth knowing on the way, and later,
    /// goes to `notes`.
    ///
    /// # Errors
    /// Why there is none.
    fn connect(
        &mut self,
        settings: &Settings,
        notes: &Notes,
        cancel: &Cancel,
    ) -> Result<Box<dyn Robot>, Away>;
}

/// Takes what the devices have to say.
#[derive(Clone)]
pub struct Notes(Arc<Take>);

type Take = dyn Fn(Level, &str, String) + Send + Sync;

impl Notes {
    /// Notes that go to `take`: how bad, which device, what.
    pub fn new(take: impl Fn(Level, &str, String) + Send + Sync + 'static) -> Self {
        Self(Arc::new(take))
    }

    /// Says something about a device.
    pub fn say(&self, level: Level, device: &str, text: String) {
        (self.0)(level, device, text);
    }
}

impl fmt::Debug for Notes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Notes")
    }
}
