//! The sensor's timer: 24 bits of milliseconds, zero at power-up and after `RS` (scip2 section 8).

/// The timer wraps here: 2^24 ms = 4 h 39 min 37.216 s.
pub const STAMP_MODULUS_MS: u32 = 1 << 24;

/// Milliseconds from `earlier` to `later`, both 24-bit stamps, across at most one wrap. A stamp that went back gives a
/// very large advance.
#[must_use]
pub fn stamp_advance_ms(earlier: u32, later: u32) -> u32 {
    later.wrapping_sub(earlier) & (STAMP_MODULUS_MS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_advance_is_modular() {
        assert_eq!(stamp_advance_ms(0, 100), 100);
        assert_eq!(stamp_advance_ms(STAMP_MODULUS_MS - 40, 60), 100);
        assert_eq!(stamp_advance_ms(7, 7), 0);
        assert_eq!(stamp_advance_ms(100, 0), STAMP_MODULUS_MS - 100);
        // II at TIME 6A5404 and again at 6A55F8 while the host saw 498 ms.
        assert_eq!(stamp_advance_ms(0x6A_5404, 0x6A_55F8), 500);
    }
}
