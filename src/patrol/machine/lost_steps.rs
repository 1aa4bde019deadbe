//! A sweep that does not fit the reference at the head's angles: home, sweep again, judge the new sweep.

use super::{PatrolMachine, RequestStage};
use crate::patrol::action::PatrolAction;
use crate::patrol::severity::Severity;

impl PatrolMachine {
    /// Only homing distinguishes lost steps from a rotated robot.
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
}
