//! What happens next, and when: the twin itself.

use std::collections::VecDeque;

use super::Instant;
use super::constants::{ETHERNET_TICK, FLOOD_BYTES, GARBAGE_BYTES, MAX_PENDING, TM_LATENCY};
use super::fault::{Fault, FaultBoard, FaultSpec};
use super::motor::Motor;
use super::noise::Noise;
use super::options::TwinOptions;
use super::output::{Output, Transmitter};
use super::request::{LineReader, Request};
use super::scanning::Scan;
use super::state::{Malfunction, Protocol, State, Status};
use super::surroundings::Surroundings;
use super::timer::Timer;
use super::wire;

/// A request that waits to be taken.
#[derive(Debug, Clone)]
struct Pending {
    request: Request,
    arrival: Instant,
    /// The same command was still in progress when it came.
    duplicate: bool,
}

/// The things that happen by themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Work {
    Fault,
    Reboot,
    Scan,
    EndOfPause,
    Command,
}

/// A sensor in virtual time.
///
/// Call [`advance`](Self::advance) up to the present before [`handle_bytes`](Self::handle_bytes), and poll after both.
/// Instants never go back: an earlier one counts as the latest seen.
#[derive(Debug, Clone)]
pub struct Twin {
    pub(super) options: TwinOptions,
    pub(super) timer: Timer,
    pub(super) motor: Motor,
    pub(super) noise: Noise,
    pub(super) state: State,
    pub(super) scan: Option<Scan>,
    pub(super) faults: FaultBoard,
    pub(super) out: Transmitter,
    input: LineReader,
    pending: VecDeque<Pending>,
    /// When the last command was taken.
    taken: Instant,
    now: Instant,
}

impl Twin {
    /// A twin whose power comes on at `now` (or long before, if its start state says so).
    pub fn new(options: TwinOptions, now: Instant) -> Self {
        Self {
            timer: Timer::new(now, options.timer_start_ms, options.clock_rate_error),
            motor: motor(&options, now),
            noise: Noise::new(options.seed),
            state: State::found(&options),
            scan: None,
            faults: FaultBoard::default(),
            out: Transmitter::new(options.link, options.profile.generation.has_intensity()),
            input: LineReader::default(),
            pending: VecDeque::new(),
            taken: now,
            now,
            options,
        }
    }

    /// Takes bytes from the host. They are answered by later calls of [`advance`](Self::advance).
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Instant) {
        self.now = self.now.max(now);
        if !self.out.rates_agree() {
            // Framing errors only: the receiver finds nothing to keep.
            self.input.clear();
            return;
        }
        for byte in bytes {
            let Some(request) = self.input.push(*byte) else {
                continue;
            };
            if self.pending.len() < MAX_PENDING {
                self.pending.push_back(Pending {
                    request,
                    arrival: self.now,
                    duplicate: false,
                });
            } else {
                self.refuse(&request);
            }
        }
    }

    /// No room for another request: told at once.
    fn refuse(&mut self, request: &Request) {
        let mut reply = request.line().to_vec();
        if self.state.protocol == Protocol::Scip1 {
            reply.extend_from_slice(b"\nE\n\n");
        } else {
            reply.push(b'\n');
            wire::push_summed(&mut reply, &Status::BUFFER_SHORTAGE.0);
            reply.push(b'\n');
        }
        self.emit(reply, self.now, self.now, false);
    }

    /// Lets everything happen that falls due up to `now`. `surroundings` are asked for a revolution only where a scan
    /// is sent. A leap of more than some 50 s of unread scans loses the later ones, as with a host that does not read.
    pub fn advance(&mut self, now: Instant, surroundings: &mut dyn Surroundings) {
        self.now = self.now.max(now);
        while let Some((t, work)) = self.next_work().filter(|(t, _)| *t <= self.now) {
            match work {
                Work::Fault => self.happen(t),
                Work::Reboot => self.power_up(t),
                Work::Scan => self.send_scan(t, surroundings),
                Work::EndOfPause => self.end_pause(t),
                Work::Command => self.take_command(t, surroundings),
            }
        }
    }

    /// The next bytes that have reached the host by the latest instant the twin was told of, in order.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.out.take(self.now)
    }

    /// When there is something to do or to poll next; `None` while nothing but the host can change that.
    pub fn next_event(&self) -> Option<Instant> {
        let work = self.next_work().map(|(t, _)| t);
        [work, self.out.next_at()].into_iter().flatten().min()
    }

    /// Sets a fault.
    pub fn inject(&mut self, spec: FaultSpec) {
        self.faults.inject(spec, self.now);
    }

    /// Takes the power away and gives it back: bytes on the line are lost, the timer starts from 0. A fault of the
    /// firmware without limit ends; a covered window stays covered.
    pub fn power_cycle(&mut self, now: Instant) {
        self.now = self.now.max(now);
        self.power_up(self.now);
        self.faults.power_cycled(self.now);
    }

    /// The host sets its own bit rate. Has no effect on USB.
    pub fn set_host_baud(&mut self, baud: u32) {
        self.out.set_host_baud(baud);
    }

    /// Whether the laser is on.
    pub fn laser_on(&self) -> bool {
        self.state.laser
    }

    /// Whether scans are being sent until further notice.
    pub fn streaming(&self) -> bool {
        self.state.stream.is_some()
    }

    /// The sensor's timer at `t`, ms (24 bits).
    pub fn timer_ms(&self, t: Instant) -> u32 {
        self.timer.at(t)
    }

    /// Replies and scans that were never sent: the host did not read, the line was too slow, or silence was set.
    pub fn lost_replies(&self) -> u64 {
        self.out.lost_replies()
    }

    fn power_up(&mut self, t: Instant) {
        self.state = State::powered_up(&self.options);
        self.timer = Timer::new(t, 0, self.options.clock_rate_error);
        self.motor = motor(&self.options, t);
        self.scan = None;
        self.input.clear();
        self.pending.clear();
        self.taken = t;
        self.out.cut(t);
        self.out.reset_baud();
    }

    fn next_work(&self) -> Option<(Instant, Work)> {
        let fault = self.faults.next_event().map(|at| (at, Work::Fault));
        let reboot = self.state.reboot_at.map(|at| (at, Work::Reboot));
        let stream = self.state.stream.as_ref().map(|stream| match stream.pause {
            Some(pause) => (pause.until, Work::EndOfPause),
            None => (
                self.motor.step_of(
                    stream.next_revolution,
                    u64::from(self.options.profile.max_step),
                ),
                Work::Scan,
            ),
        });
        let command = self
            .pending
            .front()
            .map(|pending| (self.due(pending), Work::Command));
        // At the same instant the order of this list decides.
        [fault, reboot, stream, command]
            .into_iter()
            .flatten()
            .min_by_key(|(t, _)| *t)
    }

    fn due(&self, pending: &Pending) -> Instant {
        let earliest = pending.arrival.max(self.taken);
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

    fn take_command(&mut self, t: Instant, surroundings: &mut dyn Surroundings) {
        let Some(Pending {
            request, duplicate, ..
        }) = self.pending.pop_front()
        else {
            return;
        };
        self.taken = t;
        if self.state.protocol == Protocol::Scip2 && !duplicate {
            let repeats = self
                .pending
                .iter_mut()
                .filter(|other| other.arrival <= t && other.request.repeats(&request));
            repeats.for_each(|repeat| repeat.duplicate = true);
        }
        self.answer(&request, duplicate, t, surroundings);
    }

    fn happen(&mut self, t: Instant) {
        match self.faults.fire(t) {
            Some((Fault::Garbage, _)) => {
                let burst: Vec<u8> = (0..GARBAGE_BYTES).map(|_| self.noise.byte()).collect();
                self.emit(burst, t, t, false);
            }
            Some((Fault::Flood, _)) => self.emit(vec![0xFF; FLOOD_BYTES], t, t, false),
            Some((Fault::EndlessLine, _)) => self.emit(vec![b'0'; FLOOD_BYTES], t, t, false),
            Some((Fault::Hardware { status }, lasting)) => {
                let until = lasting.and_then(|lasting| t.checked_add(lasting));
                let malfunction = Malfunction {
                    status,
                    until,
                    rehearsed: false,
                };
                self.fail(malfunction, t);
            }
            Some((Fault::BrownOut, _)) => self.power_up(t),
            Some((Fault::TimerJump { by_ms }, _)) => self.timer.jump(by_ms, t),
            Some((Fault::TimerSet { to_ms }, _)) => self.timer.set(to_ms, t),
            Some((fault, _)) => self.be_left(fault, t),
            None => {}
        }
    }

    /// The state in which another host, or a half-done update, leaves the sensor.
    fn be_left(&mut self, fault: Fault, t: Instant) {
        self.state.stop();
        self.state.protocol = Protocol::Scip2;
        self.state.time_adjust = fault == Fault::LeftInTimeAdjust;
        self.state.firmware_update = fault == Fault::FirmwareUpdate;
        if fault == Fault::LeftStreaming {
            let next = self.motor.revolution_at(t) + 1;
            self.state.stream_on(&self.options, next);
        }
    }

    /// Sends a reply made at `t` from `at` on, unless a fault has it otherwise.
    pub(super) fn emit(&mut self, mut reply: Vec<u8>, t: Instant, at: Instant, carries_scan: bool) {
        if self.faults.happens(Fault::Silence, t) {
            return self.out.lose();
        }
        if carries_scan {
            self.faults.spoil(&mut reply, t, &mut self.noise);
        }
        self.out.send(&reply, at, &mut self.noise);
    }
}

/// The motor by the host's clock: both the motor and the timer that paces it run fast.
fn motor(options: &TwinOptions, start: Instant) -> Motor {
    let rate = (1.0 + options.motor_rate_error) * (1.0 + options.clock_rate_error);
    Motor::new(
        start,
        options.profile.speed_rpm,
        rate,
        options.profile.steps_per_revolution,
    )
}

/// The first tick of an Ethernet model after `t`.
fn next_tick(t: Instant) -> Instant {
    let tick = ETHERNET_TICK.as_nanos();
    let next = (t.as_nanos() / tick + 1) * tick;
    Instant::from_nanos(u64::try_from(next).unwrap_or(u64::MAX))
}
