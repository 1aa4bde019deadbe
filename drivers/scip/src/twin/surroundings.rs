//! What the head looks at.

use std::time::Duration;

use super::Instant;

/// The world as the twin's head sees it.
pub trait Surroundings {
    /// What the head reads at each step of one revolution.
    ///
    /// `start` is the instant at which the head passes step 0; step `n` is measured at `start + n * period / ARES`, ARES
    /// being the profile's steps per revolution (1024 of a URG-04LX). Fill `out[n]` with a range in millimetres or with
    /// a code below the profile's DMIN (protocol section 7). `out` has an element for every step that can be asked for
    /// (769 of a URG-04LX) and comes filled with code 0 (nothing there). Steps outside the sensor's measuring window are
    /// replaced by code 19 afterwards.
    fn revolve(&mut self, start: Instant, period: Duration, out: &mut [u32]);
}
