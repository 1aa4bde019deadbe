//! What the sensor is doing (protocol section 5), and the statuses by which it tells.

use super::Instant;
use super::options::{StartState, TwinOptions};
use super::scanning::{Coding, Window};

/// The two characters of a status line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Status(pub(super) [u8; 2]);

impl Status {
    pub(super) const DONE: Self = Self(*b"00");
    pub(super) const LASER_OFF: Self = Self(*b"10");
    /// SCIP2.2: not in this state.
    pub(super) const DENIED: Self = Self(*b"10");
    /// SCIP2.2: this model has no such setting.
    pub(super) const NOT_SUPPORTED: Self = Self(*b"0F");
    /// SCIP2.2: too few characters.
    pub(super) const TOO_SHORT: Self = Self(*b"0H");
    /// Only VV, II, RS and SCIP2.0 in the firmware update mode.
    pub(super) const FIRMWARE_UPDATE: Self = Self(*b"0I");
    pub(super) const RESUMED: Self = Self(*b"98");
    pub(super) const DATA: Self = Self(*b"99");
    pub(super) const BUFFER_SHORTAGE: Self = Self(*b"0B");
    pub(super) const TOO_FEW_PARAMETERS: Self = Self(*b"0C");
    pub(super) const TOO_MANY_PARAMETERS: Self = Self(*b"0D");
    pub(super) const UNDEFINED: Self = Self(*b"0E");
    pub(super) const STRING_TOO_LONG: Self = Self(*b"0G");
    pub(super) const STRING_CHARACTER: Self = Self(*b"0H");

    /// A status that is a number below 100.
    pub(super) const fn number(number: u8) -> Self {
        Self([b'0' + (number / 10) % 10, b'0' + number % 10])
    }
}

/// Which protocol is spoken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Protocol {
    Scip1,
    Scip2,
}

/// Scans being sent until further notice.
#[derive(Debug, Clone)]
pub(super) struct Stream {
    /// `MD` or `MS` with its parameters up to the count.
    pub(super) head: Vec<u8>,
    /// The string of the request, with its semicolon.
    pub(super) tail: Vec<u8>,
    pub(super) window: Window,
    /// Scans skipped between two sent.
    pub(super) interval: u64,
    /// Scans that were asked for; 0 without end.
    pub(super) count: u32,
    /// Scans already sent.
    pub(super) sent: u64,
    /// The next revolution to be sent.
    pub(super) next_revolution: u64,
    /// Stopped to verify an error.
    pub(super) pause: Option<Pause>,
}

/// A stop of the stream to verify an error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pause {
    pub(super) until: Instant,
    /// The laser proves normal (98); otherwise it ends in malfunction.
    pub(super) resumes: bool,
}

/// The hardware refuses to measure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Malfunction {
    pub(super) status: u8,
    /// `None`: until the next power-up.
    pub(super) until: Option<Instant>,
    /// Only played for `DB`.
    pub(super) rehearsed: bool,
}

/// What `DB` was told to play.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rehearsal {
    /// `DB02`.
    Malfunction,
    /// `DB03`: normal, error, normal.
    Recovers,
    /// `DB04`: normal, error, malfunction.
    Fails,
    /// `DB05`: normal, malfunction.
    FailsAtOnce,
}

/// Everything that a power-up forgets.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) protocol: Protocol,
    pub(super) laser: bool,
    pub(super) time_adjust: bool,
    pub(super) firmware_update: bool,
    /// An unknown measurement was asked for: nothing is answered any more.
    pub(super) deaf: bool,
    /// `%SL`: the motor stands.
    pub(super) asleep: bool,
    /// When the first `RB` of a pair came.
    pub(super) reboot_asked: Option<Instant>,
    /// When the sensor starts anew.
    pub(super) reboot_at: Option<Instant>,
    pub(super) sensitive: bool,
    /// `CR` level: 0 is nominal.
    pub(super) speed_level: u8,
    pub(super) stream: Option<Stream>,
    pub(super) malfunction: Option<Malfunction>,
    pub(super) rehearsal: Option<Rehearsal>,
}

impl State {
    /// The state after power-up.
    pub(super) fn powered_up(options: &TwinOptions) -> Self {
        Self {
            protocol: if options.profile.scip1.is_some() {
                Protocol::Scip1
            } else {
                Protocol::Scip2
            },
            laser: false,
            time_adjust: false,
            firmware_update: false,
            deaf: false,
            asleep: false,
            reboot_asked: None,
            reboot_at: None,
            sensitive: false,
            speed_level: 0,
            stream: None,
            malfunction: None,
            rehearsal: None,
        }
    }

    /// The state in which the twin is found at the start.
    pub(super) fn found(options: &TwinOptions) -> Self {
        let mut state = Self::powered_up(options);
        if options.start_state != StartState::PowerUp {
            state.protocol = Protocol::Scip2;
        }
        match options.start_state {
            StartState::PowerUp | StartState::Idle => {}
            StartState::LaserOn => state.laser = true,
            StartState::TimeAdjust => state.time_adjust = true,
            StartState::FirmwareUpdate => state.firmware_update = true,
            StartState::Streaming => state.stream_on(options, 0),
        }
        state
    }

    /// Streams the measuring window without end from `revolution` on, for a host that is gone.
    pub(super) fn stream_on(&mut self, options: &TwinOptions, revolution: u64) {
        let (first, last) = (options.profile.first_step, options.profile.last_step);
        self.laser = true;
        self.stream = Some(Stream {
            head: format!("MD{first:04}{last:04}010").into_bytes(),
            tail: Vec::new(),
            window: Window {
                start: first as usize,
                end: last as usize,
                cluster: 1,
                coding: Coding::ThreeCharacters,
            },
            interval: 0,
            count: 0,
            sent: 0,
            next_revolution: revolution,
            pause: None,
        });
    }

    /// Turns the laser off and ends whatever it was on for.
    pub(super) fn stop(&mut self) {
        self.laser = false;
        self.stream = None;
    }

    /// The status of a malfunction that holds at `t`.
    pub(super) fn malfunction_at(&self, t: Instant) -> Option<Malfunction> {
        self.malfunction
            .filter(|malfunction| malfunction.until.is_none_or(|until| t < until))
    }
}
