//! The driver as its caller sees it: inputs, requests, outputs.

use super::action::{LaserAction, LaserEvent, Rejection};
use super::connecting::Connecting;
use super::dialogue::{Dialogue, DialogueOutcome, DriverContext};
use super::error::ScipError;
use super::identity::LaserIdentity;
use super::options::{ScipOptions, StreamPlan};
use super::stopping::Stopping;
use super::streaming::Streaming;
use super::time_exchange::TimeExchange;
use crate::command::parameters::LaserParameters;
use crate::command::quit::Quit;
use crate::command::request::ScipRequest;
use crate::frame::{Framer, ScipMessage};
use crate::scan::ValueCoding;
use heard::HeardBytes;
use std::time::Duration;

/// The sans-IO driver of one laser. After every input ([`handle_bytes`](Self::handle_bytes),
/// [`handle_deadline`](Self::handle_deadline) or a request), drain [`poll_action`](Self::poll_action).
///
/// All instants are durations since an origin that the caller chose, on a clock that never goes back.
///
/// Requests are answered by events: `connect` by `Connected`; `exchange_time` by `TimeSample`s and `TimeExchanged`;
/// `start_streaming` by `Streaming` and `Scan`s; `stop` by `Stopped`. Any of them may end in `RequestFailed` (the device is
/// idle again) or `ConnectionFailed` (close the port, reopen, connect again).
#[derive(Debug)]
pub struct ScipDriver {
    context: DriverContext,
    framer: Framer,
    phase: DriverPhase,
}

#[derive(Debug)]
enum DriverPhase {
    /// Never connected.
    Closed,
    /// Connected, without a dialogue.
    Idle,
    Busy(Box<dyn Dialogue>),
    /// Only connecting helps.
    Faulted,
}

impl ScipDriver {
    /// A driver that is not connected yet.
    #[must_use]
    pub fn new(options: ScipOptions) -> Self {
        let context = DriverContext {
            actions: Default::default(),
            options,
            identity: None,
            rejected: 0,
            heard: HeardBytes::default(),
        };
        Self {
            context,
            framer: Framer::default(),
            phase: DriverPhase::Closed,
        }
    }

    /// A connected driver without a dialogue, as [`is_idle`](Self::is_idle) found it: a recorded dialogue goes on from here.
    #[must_use]
    pub fn resumed(options: ScipOptions, identity: LaserIdentity) -> Self {
        let mut driver = Self::new(options);
        driver.context.identity = Some(identity);
        driver.phase = DriverPhase::Idle;
        driver
    }

    /// Connected, without a dialogue, a half-read message or an output.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, DriverPhase::Idle)
            && self.framer.is_between_messages()
            && self.context.actions.is_empty()
    }

    /// Of the device that is or was connected.
    #[must_use]
    pub fn identity(&self) -> Option<&LaserIdentity> {
        self.context.identity.as_ref()
    }

    /// As given to [`new`](Self::new).
    #[must_use]
    pub fn options(&self) -> &ScipOptions {
        &self.context.options
    }

    /// Takes bytes that came from the device at `now`.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        if self.context.identity.is_none() {
            self.context.heard.note(bytes);
        }
        let mut rest = bytes;
        while !rest.is_empty() {
            let overruns = self.framer.overruns();
            let message = self.framer.take(&mut rest, now);
            if self.framer.overruns() > overruns {
                self.context.reject(Rejection::Overrun);
            }
            if let Some(message) = message {
                self.handle_message(&message, now);
            }
        }
    }

    fn handle_message(&mut self, message: &ScipMessage, now: Duration) {
        match &mut self.phase {
            DriverPhase::Busy(dialogue) => {
                let outcome = dialogue.on_message(message, now, &mut self.context);
                self.conclude(outcome);
            }
            DriverPhase::Idle => self.context.reject(Rejection::Unsolicited {
                echo: message.echo().into(),
            }),
            DriverPhase::Closed | DriverPhase::Faulted => {}
        }
    }

    /// To be called at [`deadline`](Self::deadline); earlier calls do nothing.
    pub fn handle_deadline(&mut self, now: Duration) {
        if let DriverPhase::Busy(dialogue) = &mut self.phase
            && dialogue.deadline() <= now
        {
            let outcome = dialogue.on_deadline(now, &mut self.context);
            self.conclude(outcome);
        }
    }

    /// When [`handle_deadline`](Self::handle_deadline) is due; `None` if nothing is pending.
    #[must_use]
    pub fn deadline(&self) -> Option<Duration> {
        match &self.phase {
            DriverPhase::Busy(dialogue) => Some(dialogue.deadline()),
            DriverPhase::Closed | DriverPhase::Idle | DriverPhase::Faulted => None,
        }
    }

    /// The next output, until `None`.
    pub fn poll_action(&mut self) -> Option<LaserAction> {
        self.context.actions.pop_front()
    }

    /// Connects from any state of device and driver.
    pub fn connect(&mut self, now: Duration) {
        self.framer.clear();
        self.context.heard = HeardBytes::default();
        self.phase = DriverPhase::Busy(Box::new(Connecting::start(now, &mut self.context)));
    }

    /// Reads the device's timer `samples` times. It turns the laser off.
    ///
    /// # Errors
    /// [`ScipError::NotReady`] unless idle.
    pub fn exchange_time(&mut self, samples: u32, now: Duration) -> Result<(), ScipError> {
        self.idle_parameters("a time exchange")?;
        self.phase = DriverPhase::Busy(Box::new(TimeExchange::start(
            samples,
            now,
            &mut self.context,
        )));
        Ok(())
    }

    /// Streams scans until [`stop`](Self::stop).
    ///
    /// # Errors
    /// [`ScipError::NotReady`] unless idle, [`ScipError::Plan`] for a plan that cannot be asked for,
    /// [`ScipError::Unsupported`] for intensity of a model not known to have it.
    pub fn start_streaming(&mut self, plan: StreamPlan, now: Duration) -> Result<(), ScipError> {
        let parameters = self.idle_parameters("streaming")?;
        let request = plan.request()?;
        self.supports(plan.coding)?;
        let period = parameters.scan_period() * (u32::from(plan.interval) + 1);
        self.phase = DriverPhase::Busy(Box::new(Streaming::start(
            request,
            period,
            now,
            &mut self.context,
        )));
        Ok(())
    }

    /// Stops the current dialogue and turns the laser off. If not connected, or after a fault, `QT` is sent without
    /// waiting for the reply, as the last bytes before the port is closed.
    pub fn stop(&mut self, now: Duration) {
        match self.phase {
            DriverPhase::Idle | DriverPhase::Busy(_) => {
                self.phase = DriverPhase::Busy(Box::new(Stopping::start(now, &mut self.context)));
            }
            DriverPhase::Closed | DriverPhase::Faulted => self.context.send(Quit.to_bytes()),
        }
    }

    fn idle_parameters(&self, request: &'static str) -> Result<LaserParameters, ScipError> {
        let state = match (&self.phase, &self.context.identity) {
            (DriverPhase::Idle, Some(identity)) => return Ok(identity.parameters),
            (DriverPhase::Idle | DriverPhase::Closed, _) => "not connected",
            (DriverPhase::Busy(dialogue), _) => dialogue.state(),
            (DriverPhase::Faulted, _) => "at fault",
        };
        Err(ScipError::NotReady { request, state })
    }

    fn supports(&self, coding: ValueCoding) -> Result<(), ScipError> {
        match &self.context.identity {
            Some(identity) if coding == ValueCoding::WithIntensity && !identity.has_intensity() => {
                Err(ScipError::Unsupported {
                    what: "intensity",
                    model: identity.model.clone(),
                })
            }
            _ => Ok(()),
        }
    }

    fn conclude(&mut self, outcome: DialogueOutcome) {
        match outcome {
            DialogueOutcome::Continue => {}
            DialogueOutcome::Then(dialogue) => self.phase = DriverPhase::Busy(dialogue),
            DialogueOutcome::Idle if self.context.identity.is_some() => {
                self.phase = DriverPhase::Idle
            }
            DialogueOutcome::Idle => self.phase = DriverPhase::Closed,
            DialogueOutcome::Fault(error) => {
                self.context.emit(LaserEvent::ConnectionFailed(error));
                self.phase = DriverPhase::Faulted;
            }
        }
    }
}
