//! Trust in the head's position that outlives a [`Station`](super::Station).

use super::constants::MAX_LIMIT_CHANGE_STEPS;
use ptu::{AxisLimits, HeadIdentity};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What this process knows about the head's position across all stations. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct HeadMemory(Arc<Mutex<Memory>>);

#[derive(Debug, Default)]
struct Memory {
    /// A station was open before; nobody watched the head since, so its position is not trusted as found.
    was_open: bool,
    /// The position is wrong until the next calibration.
    doubted: bool,
    /// Limits at the first connection.
    limits: Option<Limits>,
}

#[derive(Debug, Clone, PartialEq)]
struct Limits {
    version: String,
    /// Pan, tilt.
    steps: [AxisLimits; 2],
}

impl HeadMemory {
    fn lock(&self) -> MutexGuard<'_, Memory> {
        // No holder of the lock panics.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the position may be trusted without homing.
    pub fn may_trust_as_found(&self) -> bool {
        let memory = self.lock();
        !memory.was_open && !memory.doubted
    }

    /// A station was opened.
    pub fn set_opened(&self) {
        self.lock().was_open = true;
    }

    /// The position is doubted until the next calibration.
    pub fn set_doubted(&self) {
        self.lock().doubted = true;
    }

    /// Whether the position is doubted.
    pub fn is_doubted(&self) -> bool {
        self.lock().doubted
    }

    /// The position is trusted again: a calibration succeeded, or the head was trusted and kept its power.
    pub fn clear_doubt(&self) {
        self.lock().doubted = false;
    }

    /// Whether the unit's limits are those of the first connection. A unit with another version string counts as a new
    /// one.
    pub fn limits_unchanged(&self, unit: &HeadIdentity) -> bool {
        let now = Limits {
            version: unit.version.clone(),
            steps: [unit.pan.limits, unit.tilt.limits],
        };
        let mut memory = self.lock();
        let first = memory.limits.get_or_insert_with(|| now.clone());
        if first.version != now.version {
            *first = now;
            return true;
        }
        let near = |a: i32, b: i32| a.abs_diff(b) <= MAX_LIMIT_CHANGE_STEPS;
        first.steps.iter().zip(&now.steps).all(|(then, now)| {
            near(then.min_steps, now.min_steps) && near(then.max_steps, now.max_steps)
        })
    }
}
