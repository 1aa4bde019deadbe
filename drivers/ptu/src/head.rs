//! The driver: one dialogue with one unit.

use std::collections::VecDeque;
use std::time::Duration;

use crate::action::{Action, Counters, Event, HeadError, RequestError};
use crate::command::{Command, Quantity};
use crate::constants::{BITS_PER_BYTE, CALIBRATION_TIMEOUT, QUEUE_MAX, REPLY_TIMEOUT_MIN};
use crate::identity::{Draft, HeadIdentity};
use crate::line::{LineBuffer, Notice};
use crate::{Axis, Instant};

/// Settings of the driver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeadOptions {
    /// Baud rate of the line; only used to say when sending ends.
    pub baud: u32,
    /// Wait for a reply. Values below 500 ms are raised to it (section 12, last row).
    pub reply_timeout: Duration,
    /// Before giving up at connecting, broadcast the command that takes a forgotten network id away (section 11, step 1). It changes
    /// the unit's settings until the next power-up, so it is off unless asked for.
    pub network_rescue: bool,
}

impl Default for HeadOptions {
    fn default() -> Self {
        Self {
            baud: 9600,
            reply_timeout: REPLY_TIMEOUT_MIN,
            network_rescue: false,
        }
    }
}

/// Where the dialogue stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Nothing is sent, nothing believed.
    Offline,
    /// Three spaces were sent; what comes is thrown away.
    Settling { until: Instant },
    /// Echo off, terse, version.
    Preamble,
    /// A calibration nobody here asked for is under way.
    Calibrating { quiet_until: Instant },
    /// Commands go out one by one.
    Running,
}

/// A list of commands that goes before everything else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Script {
    /// Settings and identity at connecting.
    Setup,
    /// The new limits after a calibration.
    Limits,
}

/// The command whose reply is awaited.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InFlight {
    pub(crate) command: Command,
    pub(crate) tries: u32,
    pub(crate) sent_at: Instant,
    pub(crate) deadline: Instant,
}

/// Getting back into step: drain, a space, drain (section 11, step 5).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resync {
    pub(crate) space_sent: bool,
    pub(crate) until: Instant,
    pub(crate) hard_end: Instant,
    /// What is sent again afterwards, and how often it was already.
    pub(crate) retry: Option<(Command, u32)>,
}

/// A PTU-D46, from the host's side.
///
/// One command is in flight at a time; what is asked meanwhile waits in a bounded queue. Requests are only taken while connected.
/// Positions and speeds are in counts; the unit itself enforces its limits and refuses what is beyond them.
#[derive(Debug)]
pub struct Head {
    pub(crate) options: HeadOptions,
    pub(crate) actions: VecDeque<Action>,
    pub(crate) lines: LineBuffer,
    pub(crate) phase: Phase,
    pub(crate) in_flight: Option<InFlight>,
    pub(crate) resync: Option<Resync>,
    pub(crate) script: Option<(Script, VecDeque<Command>)>,
    pub(crate) queue: VecDeque<Command>,
    pub(crate) draft: Draft,
    pub(crate) identity: Option<HeadIdentity>,
    pub(crate) counters: Counters,
    pub(crate) position_trusted: bool,
    /// The notice that spoilt the calibration under way.
    pub(crate) homing_spoilt: Option<Notice>,
    pub(crate) connect_tries: u32,
    pub(crate) rescued: bool,
    pub(crate) calibration_seen: bool,
    /// End of all patience with a calibration under way.
    pub(crate) calibration_end: Option<Instant>,
    pub(crate) bytes_heard: u64,
    /// The last line that fitted nothing, for messages.
    pub(crate) last_odd_line: String,
}

impl Head {
    /// A driver that has not spoken yet.
    #[must_use]
    pub fn new(options: HeadOptions) -> Self {
        Self {
            options,
            actions: VecDeque::new(),
            lines: LineBuffer::default(),
            phase: Phase::Offline,
            in_flight: None,
            resync: None,
            script: None,
            queue: VecDeque::new(),
            draft: Draft::default(),
            identity: None,
            counters: Counters::default(),
            position_trusted: false,
            homing_spoilt: None,
            connect_tries: 0,
            rescued: false,
            calibration_seen: false,
            calibration_end: None,
            bytes_heard: 0,
            last_odd_line: String::new(),
        }
    }

    /// The next thing to do, until there is none.
    pub fn poll_action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// When [`Head::handle_deadline`] wants to be called at the latest.
    #[must_use]
    pub fn deadline(&self) -> Option<Instant> {
        match self.phase {
            Phase::Offline => None,
            Phase::Settling { until } => Some(until),
            Phase::Preamble => self.in_flight.map(|f| f.deadline),
            Phase::Calibrating { quiet_until } => Some(
                self.calibration_end
                    .map_or(quiet_until, |end| end.min(quiet_until)),
            ),
            Phase::Running => self
                .resync
                .map(|r| r.until)
                .or(self.in_flight.map(|f| f.deadline)),
        }
    }

    /// Takes the passing of time. Harmless before the deadline.
    pub fn handle_deadline(&mut self, now: Instant) {
        if self.deadline().is_none_or(|deadline| now < deadline) {
            return;
        }
        match self.phase {
            Phase::Offline => {}
            Phase::Settling { .. } => self.settled(now),
            Phase::Preamble => self.preamble_timed_out(now),
            Phase::Calibrating { .. } => self.calibration_timed_out(now),
            Phase::Running if self.resync.is_some() => self.resync_step(now),
            Phase::Running => self.reply_timed_out(now),
        }
    }

    /// Tells when the last [`Action::Send`] was really out; otherwise that is taken from the baud rate.
    pub fn sent(&mut self, at: Instant) {
        if let Some(in_flight) = &mut self.in_flight {
            in_flight.sent_at = at;
        }
    }

    /// Begins a connection anew, from whatever state (section 11). Ends in [`Event::Connected`] or [`Event::Fault`]; searching the
    /// baud rate is the caller's part.
    pub fn connect(&mut self, now: Instant) {
        self.rescued = false;
        self.restart_connection(now);
    }

    /// Calibrates both axes: drives them to all their stops and then to 0,0, which takes up to a minute. Ends in
    /// [`Event::HomeDone`] or a fault.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn reset(&mut self, now: Instant) -> Result<(), RequestError> {
        self.request(&[Command::Reset], now)
    }

    /// Sets the speed of an axis, counts per second. Allowed while moving.
    ///
    /// # Errors
    /// [`RequestError`]. Out of bounds is the unit's word: [`Event::Refused`].
    pub fn set_speed(
        &mut self,
        axis: Axis,
        steps_per_s: i32,
        now: Instant,
    ) -> Result<(), RequestError> {
        self.request(&[Command::SetSpeed(axis, steps_per_s)], now)
    }

    /// Sends an axis to a position, counts. Allowed while moving: the new target replaces the old one.
    ///
    /// # Errors
    /// [`RequestError`]. Out of reach is the unit's word: [`Event::Refused`].
    pub fn move_to(
        &mut self,
        axis: Axis,
        position_steps: i32,
        now: Instant,
    ) -> Result<(), RequestError> {
        self.request(&[Command::MoveTo(axis, position_steps)], now)
    }

    /// Asks where an axis is; comes back as [`Event::Position`].
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn poll_position(&mut self, axis: Axis, now: Instant) -> Result<(), RequestError> {
        self.request(&[Command::Query(axis, Quantity::Position)], now)
    }

    /// Stops both axes, before everything that waits; waiting moves and resets are dropped. Goes out as soon as the command in flight
    /// is answered or timed out; a running calibration ends first.
    ///
    /// # Errors
    /// [`RequestError::NotConnected`] only.
    pub fn halt(&mut self, now: Instant) -> Result<(), RequestError> {
        if !self.is_connected() {
            return Err(RequestError::NotConnected);
        }
        self.queue
            .retain(|c| !matches!(c, Command::MoveTo(..) | Command::Reset | Command::Halt));
        self.queue.push_front(Command::Halt);
        self.start_next(now);
        Ok(())
    }

    /// True between [`Event::Connected`] and the next loss.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.phase == Phase::Running && !matches!(self.script, Some((Script::Setup, _)))
    }

    /// Whether counts stand for angles: true after a calibration that was seen to end, until a limit is hit, settings are lost, the
    /// cable comes off or the connection is made anew.
    #[must_use]
    pub fn position_trusted(&self) -> bool {
        self.position_trusted
    }

    /// Who the unit is, while connected; limits are those after the last reset.
    #[must_use]
    pub fn identity(&self) -> Option<&HeadIdentity> {
        self.identity.as_ref()
    }

    /// Commands waiting or in flight: 0 means that a request goes out at once.
    #[must_use]
    pub fn pending(&self) -> usize {
        let script = self
            .script
            .as_ref()
            .map_or(0, |(_, commands)| commands.len());
        let retry = usize::from(self.resync.is_some_and(|r| r.retry.is_some()));
        self.queue.len() + script + retry + usize::from(self.in_flight.is_some())
    }

    /// Faults of the line so far.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    pub(crate) fn request(
        &mut self,
        commands: &[Command],
        now: Instant,
    ) -> Result<(), RequestError> {
        if !self.is_connected() {
            return Err(RequestError::NotConnected);
        }
        let waiting = self.queue.len();
        if waiting + commands.len() > QUEUE_MAX {
            return Err(RequestError::QueueFull { waiting });
        }
        self.queue.extend(commands);
        self.start_next(now);
        Ok(())
    }

    /// Puts a command on the wire.
    pub(crate) fn send(
        &mut self,
        command: Command,
        tries: u32,
        reply_timeout: Duration,
        now: Instant,
    ) {
        let wire = command.wire();
        let sent_at = now.saturating_add(self.wire_time(wire.len()));
        self.in_flight = Some(InFlight {
            command,
            tries,
            sent_at,
            deadline: sent_at.saturating_add(reply_timeout),
        });
        if command == Command::Reset {
            self.homing_spoilt = None;
        }
        self.actions.push_back(Action::Send(wire));
    }

    /// How long a reply is waited for.
    pub(crate) fn reply_timeout(&self, command: Command) -> Duration {
        match command {
            Command::Reset => CALIBRATION_TIMEOUT,
            _ => self.options.reply_timeout.max(REPLY_TIMEOUT_MIN),
        }
    }

    /// Time `count` bytes take on the line.
    pub(crate) fn wire_time(&self, count: usize) -> Duration {
        let bits = u32::try_from(count)
            .unwrap_or(u32::MAX)
            .saturating_mul(BITS_PER_BYTE);
        Duration::from_secs(1).saturating_mul(bits) / self.options.baud.max(1)
    }

    pub(crate) fn emit(&mut self, event: Event) {
        // The unit can shout the same notice without end; said once, it is said until it is heard.
        let repeats = matches!(
            event,
            Event::LimitHit(_) | Event::CableLost | Event::Restarted
        );
        if repeats
            && self
                .actions
                .iter()
                .any(|a| matches!(a, Action::Event(e) if *e == event))
        {
            return;
        }
        self.actions.push_back(Action::Event(event));
    }

    /// Stops talking and says why.
    pub(crate) fn go_offline(&mut self, fault: HeadError) {
        self.phase = Phase::Offline;
        self.position_trusted = false;
        self.identity = None;
        self.forget_dialogue();
        self.emit(Event::Fault(fault));
    }

    /// Drops everything waiting, in flight or half read.
    pub(crate) fn forget_dialogue(&mut self) {
        self.lines.clear();
        self.in_flight = None;
        self.resync = None;
        self.script = None;
        self.queue.clear();
    }
}
