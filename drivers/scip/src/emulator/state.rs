//! The state of the emulated laser (scip2 section 5).

use super::options::{LaserOptions, LaserStartState};
use super::window::{ReplyCoding, StepWindow};
use std::time::Duration;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ProtocolVersion {
    Scip1,
    Scip2,
}

#[derive(Debug, Clone)]
pub(super) struct ActiveStream {
    /// The request up to its count.
    pub(super) head: Vec<u8>,
    /// The string of the request, with its semicolon.
    pub(super) tail: Vec<u8>,
    pub(super) window: StepWindow,
    /// Scans skipped between two that are sent.
    pub(super) interval: u64,
    /// Scans requested; 0: until `QT`.
    pub(super) count: u32,
    pub(super) sent: u64,
    /// The next one to be sent.
    pub(super) next_revolution: u64,
    pub(super) pause: Option<VerifyPause>,
}

/// A stop of the stream to verify an error.
#[derive(Debug, Clone, Copy)]
pub(super) struct VerifyPause {
    pub(super) until: Duration,
    /// Ends with 98; otherwise in a malfunction.
    pub(super) resumes: bool,
}

/// The laser refuses to measure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Malfunction {
    pub(super) status: u8,
    /// `None`: until the next power-up.
    pub(super) until: Option<Duration>,
    /// By `DB`.
    pub(super) simulated: bool,
}

/// What `DB` simulates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SimulatedFailure {
    /// `DB02`.
    Malfunction,
    /// `DB03`: normal, error, normal.
    Recovers,
    /// `DB04`: normal, error, malfunction.
    Fails,
    /// `DB05`: normal, malfunction.
    FailsAtOnce,
}

/// Everything that a power-up resets.
#[derive(Debug, Clone)]
pub(super) struct LaserState {
    pub(super) protocol: ProtocolVersion,
    pub(super) laser_on: bool,
    pub(super) time_adjust: bool,
    pub(super) firmware_update: bool,
    /// After a request for an unsupported measurement: nothing is answered any more.
    pub(super) deaf: bool,
    /// By `%SL`.
    pub(super) asleep: bool,
    pub(super) first_reboot_request_at: Option<Duration>,
    pub(super) reboot_at: Option<Duration>,
    pub(super) sensitive: bool,
    /// `CR` level: 0 is nominal.
    pub(super) speed_level: u8,
    pub(super) stream: Option<ActiveStream>,
    pub(super) malfunction: Option<Malfunction>,
    pub(super) simulation: Option<SimulatedFailure>,
}

impl LaserState {
    pub(super) fn powered_up(options: &LaserOptions) -> Self {
        Self {
            protocol: if options.profile.scip1.is_some() {
                ProtocolVersion::Scip1
            } else {
                ProtocolVersion::Scip2
            },
            laser_on: false,
            time_adjust: false,
            firmware_update: false,
            deaf: false,
            asleep: false,
            first_reboot_request_at: None,
            reboot_at: None,
            sensitive: false,
            speed_level: 0,
            stream: None,
            malfunction: None,
            simulation: None,
        }
    }

    pub(super) fn at_start(options: &LaserOptions) -> Self {
        let mut state = Self::powered_up(options);
        if options.start_state != LaserStartState::PowerUp {
            state.protocol = ProtocolVersion::Scip2;
        }
        match options.start_state {
            LaserStartState::PowerUp | LaserStartState::Idle => {}
            LaserStartState::LaserOn => state.laser_on = true,
            LaserStartState::TimeAdjust => state.time_adjust = true,
            LaserStartState::FirmwareUpdate => state.firmware_update = true,
            LaserStartState::Streaming => state.start_default_stream(options, 0),
        }
        state
    }

    /// Streams the measuring window from `revolution` on without end, for a host that is gone.
    pub(super) fn start_default_stream(&mut self, options: &LaserOptions, revolution: u64) {
        let (first, last) = (options.profile.first_step, options.profile.last_step);
        self.laser_on = true;
        self.stream = Some(ActiveStream {
            head: format!("MD{first:04}{last:04}010").into_bytes(),
            tail: Vec::new(),
            window: StepWindow {
                start: first as usize,
                end: last as usize,
                cluster: 1,
                coding: ReplyCoding::ThreeCharacters,
            },
            interval: 0,
            count: 0,
            sent: 0,
            next_revolution: revolution,
            pause: None,
        });
    }

    /// Turns the laser off and ends a stream.
    pub(super) fn stop(&mut self) {
        self.laser_on = false;
        self.stream = None;
    }

    pub(super) fn malfunction_at(&self, t: Duration) -> Option<Malfunction> {
        self.malfunction
            .filter(|malfunction| malfunction.until.is_none_or(|until| t < until))
    }
}
