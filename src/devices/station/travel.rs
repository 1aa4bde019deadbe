//! Moves of the head that are no part of a sweep.

use super::Station;
use crate::devices::cancel::Cancel;
use crate::devices::error::DeviceError;
use crate::devices::head::{HeadCommand, HeadEvent};
use crate::devices::plan::SweepPlan;
use crate::devices::port::PortEvent;
use crate::devices::sweep_run::stalled;
use crate::devices::wires::Told;
use ptu::{Axis, MoveState, MoveWatch};
use std::time::Duration;

/// Where both axes go and how fast; pan, tilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stance {
    /// Counts.
    pub steps: [i32; 2],
    /// Counts per second.
    pub steps_per_s: [i32; 2],
}

impl Stance {
    /// Where a sweep begins.
    pub fn before(plan: &SweepPlan) -> Option<Self> {
        let (pan, tilt) = plan.approach_steps_s;
        Some(Self {
            steps: [plan.pans.first()?.0, plan.tilt.start_steps()?],
            steps_per_s: [pan, tilt],
        })
    }
}

impl Station {
    /// Brings the head back to where the last sweep began, so that the next one need not wait for it. How long that
    /// took; `None` where there is nothing to go back to, or the head's position is not trusted.
    ///
    /// # Errors
    /// The head is not connected, or stalls; [`DeviceError::Cancelled`] soon after `cancel` was set. It stands then.
    pub fn go_back(&mut self, cancel: &Cancel) -> Result<Option<Duration>, DeviceError> {
        self.catch_up();
        let Some(stance) = self.begun_at.filter(|_| self.known.trusted()) else {
            return Ok(None);
        };
        let begun = self.wires.now();
        let gone = self.travel(&stance, cancel);
        if matches!(gone, Err(DeviceError::Stalled { .. })) {
            self.known.distrusted("an axis stalled");
        }
        self.leave_mark();
        gone.map(|()| Some(self.wires.now().saturating_sub(begun)))
    }

    /// Sends both axes to `stance` and waits until they are there.
    pub(super) fn travel(&mut self, stance: &Stance, cancel: &Cancel) -> Result<(), DeviceError> {
        let axes = [Axis::Pan, Axis::Tilt];
        for (i, axis) in axes.into_iter().enumerate() {
            self.wires
                .head(HeadCommand::SetSpeed(axis, stance.steps_per_s[i]));
            self.wires.head(HeadCommand::MoveTo(axis, stance.steps[i]));
        }
        let mut there = Ok(());
        for (i, axis) in axes.into_iter().enumerate() {
            let (steps, speed) = (stance.steps[i], stance.steps_per_s[i]);
            there = there.and_then(|()| self.arrive(axis, steps, speed, cancel));
        }
        self.wires.head(HeadCommand::Watch(None));
        if there.is_err() {
            self.wires.head(HeadCommand::Halt);
        }
        there
    }

    fn arrive(
        &mut self,
        wanted: Axis,
        target_steps: i32,
        steps_per_s: i32,
        cancel: &Cancel,
    ) -> Result<(), DeviceError> {
        let identity = self.known.head()?;
        let axis = match wanted {
            Axis::Pan => &identity.pan,
            Axis::Tilt => &identity.tilt,
        };
        // A move of unknown beginning takes no longer than the whole range.
        let range = i64::from(axis.limits.max_steps) - i64::from(axis.limits.min_steps);
        let time = axis.profile(steps_per_s).travel_time(range);
        let mut watch = MoveWatch::new(target_steps, self.wires.now(), time);
        let mut at_steps = target_steps;
        self.wires.head(HeadCommand::Watch(Some(wanted)));
        loop {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            let state = match self.next(watch.overdue_at()) {
                Some(
                    Told::Head(PortEvent::Lost { error, .. })
                    | Told::Laser(PortEvent::Lost { error, .. }),
                ) => return Err(error),
                Some(Told::Head(PortEvent::Device(HeadEvent::Unit(ptu::Event::Position {
                    axis,
                    steps,
                    first_byte_at,
                    ..
                }))))
                    if axis == wanted =>
                {
                    at_steps = steps;
                    watch.observe(steps, first_byte_at)
                }
                // Who is late to listen has not seen an axis stand.
                _ if self.wires.now() < watch.overdue_at() => MoveState::Moving,
                _ => MoveState::Overdue,
            };
            match state {
                MoveState::Arrived => return Ok(()),
                MoveState::Moving => {}
                MoveState::Stalled | MoveState::Overdue => {
                    let port = self.head_port.name.clone();
                    return Err(stalled(port, wanted, at_steps, target_steps));
                }
            }
        }
    }
}
