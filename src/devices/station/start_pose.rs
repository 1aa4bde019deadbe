//! Where the head starts a sweep, or any other pose to move to.

use crate::devices::plan::SweepPlan;

/// Target and speed of both axes: pan, tilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StartPose {
    /// Counts.
    pub steps: [i32; 2],
    /// Counts per second.
    pub steps_per_s: [i32; 2],
}

impl StartPose {
    /// Start of a sweep; `None`: a sweep without pans or lines.
    pub(super) fn of_sweep(plan: &SweepPlan) -> Option<Self> {
        let (pan, tilt) = plan.approach_steps_s;
        Some(Self {
            steps: [plan.pans.first()?.0, plan.tilt.start_steps()?],
            steps_per_s: [pan, tilt],
        })
    }
}
