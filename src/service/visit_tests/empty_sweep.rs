//! A sweep without a scan.

use crate::config::Settings;
use patrold_engine::scan::ScanGeometry;
use patrold_engine::sweep::RawSweep;

pub(in crate::service) fn empty_sweep() -> RawSweep {
    RawSweep {
        scan_geometry: ScanGeometry {
            steps_per_turn: 1024,
            front_step: 384,
            first_step: 44,
            cluster: 1,
            dmin_mm: 20,
            dmax_mm: 5600,
            period_s: 0.1,
        },
        mount: Settings::defaults().mount.chain(),
        tilt_rad_per_step: 0.0009,
        tilt_zero_rad: 0.0,
        tilt_low_rad: -0.6,
        tilt_high_rad: 0.4,
        line_pitch_rad: 0.0087,
        time_offset_s: 0.0,
        tilt_backlash_rad: 0.0,
        pan_segments: Vec::new(),
    }
}
