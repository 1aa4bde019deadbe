//! What is remembered of the head from one station to the next: a port that is let go takes no doubt with it.

use super::constants::LIMITS_MOVE_STEPS;
use ptu::{AxisLimits, HeadIdentity};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What one process knows of the head's position over all its stations; copies share it.
#[derive(Debug, Clone, Default)]
pub struct HeadMemory(Arc<Mutex<Remembered>>);

#[derive(Debug, Default)]
struct Remembered {
    /// A station was open once: nobody watched the head since, so it is not taken as it is found again.
    was_open: bool,
    /// Something happened after which counts stand for nothing until the next calibration.
    doubted: bool,
    /// The limits of the unit first met.
    limits: Option<Limits>,
}

#[derive(Debug, Clone, PartialEq)]
struct Limits {
    version: String,
    /// Pan, tilt.
    steps: [AxisLimits; 2],
}

impl HeadMemory {
    fn lock(&self) -> MutexGuard<'_, Remembered> {
        // Nothing panics while it holds this.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the head may be taken as it is found.
    pub fn may_take_as_found(&self) -> bool {
        let known = self.lock();
        !known.was_open && !known.doubted
    }

    /// A station is open.
    pub fn opened(&self) {
        self.lock().was_open = true;
    }

    /// From now on the position is in doubt, until the next calibration.
    pub fn doubt(&self) {
        self.lock().doubted = true;
    }

    /// Whether it is.
    pub fn is_doubted(&self) -> bool {
        self.lock().doubted
    }

    /// The position is trusted again: a calibration was seen to end well, or the head kept its power where it was trusted.
    pub fn trust(&self) {
        self.lock().doubted = false;
    }

    /// Whether the unit's limits are where they were when it was first met; a unit of another version is met for the
    /// first time.
    pub fn limits_stand(&self, unit: &HeadIdentity) -> bool {
        let now = Limits {
            version: unit.version.clone(),
            steps: [unit.pan.limits, unit.tilt.limits],
        };
        let mut known = self.lock();
        let first = known.limits.get_or_insert_with(|| now.clone());
        if first.version != now.version {
            *first = now;
            return true;
        }
        let near = |a: i32, b: i32| a.abs_diff(b) <= LIMITS_MOVE_STEPS;
        first.steps.iter().zip(&now.steps).all(|(then, now)| {
            near(then.min_steps, now.min_steps) && near(then.max_steps, now.max_steps)
        })
    }
}
