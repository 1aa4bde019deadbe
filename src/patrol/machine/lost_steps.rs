//! Homing the head: at once where a sweep does not fit its reference, so that the place is swept again; at an idle moment where
//! past views say that steps may be lost, and once a round.

use super::{DeviceAvailability, PatrolMachine, RequestStage};
use crate::patrol::action::PatrolAction;
use crate::patrol::severity::Severity;
use crate::patrol::turn_history::HomingReason;
use std::time::Duration;

impl PatrolMachine {
    /// Only homing distinguishes lost steps from a robot elsewhere.
    pub(super) fn lost_steps_suspected(
        &mut self,
        id: u64,
        reason: &str,
        out: &mut Vec<PatrolAction>,
    ) {
        let Some(request) = self.take_current(id, RequestStage::Judging) else {
            return;
        };
        let text = format!(
            "{}: {reason}; homing the head, then the place is swept again",
            request.waypoint
        );
        out.extend([
            PatrolAction::LogEvent(Severity::Warning, text),
            PatrolAction::DistrustHead,
        ]);
        self.start_sweep(request, out);
    }

    /// Homes the head where no request waits: the robot has its answer and drives on.
    pub(super) fn home_if_due(&mut self, now: Duration, out: &mut Vec<PatrolAction>) {
        if self.devices != DeviceAvailability::Ready {
            return;
        }
        let Some(reason) = self.turns.reason_to_home(now) else {
            return;
        };
        self.devices = DeviceAvailability::Homing;
        let event = match reason {
            HomingReason::LostSteps(why) => {
                PatrolAction::LogEvent(Severity::Warning, format!("{why}; homing it"))
            }
            HomingReason::RoundOver => PatrolAction::LogEvent(
                Severity::Info,
                "a round is over; homing the head".to_owned(),
            ),
        };
        out.extend([event, PatrolAction::HomeHead]);
    }

    pub(super) fn homing_done(&mut self, now: Duration, out: &mut Vec<PatrolAction>) {
        if self.devices != DeviceAvailability::Homing {
            return;
        }
        // Whether or not its scanner counts homings: the reason is gone.
        self.turns.homed(now);
        self.devices = DeviceAvailability::Ready;
        if let Some(request) = self.take_waiting_for_devices() {
            self.start_sweep(request, out);
        }
    }
}
