//! The stream of `MD` and its relatives: scans measured and sent, interruptions, the end.

use std::time::Duration;

use super::constants::{
    HARDWARE_STATUS, OLDER_STAMP_MS, REPLY_SPREAD, SIMULATION_AFTER_SCANS, SIMULATION_MIN_COUNT,
    TIMER_MASK, VERIFY_STATUS, VERIFY_TIME,
};
use super::emulated_laser::EmulatedLaser;
use super::fault::LaserFault;
use super::range_source::RangeSource;
use super::scan_reply::{MeasuredScan, blank_outside};
use super::state::{ActiveStream, Malfunction, SimulatedFailure, VerifyPause};
use super::status::ReplyStatus;
use super::wire;

impl ActiveStream {
    /// The request with the number of remaining scans in place of the count.
    fn echo(&self) -> Vec<u8> {
        let remaining = u64::from(self.count).saturating_sub(self.sent);
        let mut echo = self.head.clone();
        echo.extend_from_slice(&ReplyStatus::number((remaining % 100) as u8).0);
        echo.extend_from_slice(&self.tail);
        echo.push(b'\n');
        echo
    }

    fn status_message(&self, status: ReplyStatus) -> Vec<u8> {
        let mut message = self.echo();
        wire::push_summed(&mut message, &status.0);
        message.push(b'\n');
        message
    }
}

impl EmulatedLaser {
    /// The scan of `revolution`, measured now if it was not yet.
    pub(super) fn measure(
        &mut self,
        revolution: u64,
        t: Duration,
        source: &mut dyn RangeSource,
    ) -> &MeasuredScan {
        let before = self.scan.take();
        let scan = match before {
            Some(scan) if scan.revolution == revolution => scan,
            before => {
                let start = self.motor.start_time(revolution);
                let frozen = before.is_some() && self.faults.happens(LaserFault::FrozenData, t);
                let repeated =
                    before.is_some() && self.faults.happens(LaserFault::RepeatedStamp, t);
                let older = before.is_some() && self.faults.happens(LaserFault::OlderStamp, t);
                let (old_ranges, old_stamp) =
                    before.map_or((Vec::new(), 0), |scan| (scan.ranges, scan.stamp));
                let ranges = if frozen {
                    old_ranges
                } else {
                    self.measure_ranges(revolution, t, source)
                };
                let stamp = if repeated {
                    old_stamp
                } else if older {
                    old_stamp.wrapping_sub(OLDER_STAMP_MS) & TIMER_MASK
                } else {
                    self.timer.at(shifted(start, self.options.stamp_offset_ms))
                };
                MeasuredScan {
                    revolution,
                    stamp,
                    ranges,
                }
            }
        };
        self.scan.insert(scan)
    }

    fn measure_ranges(
        &mut self,
        revolution: u64,
        t: Duration,
        source: &mut dyn RangeSource,
    ) -> Vec<u32> {
        let profile = &self.options.profile;
        let (first_step, last_step) = (profile.first_step, profile.last_step);
        let front_step = profile.front_step as usize;
        let mut ranges = vec![0; profile.max_step as usize + 1];
        source.fill_revolution(
            self.motor.start_time(revolution),
            self.motor.period_of(revolution),
            &mut ranges,
        );
        self.faults.cover(&mut ranges, front_step, t);
        blank_outside(&mut ranges, first_step, last_step);
        ranges
    }

    /// The head has passed the last step of a revolution that the stream sends.
    pub(super) fn send_scan(&mut self, t: Duration, source: &mut dyn RangeSource) {
        if self.stop_to_verify(t) {
            return;
        }
        let Some(mut stream) = self.state.stream.take() else {
            return;
        };
        let revolution = stream.next_revolution;
        stream.next_revolution += stream.interval + 1;
        if self.out.is_busy(t) {
            // The line is slower than the scans: this one is lost whole and not counted (the protocol leaves it open).
            self.out.count_lost();
            self.state.stream = Some(stream);
            return;
        }
        stream.sent += 1;
        let mut message = stream.echo();
        wire::push_summed(&mut message, &ReplyStatus::DATA.0);
        let min_range_mm = self.options.profile.min_range_mm;
        let scan = self.measure(revolution, t, source);
        stream.window.push_scan(&mut message, scan, min_range_mm);
        message.push(b'\n');
        if stream.count > 0 && stream.sent >= u64::from(stream.count) {
            self.state.laser_on = false;
        } else {
            self.state.stream = Some(stream);
        }
        let at = t + self.rng.duration_below(REPLY_SPREAD);
        self.emit(message, t, at, true);
    }

    /// Whether the stream stops here instead of sending its scan, by a fault or by `DB`.
    fn stop_to_verify(&mut self, t: Duration) -> bool {
        let Some(stream) = &mut self.state.stream else {
            return false;
        };
        let long = stream.count == 0 || stream.count > SIMULATION_MIN_COUNT;
        let simulated = self
            .state
            .simulation
            .filter(|_| long && stream.sent == SIMULATION_AFTER_SCANS);
        let (status, time, resumes) = match (self.faults.verification(t), simulated) {
            (Some((status, time)), _) => (status, time, true),
            (None, Some(SimulatedFailure::Recovers)) => (VERIFY_STATUS, VERIFY_TIME, true),
            (None, Some(SimulatedFailure::Fails)) => (VERIFY_STATUS, VERIFY_TIME, false),
            (None, Some(SimulatedFailure::FailsAtOnce)) => {
                self.fail(
                    Malfunction {
                        status: HARDWARE_STATUS,
                        until: None,
                        simulated: true,
                    },
                    t,
                );
                return true;
            }
            _ => return false,
        };
        stream.pause = Some(VerifyPause {
            until: t.saturating_add(time),
            resumes,
        });
        self.state.laser_on = false;
        let message = stream.status_message(ReplyStatus::number(status));
        self.emit(message, t, t, false);
        true
    }

    pub(super) fn end_pause(&mut self, t: Duration) {
        let Some(stream) = &mut self.state.stream else {
            return;
        };
        let Some(pause) = stream.pause.take() else {
            return;
        };
        if !pause.resumes {
            return self.fail(
                Malfunction {
                    status: HARDWARE_STATUS,
                    until: None,
                    simulated: true,
                },
                t,
            );
        }
        stream.next_revolution = self.motor.revolution_at(t) + 1;
        let message = stream.status_message(ReplyStatus::RESUMED);
        self.state.laser_on = true;
        if self.state.simulation == Some(SimulatedFailure::Recovers) {
            self.state.simulation = None;
        }
        self.emit(message, t, t, false);
    }

    /// The laser fails; a stream ends with the status.
    pub(super) fn fail(&mut self, malfunction: Malfunction, t: Duration) {
        let message = self
            .state
            .stream
            .as_ref()
            .map(|stream| stream.status_message(ReplyStatus::number(malfunction.status)));
        self.state.stop();
        self.state.malfunction = Some(malfunction);
        if let Some(message) = message {
            self.emit(message, t, t, false);
        }
    }
}

fn shifted(at: Duration, ms: f64) -> Duration {
    let by = Duration::from_secs_f64(ms.abs() * 1e-3);
    if ms < 0.0 {
        at.saturating_sub(by)
    } else {
        at.saturating_add(by)
    }
}
