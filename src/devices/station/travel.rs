//! Moves of the head between sweeps.

use super::Station;
use super::start_pose::StartPose;
use crate::devices::cancel::Cancel;
use crate::devices::device_links::PortMessage;
use crate::devices::error::DeviceError;
use crate::devices::head::{HeadCommand, HeadEvent};
use crate::devices::port::PortEvent;
use crate::devices::sweep_run::stalled_error;
use ptu::{Axis, MoveState, MoveWatch};
use std::time::Duration;

impl Station {
    /// Moves the head back to where the last sweep started, so that the next one need not wait for it. Returns how long that
    /// took; `None`: no sweep yet, or the head's position is not trusted.
    ///
    /// # Errors
    /// The head is not connected, or stalls; [`DeviceError::Cancelled`]. The head has stopped then.
    pub fn return_to_start(&mut self, cancel: &Cancel) -> Result<Option<Duration>, DeviceError> {
        self.process_pending();
        let Some(pose) = self.last_start.filter(|_| self.state.is_position_trusted()) else {
            return Ok(None);
        };
        let started = self.links.now();
        let moved = self.move_to_pose(&pose, cancel);
        if let Err(error) = &moved {
            self.note_failed_move(error);
        }
        self.set_power_marker();
        moved.map(|()| Some(self.links.now().saturating_sub(started)))
    }

    /// Moves both axes to `pose` and waits until they arrive.
    pub(super) fn move_to_pose(
        &mut self,
        pose: &StartPose,
        cancel: &Cancel,
    ) -> Result<(), DeviceError> {
        let axes = [Axis::Pan, Axis::Tilt];
        for (i, axis) in axes.into_iter().enumerate() {
            self.links
                .send_head(HeadCommand::SetSpeed(axis, pose.steps_per_s[i]));
            self.links
                .send_head(HeadCommand::MoveTo(axis, pose.steps[i]));
        }
        let mut arrived = Ok(());
        for (i, axis) in axes.into_iter().enumerate() {
            let (steps, speed) = (pose.steps[i], pose.steps_per_s[i]);
            arrived = arrived.and_then(|()| self.wait_until_arrived(axis, steps, speed, cancel));
        }
        self.links.send_head(HeadCommand::PollPosition(None));
        if arrived.is_err() {
            self.links.send_head(HeadCommand::Halt);
        }
        arrived
    }

    fn wait_until_arrived(
        &mut self,
        wanted: Axis,
        target_steps: i32,
        steps_per_s: i32,
        cancel: &Cancel,
    ) -> Result<(), DeviceError> {
        let identity = self.state.head()?;
        let axis = match wanted {
            Axis::Pan => &identity.pan,
            Axis::Tilt => &identity.tilt,
        };
        // A move from an unknown position takes no longer than the whole range.
        let range = i64::from(axis.limits.max_steps) - i64::from(axis.limits.min_steps);
        let time = axis.profile(steps_per_s).travel_time(range);
        let mut watch = MoveWatch::new(target_steps, self.links.now(), time);
        let mut at_steps = target_steps;
        self.links
            .send_head(HeadCommand::PollPosition(Some(wanted)));
        loop {
            if cancel.is_cancelled() {
                return Err(DeviceError::Cancelled);
            }
            let state = match self.next_message(watch.overdue_at()) {
                Some(
                    PortMessage::Head(PortEvent::Lost { error, .. })
                    | PortMessage::Laser(PortEvent::Lost { error, .. }),
                ) => return Err(error),
                Some(PortMessage::Head(PortEvent::Device(HeadEvent::Ptu(
                    ptu::PtuEvent::Position {
                        axis,
                        steps,
                        first_byte_at,
                        ..
                    },
                )))) if axis == wanted => {
                    at_steps = steps;
                    watch.observe(steps, first_byte_at)
                }
                // A host that reads late has not seen the axis stop.
                _ if self.links.now() < watch.overdue_at() => MoveState::Moving,
                _ => MoveState::Overdue,
            };
            match state {
                MoveState::Arrived => return Ok(()),
                MoveState::Moving => {}
                MoveState::Stalled | MoveState::Overdue => {
                    let port = self.head_port.name.clone();
                    return Err(stalled_error(port, wanted, at_steps, target_steps));
                }
            }
        }
    }
}
