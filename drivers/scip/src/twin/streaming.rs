//! Scans as they are measured and sent: the stream of `MD` and `MS`, its stops and its end.

use std::time::Duration;

use super::constants::{
    HARDWARE_STATUS, OLDER_STAMP_MS, REHEARSAL_AFTER_SCANS, REHEARSAL_MIN_COUNT, REPLY_SPREAD,
    TIMER_MASK, VERIFY_STATUS, VERIFY_TIME,
};
use super::engine::Twin;
use super::fault::Fault;
use super::scanning::{Scan, blank_outside};
use super::state::{Malfunction, Pause, Rehearsal, Status, Stream};
use super::surroundings::Surroundings;
use super::{Instant, wire};

impl Stream {
    /// The echo of the stream's messages: the request with the scans that remain in place of the count.
    fn echo(&self) -> Vec<u8> {
        let remaining = u64::from(self.count).saturating_sub(self.sent);
        let mut echo = self.head.clone();
        echo.extend_from_slice(&Status::number((remaining % 100) as u8).0);
        echo.extend_from_slice(&self.tail);
        echo.push(b'\n');
        echo
    }

    /// A message that is a status and no more.
    fn told(&self, status: Status) -> Vec<u8> {
        let mut message = self.echo();
        wire::push_summed(&mut message, &status.0);
        message.push(b'\n');
        message
    }
}

impl Twin {
    /// The scan of `revolution`, measured now if nobody has asked for it before.
    pub(super) fn measure(
        &mut self,
        revolution: u64,
        t: Instant,
        surroundings: &mut dyn Surroundings,
    ) -> &Scan {
        let before = self.scan.take();
        let scan = match before {
            Some(scan) if scan.revolution == revolution => scan,
            before => {
                let start = self.motor.start_of(revolution);
                let frozen = before.is_some() && self.faults.happens(Fault::FrozenData, t);
                let repeated = before.is_some() && self.faults.happens(Fault::RepeatedStamp, t);
                let older = before.is_some() && self.faults.happens(Fault::OlderStamp, t);
                let (old_ranges, old_stamp) =
                    before.map_or((Vec::new(), 0), |scan| (scan.ranges, scan.stamp));
                let ranges = if frozen {
                    old_ranges
                } else {
                    self.look(revolution, t, surroundings)
                };
                let stamp = if repeated {
                    old_stamp
                } else if older {
                    old_stamp.wrapping_sub(OLDER_STAMP_MS) & TIMER_MASK
                } else {
                    self.timer.at(shifted(start, self.options.stamp_offset_ms))
                };
                Scan {
                    revolution,
                    stamp,
                    ranges,
                }
            }
        };
        self.scan.insert(scan)
    }

    fn look(
        &mut self,
        revolution: u64,
        t: Instant,
        surroundings: &mut dyn Surroundings,
    ) -> Vec<u32> {
        let profile = &self.options.profile;
        let (first_step, last_step) = (profile.first_step, profile.last_step);
        let front_step = profile.front_step as usize;
        let mut ranges = vec![0; profile.max_step as usize + 1];
        surroundings.revolve(
            self.motor.start_of(revolution),
            self.motor.period_of(revolution),
            &mut ranges,
        );
        self.faults.cover(&mut ranges, front_step, t);
        blank_outside(&mut ranges, first_step, last_step);
        ranges
    }

    /// The head has passed the last step of a revolution that the stream sends.
    pub(super) fn send_scan(&mut self, t: Instant, surroundings: &mut dyn Surroundings) {
        if self.stop_to_verify(t) {
            return;
        }
        let Some(mut stream) = self.state.stream.take() else {
            return;
        };
        let revolution = stream.next_revolution;
        stream.next_revolution += stream.interval + 1;
        if self.out.is_busy(t) {
            // The line is slower than the scans: one is lost whole and not counted (the protocol leaves it open).
            self.out.lose();
            self.state.stream = Some(stream);
            return;
        }
        stream.sent += 1;
        let mut message = stream.echo();
        wire::push_summed(&mut message, &Status::DATA.0);
        let min_range_mm = self.options.profile.min_range_mm;
        let scan = self.measure(revolution, t, surroundings);
        stream.window.push_scan(&mut message, scan, min_range_mm);
        message.push(b'\n');
        if stream.count > 0 && stream.sent >= u64::from(stream.count) {
            self.state.laser = false;
        } else {
            self.state.stream = Some(stream);
        }
        let at = t + self.noise.spread(REPLY_SPREAD);
        self.emit(message, t, at, true);
    }

    /// Whether the stream stops here instead of sending its scan: by a fault or by what `DB` plays.
    fn stop_to_verify(&mut self, t: Instant) -> bool {
        let Some(stream) = &mut self.state.stream else {
            return false;
        };
        let long = stream.count == 0 || stream.count > REHEARSAL_MIN_COUNT;
        let played = self
            .state
            .rehearsal
            .filter(|_| long && stream.sent == REHEARSAL_AFTER_SCANS);
        let (status, time, resumes) = match (self.faults.verification(t), played) {
            (Some((status, time)), _) => (status, time, true),
            (None, Some(Rehearsal::Recovers)) => (VERIFY_STATUS, VERIFY_TIME, true),
            (None, Some(Rehearsal::Fails)) => (VERIFY_STATUS, VERIFY_TIME, false),
            (None, Some(Rehearsal::FailsAtOnce)) => {
                self.fail(
                    Malfunction {
                        status: HARDWARE_STATUS,
                        until: None,
                        rehearsed: true,
                    },
                    t,
                );
                return true;
            }
            _ => return false,
        };
        stream.pause = Some(Pause {
            until: t.saturating_add(time),
            resumes,
        });
        self.state.laser = false;
        let message = stream.told(Status::number(status));
        self.emit(message, t, t, false);
        true
    }

    /// The stop to verify an error is over.
    pub(super) fn end_pause(&mut self, t: Instant) {
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
                    rehearsed: true,
                },
                t,
            );
        }
        stream.next_revolution = self.motor.revolution_at(t) + 1;
        let message = stream.told(Status::RESUMED);
        self.state.laser = true;
        if self.state.rehearsal == Some(Rehearsal::Recovers) {
            self.state.rehearsal = None;
        }
        self.emit(message, t, t, false);
    }

    /// The laser fails: a stream ends with the status.
    pub(super) fn fail(&mut self, malfunction: Malfunction, t: Instant) {
        let message = self
            .state
            .stream
            .as_ref()
            .map(|stream| stream.told(Status::number(malfunction.status)));
        self.state.stop();
        self.state.malfunction = Some(malfunction);
        if let Some(message) = message {
            self.emit(message, t, t, false);
        }
    }
}

/// An instant some milliseconds later, or earlier.
fn shifted(at: Instant, ms: f64) -> Instant {
    let by = Duration::from_secs_f64(ms.abs() * 1e-3);
    if ms < 0.0 {
        at.saturating_sub(by)
    } else {
        at.saturating_add(by)
    }
}
