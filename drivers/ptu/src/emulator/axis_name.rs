//! The two axes.

use std::fmt;

/// One of the two axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AxisName {
    /// Rotates about the vertical; positive is to the left.
    Pan,
    /// Rotates about the lateral axis; positive is up.
    Tilt,
}

impl AxisName {
    /// Both axes, pan first.
    pub const BOTH: [AxisName; 2] = [AxisName::Pan, AxisName::Tilt];

    /// Index into a `[pan, tilt]` pair.
    pub(super) fn index(self) -> usize {
        match self {
            AxisName::Pan => 0,
            AxisName::Tilt => 1,
        }
    }

    /// What the unit prints when this axis hits its stop (ptu-d46 section 2).
    pub(super) fn limit_event(self) -> &'static [u8] {
        match self {
            AxisName::Pan => b"!P",
            AxisName::Tilt => b"!T",
        }
    }
}

impl fmt::Display for AxisName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            AxisName::Pan => "Pan",
            AxisName::Tilt => "Tilt",
        })
    }
}
