//! What the machine does about a sweep that does not fit at the head's angles: home, sweep again, and judge that.

use super::{Machine, Step};
use crate::patrol::action::{Action, Weight};

impl Machine {
    /// Only a calibration tells lost steps from a robot that stands askew.
    pub(super) fn doubted(&mut self, id: u64, reason: &str, out: &mut Vec<Action>) {
        let Some(request) = self.take(id, Step::Judging) else {
            return;
        };
        let text = format!(
            "{}: {reason}; the head is homed and the place swept again",
            request.waypoint
        );
        out.extend([Action::Note(Weight::Warning, text), Action::DistrustHead]);
        self.sweep(request, out);
    }
}
