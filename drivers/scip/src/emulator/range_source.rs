//! Where ranges come from.

use std::time::Duration;

/// The surroundings of the emulated laser, as ranges.
pub trait RangeSource {
    /// Fills in the range at each step of one revolution.
    ///
    /// `start` is the instant of step 0; step `n` is measured at `start + n * period / ARES`, with the profile's steps per
    /// revolution (1024 of a URG-04LX). `out[n]` takes a range in millimetres or a code below the profile's DMIN (scip2
    /// section 7). `out` has an element for every step that can be requested (769 of a URG-04LX), all 0 (nothing
    /// detected) at first. Steps outside the measuring window are set to code 19 afterwards.
    fn fill_revolution(&mut self, start: Duration, period: Duration, out: &mut [u32]);
}
