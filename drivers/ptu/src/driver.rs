//! The driver: one dialogue with one unit.

use std::collections::VecDeque;
use std::time::Duration;

use crate::action::{PtuAction, PtuEvent};
use crate::command::PtuCommand;
use crate::constants::{BITS_PER_BYTE, LONGEST_REPLY_BYTES, MAX_TRIES};
use crate::error::HeadError;
use crate::identity::IdentityDraft;
use crate::line::{Notice, ReplyBuffer};
use heard::HeardBytes;

/// Settings of the driver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PtuOptions {
    /// Baud rate of the line; only used to estimate when sending ends.
    pub baud: u32,
    /// Before giving up on connecting, broadcast the command that clears a forgotten network id (ptu-d46 section 11, step 1). It
    /// changes the unit's settings until the next power-up, so it is off by default.
    pub network_rescue: bool,
    /// Attempts to connect.
    pub attempts: u32,
    /// The first attempt is the last one where what came is no text: another line rate is to be tried.
    pub gives_up_on_garbage: bool,
}

impl Default for PtuOptions {
    fn default() -> Self {
        Self {
            baud: 9600,
            network_rescue: false,
            attempts: MAX_TRIES,
            gives_up_on_garbage: false,
        }
    }
}

/// State of the dialogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DialoguePhase {
    /// Nothing is sent, and what is received is discarded.
    Offline,
    /// Three spaces were sent; what comes is discarded.
    Settling { until: Duration },
    /// Echo off, terse, version.
    Preamble,
    /// A calibration that this driver did not request is under way.
    Calibrating { quiet_until: Duration },
    /// Commands go out one by one.
    Running,
}

/// A list of commands that goes before the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ScriptKind {
    /// Settings and identity while connecting.
    Setup,
    /// The new limits after a calibration.
    Limits,
}

/// The command whose reply is awaited.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InFlight {
    pub(crate) command: PtuCommand,
    pub(crate) tries: u32,
    pub(crate) sent_at: Duration,
    pub(crate) deadline: Duration,
}

/// Resynchronisation: drain, a space, drain (ptu-d46 section 11, step 5).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Resync {
    pub(crate) space_sent: bool,
    pub(crate) until: Duration,
    pub(crate) hard_end: Duration,
    /// The command to send again afterwards, and how often it was sent already.
    pub(crate) retry: Option<(PtuCommand, u32)>,
}

/// The host's side of a PTU-D46.
///
/// One command is in flight at a time; requests made meanwhile wait in a bounded queue. Requests are accepted only while
/// connected. Positions and speeds are in counts; the unit itself enforces its limits and refuses what is beyond them.
#[derive(Debug)]
pub struct PtuDriver {
    pub(crate) options: PtuOptions,
    pub(crate) actions: VecDeque<PtuAction>,
    pub(crate) lines: ReplyBuffer,
    pub(crate) phase: DialoguePhase,
    pub(crate) in_flight: Option<InFlight>,
    pub(crate) resync: Option<Resync>,
    pub(crate) script: Option<(ScriptKind, VecDeque<PtuCommand>)>,
    pub(crate) queue: VecDeque<PtuCommand>,
    pub(crate) draft: IdentityDraft,
    /// The notice that spoilt the calibration under way.
    pub(crate) reset_spoilt_by: Option<Notice>,
    pub(crate) connect_attempts: u32,
    pub(crate) network_rescue_sent: bool,
    pub(crate) calibration_seen: bool,
    /// When a calibration under way counts as failed.
    pub(crate) calibration_end: Option<Duration>,
    /// While connecting.
    pub(crate) heard: HeardBytes,
    /// How often the script under way was started again, because its replies did not fit.
    pub(crate) script_restarts: u32,
    /// The last line that matched no command, for messages.
    pub(crate) last_unmatched_line: String,
}

impl PtuDriver {
    /// An offline driver; [`PtuDriver::connect`] starts it.
    #[must_use]
    pub fn new(options: PtuOptions) -> Self {
        Self {
            options,
            actions: VecDeque::new(),
            lines: ReplyBuffer::default(),
            phase: DialoguePhase::Offline,
            in_flight: None,
            resync: None,
            script: None,
            queue: VecDeque::new(),
            draft: IdentityDraft::default(),
            reset_spoilt_by: None,
            connect_attempts: 0,
            network_rescue_sent: false,
            calibration_seen: false,
            calibration_end: None,
            heard: HeardBytes::default(),
            script_restarts: 0,
            last_unmatched_line: String::new(),
        }
    }

    /// A connected driver with nothing to do, as [`is_idle`](Self::is_idle) found it: a recorded dialogue goes on from here.
    #[must_use]
    pub fn resumed(options: PtuOptions) -> Self {
        let mut driver = Self::new(options);
        driver.phase = DialoguePhase::Running;
        driver
    }

    /// Connected, without a command waiting or in flight, a half-read line or an output.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.is_connected()
            && self.pending() == 0
            && self.resync.is_none()
            && self.lines.is_between_lines()
            && self.actions.is_empty()
    }

    /// As given to [`new`](Self::new).
    #[must_use]
    pub fn options(&self) -> &PtuOptions {
        &self.options
    }

    /// The next thing to do, until there is none.
    pub fn poll_action(&mut self) -> Option<PtuAction> {
        self.actions.pop_front()
    }

    /// When to call [`PtuDriver::handle_deadline`] at the latest.
    #[must_use]
    pub fn deadline(&self) -> Option<Duration> {
        match self.phase {
            DialoguePhase::Offline => None,
            DialoguePhase::Settling { until } => Some(until),
            DialoguePhase::Preamble => self.in_flight.map(|f| f.deadline),
            DialoguePhase::Calibrating { quiet_until } => Some(
                self.calibration_end
                    .map_or(quiet_until, |end| end.min(quiet_until)),
            ),
            DialoguePhase::Running => self
                .resync
                .map(|r| r.until)
                .or(self.in_flight.map(|f| f.deadline)),
        }
    }

    /// Handles the passing of time. Harmless before the deadline.
    pub fn handle_deadline(&mut self, now: Duration) {
        if self.deadline().is_none_or(|deadline| now < deadline) {
            return;
        }
        match self.phase {
            DialoguePhase::Offline => {}
            DialoguePhase::Settling { .. } => self.begin_preamble(now),
            DialoguePhase::Preamble => self.preamble_timed_out(now),
            DialoguePhase::Calibrating { .. } => self.calibration_timed_out(now),
            DialoguePhase::Running if self.resync.is_some() => self.resync_step(now),
            DialoguePhase::Running => self.reply_timed_out(now),
        }
    }

    /// Connects anew, from whatever state (ptu-d46 section 11). Ends in [`PtuEvent::Connected`] or [`PtuEvent::Fault`]; searching
    /// the baud rate is the caller's part.
    pub fn connect(&mut self, now: Duration) {
        self.network_rescue_sent = false;
        self.restart_connection(now);
    }

    /// True between [`PtuEvent::Connected`] and the next loss.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.phase == DialoguePhase::Running && !matches!(self.script, Some((ScriptKind::Setup, _)))
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

    /// Sends a command and starts waiting for its reply.
    pub(crate) fn send(&mut self, command: PtuCommand, tries: u32, now: Duration) {
        let bytes = command.to_bytes();
        let sent_at = now.saturating_add(self.wire_time(bytes.len()));
        self.in_flight = Some(InFlight {
            command,
            tries,
            sent_at,
            deadline: sent_at
                .saturating_add(command.reply_timeout())
                .saturating_add(self.wire_time(LONGEST_REPLY_BYTES)),
        });
        self.heard.note_sent(&bytes);
        if command == PtuCommand::Reset {
            self.reset_spoilt_by = None;
        }
        self.actions.push_back(PtuAction::Send(bytes));
    }

    /// Time `count` bytes take on the line.
    pub(crate) fn wire_time(&self, count: usize) -> Duration {
        let bits = u32::try_from(count)
            .unwrap_or(u32::MAX)
            .saturating_mul(BITS_PER_BYTE);
        Duration::from_secs(1).saturating_mul(bits) / self.options.baud.max(1)
    }

    pub(crate) fn emit(&mut self, event: PtuEvent) {
        // The unit can repeat the same notice without end; it is queued once until the caller has taken it.
        let repeats = matches!(
            event,
            PtuEvent::LimitHit(_) | PtuEvent::CableLost | PtuEvent::Restarted
        );
        if repeats
            && self
                .actions
                .iter()
                .any(|a| matches!(a, PtuAction::Event(e) if *e == event))
        {
            return;
        }
        self.actions.push_back(PtuAction::Event(event));
    }

    /// Ends the dialogue and reports why.
    pub(crate) fn go_offline(&mut self, fault: HeadError) {
        self.phase = DialoguePhase::Offline;
        self.clear_dialogue();
        self.emit(PtuEvent::Fault(fault));
    }

    /// Drops everything waiting or in flight.
    pub(crate) fn clear_dialogue(&mut self) {
        self.in_flight = None;
        self.resync = None;
        self.script = None;
        self.queue.clear();
    }
}
