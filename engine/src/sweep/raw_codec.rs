//! Stored form of raw sweeps, so that a later calibration or version can assemble them again.

use super::raw::{HeadMotion, PanSegment, PositionPoll, RawSweep, StampedScan, TimeSample};
use crate::geometry::Mount;
use crate::scan::ScanGeometry;

const VERSION: u8 = 2;

/// The version without time offset and backlash; both were 0.
const VERSION_WITHOUT_CALIBRATION: u8 = 1;

/// Why stored bytes are no raw sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("raw sweep record: expected {expected} at byte {at}")]
pub struct RawSweepError {
    /// What was expected.
    pub expected: &'static str,
    /// Offset of it.
    pub at: usize,
}

/// Encodes a raw sweep: a version byte, scan geometry, tilts, mount and pan segments, little-endian.
pub fn encode_raw_sweep(raw: &RawSweep) -> Vec<u8> {
    let mut out = Writer(vec![VERSION]);
    let g = &raw.scan_geometry;
    for word in [
        g.steps_per_turn,
        g.front_step,
        g.first_step,
        g.cluster,
        g.dmin_mm,
        g.dmax_mm,
    ] {
        out.u32(word);
    }
    for number in [
        g.period_s,
        raw.tilt_rad_per_step,
        raw.tilt_zero_rad,
        raw.tilt_low_rad,
        raw.tilt_high_rad,
        raw.line_pitch_rad,
        raw.time_offset_s,
        raw.tilt_backlash_rad,
    ] {
        out.f64(number);
    }
    for number in raw.mount.parameters() {
        out.f64(number);
    }
    out.count(raw.pan_segments.len());
    for segment in &raw.pan_segments {
        out.pan_segment(segment);
    }
    out.0
}

/// Decodes what [`encode_raw_sweep`] wrote.
///
/// # Errors
/// What was expected, and its offset.
pub fn decode_raw_sweep(bytes: &[u8]) -> Result<RawSweep, RawSweepError> {
    let mut input = Reader { bytes, at: 0 };
    let [version] = input.take("version 1 or 2")?;
    if ![VERSION_WITHOUT_CALIBRATION, VERSION].contains(&version) {
        return Err(RawSweepError {
            expected: "version 1 or 2",
            at: 0,
        });
    }
    let calibrated = version == VERSION;
    let mut word = || input.u32("scan geometry");
    let (steps_per_turn, front_step, first_step) = (word()?, word()?, word()?);
    let (cluster, dmin_mm, dmax_mm) = (word()?, word()?, word()?);
    let scan_geometry = ScanGeometry {
        steps_per_turn,
        front_step,
        first_step,
        cluster,
        dmin_mm,
        dmax_mm,
        period_s: input.f64("period")?,
    };
    let raw = RawSweep {
        scan_geometry,
        tilt_rad_per_step: input.f64("tilt per step")?,
        tilt_zero_rad: input.f64("tilt zero")?,
        tilt_low_rad: input.f64("lowest tilt")?,
        tilt_high_rad: input.f64("highest tilt")?,
        line_pitch_rad: input.f64("line pitch")?,
        time_offset_s: input.f64_if(calibrated, "time offset")?,
        tilt_backlash_rad: input.f64_if(calibrated, "backlash")?,
        mount: input.mount()?,
        pan_segments: input.list("pan segments", Reader::pan_segment)?,
    };
    if input.at == bytes.len() {
        Ok(raw)
    } else {
        Err(RawSweepError {
            expected: "end of data",
            at: input.at,
        })
    }
}

struct Writer(Vec<u8>);

impl Writer {
    fn u32(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn count(&mut self, n: usize) {
        self.u32(u32::try_from(n).unwrap_or(u32::MAX));
    }

    fn u64(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn f64(&mut self, value: f64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn pan_segment(&mut self, segment: &PanSegment) {
        self.f64(segment.pan_rad);
        match &segment.motion {
            HeadMotion::Tilting { speed_steps_s } => {
                self.u32(0);
                self.f64(*speed_steps_s);
            }
            HeadMotion::StepAndStare { tilt_steps } => {
                self.u32(1);
                self.count(tilt_steps.len());
                for steps in tilt_steps {
                    self.u32(steps.cast_unsigned());
                }
            }
        }
        self.count(segment.scans.len());
        for scan in &segment.scans {
            self.u64(scan.stamp_ms);
            self.f64(scan.arrived_s);
            self.count(scan.values.len());
            for value in &scan.values {
                self.u32(*value);
            }
        }
        self.count(segment.polls.len());
        for poll in &segment.polls {
            self.f64(poll.sent_s);
            self.f64(poll.received_s);
            self.u32(poll.tilt_steps.cast_unsigned());
        }
        self.count(segment.time_samples.len());
        for sample in &segment.time_samples {
            self.f64(sample.sent_s);
            self.f64(sample.received_s);
            self.u64(sample.stamp_ms);
        }
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], RawSweepError> {
        let at = self.at;
        let found = self
            .bytes
            .get(at..)
            .and_then(|rest| rest.first_chunk::<N>());
        self.at += N;
        found.copied().ok_or(RawSweepError { expected, at })
    }

    fn u32(&mut self, expected: &'static str) -> Result<u32, RawSweepError> {
        Ok(u32::from_le_bytes(self.take(expected)?))
    }

    fn u64(&mut self, expected: &'static str) -> Result<u64, RawSweepError> {
        Ok(u64::from_le_bytes(self.take(expected)?))
    }

    fn f64(&mut self, expected: &'static str) -> Result<f64, RawSweepError> {
        Ok(f64::from_le_bytes(self.take(expected)?))
    }

    /// A number of version 2, 0 in version 1.
    fn f64_if(&mut self, present: bool, expected: &'static str) -> Result<f64, RawSweepError> {
        if present { self.f64(expected) } else { Ok(0.0) }
    }

    /// A count and that many items. A count too large for the data fails at the first missing item.
    fn list<T>(
        &mut self,
        expected: &'static str,
        mut item: impl FnMut(&mut Self) -> Result<T, RawSweepError>,
    ) -> Result<Vec<T>, RawSweepError> {
        let n = self.u32(expected)?;
        let mut items = Vec::new();
        for _ in 0..n {
            items.push(item(self)?);
        }
        Ok(items)
    }

    fn mount(&mut self) -> Result<Mount, RawSweepError> {
        let mut parameters = [0.0; 15];
        for parameter in &mut parameters {
            *parameter = self.f64("mount")?;
        }
        Ok(Mount::from_parameters(parameters))
    }

    fn pan_segment(&mut self) -> Result<PanSegment, RawSweepError> {
        let pan_rad = self.f64("pan")?;
        let at = self.at;
        let motion = match self.u32("motion")? {
            0 => HeadMotion::Tilting {
                speed_steps_s: self.f64("speed")?,
            },
            1 => HeadMotion::StepAndStare {
                tilt_steps: self.list("tilts", |r| Ok(r.u32("tilt")?.cast_signed()))?,
            },
            _ => {
                return Err(RawSweepError {
                    expected: "motion 0 or 1",
                    at,
                });
            }
        };
        Ok(PanSegment {
            pan_rad,
            motion,
            scans: self.list("scans", |r| {
                Ok(StampedScan {
                    stamp_ms: r.u64("stamp")?,
                    arrived_s: r.f64("arrival")?,
                    values: r.list("values", |r| r.u32("value"))?,
                })
            })?,
            polls: self.list("polls", |r| {
                Ok(PositionPoll {
                    sent_s: r.f64("poll")?,
                    received_s: r.f64("poll")?,
                    tilt_steps: r.u32("poll")?.cast_signed(),
                })
            })?,
            time_samples: self.list("time samples", |r| {
                Ok(TimeSample {
                    sent_s: r.f64("time sample")?,
                    received_s: r.f64("time sample")?,
                    stamp_ms: r.u64("time sample")?,
                })
            })?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{decode_raw_sweep, encode_raw_sweep};
    use crate::geometry::{Mount, RollPitchYaw};
    use crate::scan::ScanGeometry;
    use crate::sweep::{HeadMotion, PanSegment, PositionPoll, RawSweep, StampedScan, TimeSample};

    const SEGMENTS_AT: usize = 1 + 6 * 4 + 8 * 8 + 15 * 8;

    fn raw() -> RawSweep {
        let segment = |motion| PanSegment {
            pan_rad: 0.5,
            motion,
            scans: vec![StampedScan {
                stamp_ms: 17_000_000,
                arrived_s: 3.25,
                values: vec![0, 20, 5600],
            }],
            polls: vec![PositionPoll {
                sent_s: 3.0,
                received_s: 3.1,
                tilt_steps: -900,
            }],
            time_samples: vec![TimeSample {
                sent_s: 1.0,
                received_s: 1.1,
                stamp_ms: 5,
            }],
        };
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
            mount: Mount::new(
                [0.1, 0.2, 0.3],
                [0.4, 0.5, 0.6],
                [0.7, 0.8, 0.9],
                [1.0, 1.1, 1.2],
                RollPitchYaw {
                    roll_rad: 1.3,
                    pitch_rad: 1.4,
                    yaw_rad: 1.5,
                },
            ),
            tilt_rad_per_step: 0.0009,
            tilt_zero_rad: 0.01,
            tilt_low_rad: -0.6,
            tilt_high_rad: 0.4,
            line_pitch_rad: 0.0087,
            time_offset_s: 0.002,
            tilt_backlash_rad: -0.0003,
            pan_segments: vec![
                segment(HeadMotion::Tilting {
                    speed_steps_s: 97.0,
                }),
                segment(HeadMotion::StepAndStare {
                    tilt_steps: vec![-5],
                }),
            ],
        }
    }

    #[test]
    fn a_raw_sweep_is_decoded_and_truncated_bytes_are_refused() {
        let bytes = encode_raw_sweep(&raw());
        assert_eq!(decode_raw_sweep(&bytes).expect("reads"), raw());
        for cut in 0..bytes.len() {
            assert!(decode_raw_sweep(&bytes[..cut]).is_err(), "cut at {cut}");
        }
    }

    #[test]
    fn version_1_has_no_calibration() {
        let mut bytes = encode_raw_sweep(&raw());
        let calibration_at = 1 + 6 * 4 + 6 * 8;
        bytes.drain(calibration_at..calibration_at + 16);
        bytes[0] = 1;
        let expected = RawSweep {
            time_offset_s: 0.0,
            tilt_backlash_rad: 0.0,
            ..raw()
        };
        assert_eq!(decode_raw_sweep(&bytes), Ok(expected));
    }

    #[test]
    fn a_huge_count_is_an_error_and_not_an_allocation() {
        let mut bytes = encode_raw_sweep(&raw());
        bytes[SEGMENTS_AT..SEGMENTS_AT + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(decode_raw_sweep(&bytes).is_err());
    }

    #[test]
    fn a_motion_that_does_not_exist_is_an_error() {
        let mut bytes = encode_raw_sweep(&raw());
        // After the number of pan segments and the pan.
        let motion_at = SEGMENTS_AT + 4 + 8;
        assert_eq!(bytes[motion_at..motion_at + 4], 0_u32.to_le_bytes());
        bytes[motion_at] = 2;
        let error = decode_raw_sweep(&bytes).expect_err("no such motion");
        assert_eq!((error.expected, error.at), ("motion 0 or 1", motion_at));
    }
}
