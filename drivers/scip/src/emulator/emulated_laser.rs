//! The emulated laser: what is due next, and when.

use std::collections::VecDeque;

use super::constants::{ETHERNET_TICK, FLOOD_BYTES, GARBAGE_BYTES, MAX_PENDING, TM_LATENCY};
use super::fault::{LaserFault, LaserFaultSchedule, LaserFaultSpec};
use super::motor::Motor;
use super::options::LaserOptions;
use super::output::{LaserOutput, LaserTransmitter};
use super::range_source::RangeSource;
use super::request::{RequestLine, RequestReader};
use super::rng::JitterRng;
use super::scan_reply::MeasuredScan;
use super::state::{LaserState, Malfunction, ProtocolVersion};
use super::status::ReplyStatus;
use super::timer::Timer;
use super::wire;
use std::time::Duration;

#[derive(Debug, Clone)]
struct QueuedRequest {
    request: RequestLine,
    arrived_at: Duration,
    /// The same command was still in progress when this one arrived.
    duplicate: bool,
}

/// What happens without a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DueTask {
    Fault,
    Reboot,
    Scan,
    EndOfPause,
    Command,
}

/// A laser in virtual time.
///
/// Call [`advance`](Self::advance) before [`handle_bytes`](Self::handle_bytes), and poll after both. Time never goes back:
/// an earlier instant counts as the latest so far.
#[derive(Debug, Clone)]
pub struct EmulatedLaser {
    pub(super) options: LaserOptions,
    pub(super) timer: Timer,
    pub(super) motor: Motor,
    pub(super) rng: JitterRng,
    pub(super) state: LaserState,
    pub(super) scan: Option<MeasuredScan>,
    pub(super) faults: LaserFaultSchedule,
    pub(super) out: LaserTransmitter,
    input: RequestReader,
    pending: VecDeque<QueuedRequest>,
    last_command_at: Duration,
    now: Duration,
}

impl EmulatedLaser {
    /// A laser whose power comes on at `now`, or long before, depending on its start state.
    pub fn new(options: LaserOptions, now: Duration) -> Self {
        Self {
            timer: Timer::new(now, options.timer_start_ms, options.clock_rate_error),
            motor: motor(&options, now),
            rng: JitterRng::new(options.seed),
            state: LaserState::at_start(&options),
            scan: None,
            faults: LaserFaultSchedule::default(),
            out: LaserTransmitter::new(options.link, options.profile.generation.has_intensity()),
            input: RequestReader::default(),
            pending: VecDeque::new(),
            last_command_at: now,
            now,
            options,
        }
    }

    /// Takes bytes from the host. The replies come by later calls of [`advance`](Self::advance).
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.now = self.now.max(now);
        if !self.out.rates_agree() {
            // The receiver sees framing errors only.
            self.input.clear();
            return;
        }
        for byte in bytes {
            let Some(request) = self.input.push(*byte) else {
                continue;
            };
            if self.pending.len() < MAX_PENDING {
                self.pending.push_back(QueuedRequest {
                    request,
                    arrived_at: self.now,
                    duplicate: false,
                });
            } else {
                self.refuse(&request);
            }
        }
    }

    /// The queue is full: refuses at once.
    fn refuse(&mut self, request: &RequestLine) {
        let mut reply = request.line().to_vec();
        if self.state.protocol == ProtocolVersion::Scip1 {
            reply.extend_from_slice(b"\nE\n\n");
        } else {
            reply.push(b'\n');
            wire::push_summed(&mut reply, &ReplyStatus::BUFFER_SHORTAGE.0);
            reply.push(b'\n');
        }
        self.emit(reply, self.now, self.now, false);
    }

    /// Does everything that is due up to `now`. In a step of more than some 50 s the later scans of a stream are lost, as
    /// with a host that does not read.
    pub fn advance(&mut self, now: Duration, source: &mut dyn RangeSource) {
        self.now = self.now.max(now);
        while let Some((t, task)) = self.next_task().filter(|(t, _)| *t <= self.now) {
            match task {
                DueTask::Fault => self.apply_fault(t),
                DueTask::Reboot => self.power_up(t),
                DueTask::Scan => self.send_scan(t, source),
                DueTask::EndOfPause => self.end_pause(t),
                DueTask::Command => self.take_command(t, source),
            }
        }
    }

    /// The next bytes that have reached the host by the latest instant, in order.
    pub fn poll_output(&mut self) -> Option<LaserOutput> {
        self.out.take(self.now)
    }

    /// When something is due or can be polled next; `None` until the host sends something.
    pub fn next_event(&self) -> Option<Duration> {
        let task = self.next_task().map(|(t, _)| t);
        [task, self.out.next_at()].into_iter().flatten().min()
    }

    /// Injects a fault.
    pub fn inject(&mut self, spec: LaserFaultSpec) {
        self.faults.inject(spec, self.now);
    }

    /// Power off and on: bytes on the line are lost, the timer starts from 0. Unlimited faults of the firmware end; a
    /// covered window stays covered.
    pub fn power_cycle(&mut self, now: Duration) {
        self.now = self.now.max(now);
        self.power_up(self.now);
        self.faults.power_cycled(self.now);
    }

    /// The host changes its bit rate. No effect on USB.
    pub fn set_host_baud(&mut self, baud: u32) {
        self.out.set_host_baud(baud);
    }

    /// Whether the laser is on.
    pub fn laser_on(&self) -> bool {
        self.state.laser_on
    }

    /// Whether a stream is active.
    pub fn streaming(&self) -> bool {
        self.state.stream.is_some()
    }

    /// The sensor's timer at `t`, ms (24 bits).
    pub fn timer_ms(&self, t: Duration) -> u32 {
        self.timer.at(t)
    }

    /// Replies and scans that were not sent: the host did not read, the line was too slow, or a silence was injected.
    pub fn lost_replies(&self) -> u64 {
        self.out.lost_replies()
    }

    fn power_up(&mut self, t: Duration) {
        self.state = LaserState::powered_up(&self.options);
        self.timer = Timer::new(t, 0, self.options.clock_rate_error);
        self.motor = motor(&self.options, t);
        self.scan = None;
        self.input.clear();
        self.pending.clear();
        self.last_command_at = t;
        self.out.drop_after(t);
        self.out.reset_baud();
    }

    fn next_task(&self) -> Option<(Duration, DueTask)> {
        let fault = self.faults.next_event().map(|at| (at, DueTask::Fault));
        let reboot = self.state.reboot_at.map(|at| (at, DueTask::Reboot));
        let stream = self.state.stream.as_ref().map(|stream| match stream.pause {
            Some(pause) => (pause.until, DueTask::EndOfPause),
            None => (
                self.motor.step_time(
                    stream.next_revolution,
                    u64::from(self.options.profile.max_step),
                ),
                DueTask::Scan,
            ),
        });
        let command = self
            .pending
            .front()
            .map(|pending| (self.due(pending), DueTask::Command));
        // At equal instants the order of this list decides.
        [fault, reboot, stream, command]
            .into_iter()
            .flatten()
            .min_by_key(|(t, _)| *t)
    }

    fn due(&self, pending: &QueuedRequest) -> Duration {
        let earliest = pending.arrived_at.max(self.last_command_at);
        if pending.duplicate {
            earliest
        } else if pending.request.is_time() {
            earliest + TM_LATENCY
        } else if self.options.profile.generation.is_ethernet() {
            next_tick(earliest)
        } else {
            self.motor.tick_after(earliest)
        }
    }

    fn take_command(&mut self, t: Duration, source: &mut dyn RangeSource) {
        let Some(QueuedRequest {
            request, duplicate, ..
        }) = self.pending.pop_front()
        else {
            return;
        };
        self.last_command_at = t;
        if self.state.protocol == ProtocolVersion::Scip2 && !duplicate {
            let repeats = self
                .pending
                .iter_mut()
                .filter(|other| other.arrived_at <= t && other.request.repeats(&request));
            repeats.for_each(|repeat| repeat.duplicate = true);
        }
        self.answer(&request, duplicate, t, source);
    }

    fn apply_fault(&mut self, t: Duration) {
        match self.faults.take_due(t) {
            Some((LaserFault::Garbage, _)) => {
                let burst: Vec<u8> = (0..GARBAGE_BYTES).map(|_| self.rng.byte()).collect();
                self.emit(burst, t, t, false);
            }
            Some((LaserFault::Flood, _)) => self.emit(vec![0xFF; FLOOD_BYTES], t, t, false),
            Some((LaserFault::EndlessLine, _)) => self.emit(vec![b'0'; FLOOD_BYTES], t, t, false),
            Some((LaserFault::Hardware { status }, duration)) => {
                let until = duration.and_then(|duration| t.checked_add(duration));
                let malfunction = Malfunction {
                    status,
                    until,
                    simulated: false,
                };
                self.fail(malfunction, t);
            }
            Some((LaserFault::BrownOut, _)) => self.power_up(t),
            Some((LaserFault::TimerJump { by_ms }, _)) => self.timer.jump(by_ms, t),
            Some((LaserFault::TimerSet { to_ms }, _)) => self.timer.set(to_ms, t),
            Some((fault, _)) => self.set_leftover_state(fault, t),
            None => {}
        }
    }

    /// A state left over from another host or an interrupted update.
    fn set_leftover_state(&mut self, fault: LaserFault, t: Duration) {
        self.state.stop();
        self.state.protocol = ProtocolVersion::Scip2;
        self.state.time_adjust = fault == LaserFault::LeftInTimeAdjust;
        self.state.firmware_update = fault == LaserFault::FirmwareUpdate;
        if fault == LaserFault::LeftStreaming {
            let next = self.motor.revolution_at(t) + 1;
            self.state.start_default_stream(&self.options, next);
        }
    }

    /// Sends a reply of instant `t` from `at` on, subject to faults.
    pub(super) fn emit(
        &mut self,
        mut reply: Vec<u8>,
        t: Duration,
        at: Duration,
        carries_scan: bool,
    ) {
        if self.faults.happens(LaserFault::Silence, t) {
            return self.out.count_lost();
        }
        if carries_scan {
            self.faults.corrupt_scan(&mut reply, t, &mut self.rng);
        }
        self.out.send(&reply, at, &mut self.rng);
    }
}

/// The motor in host time: its own rate error and that of the timer that paces it add up.
fn motor(options: &LaserOptions, start: Duration) -> Motor {
    let rate = (1.0 + options.motor_rate_error) * (1.0 + options.clock_rate_error);
    Motor::new(
        start,
        options.profile.speed_rpm,
        rate,
        options.profile.steps_per_revolution,
    )
}

/// The first tick of an Ethernet model after `t`.
fn next_tick(t: Duration) -> Duration {
    let tick = ETHERNET_TICK.as_nanos();
    let next = (t.as_nanos() / tick + 1) * tick;
    Duration::from_nanos(u64::try_from(next).unwrap_or(u64::MAX))
}
