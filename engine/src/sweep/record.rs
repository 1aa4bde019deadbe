//! Raw sweeps as bytes, so that a later calibration or engine can assemble them anew.

use super::raw::{Leg, Motion, Poll, RawScan, RawSweep, TimeSample};
use crate::geometry::Mount;
use crate::scan::Optics;

const VERSION: u8 = 2;
/// Without time offset and backlash, which were none.
const UNCALIBRATED: u8 = 1;

/// Why stored bytes are no raw sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("raw sweep record: expected {expected} at byte {at}")]
pub struct RecordError {
    /// What should have been there.
    pub expected: &'static str,
    /// Where.
    pub at: usize,
}

/// Bytes of a raw sweep: a version byte, optics, tilts, mount and legs, little-endian.
pub fn encode(raw: &RawSweep) -> Vec<u8> {
    let mut out = Writer(vec![VERSION]);
    let o = &raw.optics;
    for word in [
        o.steps_per_turn,
        o.front_step,
        o.first_step,
        o.cluster,
        o.dmin_mm,
        o.dmax_mm,
    ] {
        out.word(word);
    }
    for number in [
        o.period_s,
        raw.tilt_rad_per_step,
        raw.tilt_zero_rad,
        raw.tilt_low_rad,
        raw.tilt_high_rad,
        raw.line_pitch_rad,
        raw.time_offset_s,
        raw.tilt_backlash_rad,
    ] {
        out.number(number);
    }
    for number in raw.mount.numbers() {
        out.number(number);
    }
    out.count(raw.legs.len());
    for leg in &raw.legs {
        out.leg(leg);
    }
    out.0
}

/// The raw sweep that [`encode`] wrote.
///
/// # Errors
/// What was expected, and where.
pub fn decode(bytes: &[u8]) -> Result<RawSweep, RecordError> {
    let mut input = Reader { bytes, at: 0 };
    let [version] = input.take("version 1 or 2")?;
    if ![UNCALIBRATED, VERSION].contains(&version) {
        return Err(RecordError {
            expected: "version 1 or 2",
            at: 0,
        });
    }
    let calibrated = version == VERSION;
    let mut word = || input.word("optics");
    let (steps_per_turn, front_step, first_step) = (word()?, word()?, word()?);
    let (cluster, dmin_mm, dmax_mm) = (word()?, word()?, word()?);
    let optics = Optics {
        steps_per_turn,
        front_step,
        first_step,
        cluster,
        dmin_mm,
        dmax_mm,
        period_s: input.number("period")?,
    };
    let raw = RawSweep {
        optics,
        tilt_rad_per_step: input.number("tilt per step")?,
        tilt_zero_rad: input.number("tilt zero")?,
        tilt_low_rad: input.number("lowest tilt")?,
        tilt_high_rad: input.number("highest tilt")?,
        line_pitch_rad: input.number("line pitch")?,
        time_offset_s: input.number_if(calibrated, "time offset")?,
        tilt_backlash_rad: input.number_if(calibrated, "backlash")?,
        mount: input.mount()?,
        legs: input.list("legs", Reader::leg)?,
    };
    if input.at == bytes.len() {
        Ok(raw)
    } else {
        Err(RecordError {
            expected: "the end",
            at: input.at,
        })
    }
}

struct Writer(Vec<u8>);

impl Writer {
    fn word(&mut self, word: u32) {
        self.0.extend_from_slice(&word.to_le_bytes());
    }

    fn count(&mut self, n: usize) {
        self.word(u32::try_from(n).unwrap_or(u32::MAX));
    }

    fn long(&mut self, long: u64) {
        self.0.extend_from_slice(&long.to_le_bytes());
    }

    fn number(&mut self, number: f64) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    fn leg(&mut self, leg: &Leg) {
        self.number(leg.pan_rad);
        match &leg.motion {
            Motion::Tilting { speed_steps_s } => {
                self.word(0);
                self.number(*speed_steps_s);
            }
            Motion::Standing { tilt_steps } => {
                self.word(1);
                self.count(tilt_steps.len());
                for steps in tilt_steps {
                    self.word(steps.cast_unsigned());
                }
            }
        }
        self.count(leg.scans.len());
        for scan in &leg.scans {
            self.long(scan.stamp_ms);
            self.number(scan.arrived_s);
            self.count(scan.values.len());
            for value in &scan.values {
                self.word(*value);
            }
        }
        self.count(leg.polls.len());
        for poll in &leg.polls {
            self.number(poll.sent_s);
            self.number(poll.received_s);
            self.word(poll.tilt_steps.cast_unsigned());
        }
        self.count(leg.time_samples.len());
        for sample in &leg.time_samples {
            self.number(sample.sent_s);
            self.number(sample.received_s);
            self.long(sample.stamp_ms);
        }
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], RecordError> {
        let at = self.at;
        let found = self
            .bytes
            .get(at..)
            .and_then(|rest| rest.first_chunk::<N>());
        self.at += N;
        found.copied().ok_or(RecordError { expected, at })
    }

    fn word(&mut self, expected: &'static str) -> Result<u32, RecordError> {
        Ok(u32::from_le_bytes(self.take(expected)?))
    }

    fn long(&mut self, expected: &'static str) -> Result<u64, RecordError> {
        Ok(u64::from_le_bytes(self.take(expected)?))
    }

    fn number(&mut self, expected: &'static str) -> Result<f64, RecordError> {
        Ok(f64::from_le_bytes(self.take(expected)?))
    }

    /// A number of later versions, 0 in earlier ones.
    fn number_if(&mut self, there: bool, expected: &'static str) -> Result<f64, RecordError> {
        if there {
            self.number(expected)
        } else {
            Ok(0.0)
        }
    }

    /// A count and so many items. A count that the bytes cannot hold fails at its first missing item.
    fn list<T>(
        &mut self,
        expected: &'static str,
        mut item: impl FnMut(&mut Self) -> Result<T, RecordError>,
    ) -> Result<Vec<T>, RecordError> {
        let n = self.word(expected)?;
        let mut items = Vec::new();
        for _ in 0..n {
            items.push(item(self)?);
        }
        Ok(items)
    }

    fn mount(&mut self) -> Result<Mount, RecordError> {
        let mut numbers = [0.0; 15];
        for number in &mut numbers {
            *number = self.number("mount")?;
        }
        Ok(Mount::of_numbers(numbers))
    }

    fn leg(&mut self) -> Result<Leg, RecordError> {
        let pan_rad = self.number("pan")?;
        let at = self.at;
        let motion = match self.word("motion")? {
            0 => Motion::Tilting {
                speed_steps_s: self.number("speed")?,
            },
            1 => Motion::Standing {
                tilt_steps: self.list("tilts", |r| Ok(r.word("tilt")?.cast_signed()))?,
            },
            _ => {
                return Err(RecordError {
                    expected: "motion 0 or 1",
                    at,
                });
            }
        };
        Ok(Leg {
            pan_rad,
            motion,
            scans: self.list("scans", |r| {
                Ok(RawScan {
                    stamp_ms: r.long("stamp")?,
                    arrived_s: r.number("arrival")?,
                    values: r.list("values", |r| r.word("value"))?,
                })
            })?,
            polls: self.list("polls", |r| {
                Ok(Poll {
                    sent_s: r.number("poll")?,
                    received_s: r.number("poll")?,
                    tilt_steps: r.word("poll")?.cast_signed(),
                })
            })?,
            time_samples: self.list("time samples", |r| {
                Ok(TimeSample {
                    sent_s: r.number("time sample")?,
                    received_s: r.number("time sample")?,
                    stamp_ms: r.long("time sample")?,
                })
            })?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{decode, encode};
    use crate::geometry::{Mount, RollPitchYaw};
    use crate::scan::Optics;
    use crate::sweep::{Leg, Motion, Poll, RawScan, RawSweep, TimeSample};

    const LEGS_AT: usize = 1 + 6 * 4 + 8 * 8 + 15 * 8;

    fn raw() -> RawSweep {
        let leg = |motion| Leg {
            pan_rad: 0.5,
            motion,
            scans: vec![RawScan {
                stamp_ms: 17_000_000,
                arrived_s: 3.25,
                values: vec![0, 20, 5600],
            }],
            polls: vec![Poll {
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
            optics: Optics {
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
            legs: vec![
                leg(Motion::Tilting {
                    speed_steps_s: 97.0,
                }),
                leg(Motion::Standing {
                    tilt_steps: vec![-5],
                }),
            ],
        }
    }

    #[test]
    fn a_raw_sweep_comes_back_and_cut_bytes_do_not() {
        let bytes = encode(&raw());
        assert_eq!(decode(&bytes).expect("reads"), raw());
        for cut in 0..bytes.len() {
            assert!(decode(&bytes[..cut]).is_err(), "cut at {cut}");
        }
    }

    #[test]
    fn a_record_from_before_the_calibration_has_none() {
        let mut bytes = encode(&raw());
        let calibration_at = 1 + 6 * 4 + 6 * 8;
        bytes.drain(calibration_at..calibration_at + 16);
        bytes[0] = 1;
        let expected = RawSweep {
            time_offset_s: 0.0,
            tilt_backlash_rad: 0.0,
            ..raw()
        };
        assert_eq!(decode(&bytes), Ok(expected));
    }

    #[test]
    fn a_huge_count_is_an_error_and_not_an_allocation() {
        let mut bytes = encode(&raw());
        bytes[LEGS_AT..LEGS_AT + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(decode(&bytes).is_err());
    }

    #[test]
    fn a_motion_that_does_not_exist_is_an_error() {
        let mut bytes = encode(&raw());
        // After the number of legs and the pan.
        let motion_at = LEGS_AT + 4 + 8;
        assert_eq!(bytes[motion_at..motion_at + 4], 0_u32.to_le_bytes());
        bytes[motion_at] = 2;
        let error = decode(&bytes).expect_err("no such motion");
        assert_eq!((error.expected, error.at), ("motion 0 or 1", motion_at));
    }
}
