//! The sensor as its user sees it: inputs, requests, outputs.

use super::action::{Action, Event, Rejection};
use super::ask::Asking;
use super::connect::Connecting;
use super::dialogue::{Desk, Dialogue, Outcome};
use super::options::{SensorOptions, StreamPlan};
use super::stopping::Stopping;
use super::streaming::Streaming;
use super::time_exchange::TimeExchange;
use crate::Instant;
use crate::command::Request;
use crate::command::laser::Quit;
use crate::command::parameters::Parameters;
use crate::command::setting::Setting;
use crate::command::single::MeasureOnce;
use crate::command::span::Span;
use crate::error::SensorError;
use crate::frame::{Framer, Message};
use crate::scan::Coding;

/// The dialogue with one sensor. One input ([`handle_bytes`](Self::handle_bytes),
/// [`handle_deadline`](Self::handle_deadline) or a request), then drain [`poll_action`](Self::poll_action), then the next.
///
/// Requests are answered by events: `connect` by `Connected`; `exchange_time` by `TimeSample`s and `TimeExchanged`;
/// `start_streaming` by `Streaming` and `Scan`s; `query_info` by `Info`; `apply` by `Applied`; `single` by `Scan`; `stop` by `Stopped`. Instead of
/// each there may come `Failed` (idle again) or `Fault` (close the port, connect anew).
#[derive(Debug)]
pub struct Sensor {
    desk: Desk,
    framer: Framer,
    phase: Phase,
}

#[derive(Debug)]
enum Phase {
    /// Never connected.
    Closed,
    /// Connected, nothing under way.
    Idle,
    /// A dialogue is under way.
    Busy(Box<dyn Dialogue>),
    /// The dialogue broke; only connecting helps.
    Faulted,
}

impl Sensor {
    /// A sensor not yet connected.
    #[must_use]
    pub fn new(options: SensorOptions) -> Self {
        let desk = Desk {
            actions: Default::default(),
            options,
            identity: None,
            rejected: 0,
        };
        Self {
            desk,
            framer: Framer::default(),
            phase: Phase::Closed,
        }
    }

    /// Takes bytes from the device. `now` stamps what begins and ends in them.
    pub fn handle_bytes(&mut self, bytes: &[u8], now: Instant) {
        let mut rest = bytes;
        while !rest.is_empty() {
            let overruns = self.framer.overruns();
            let message = self.framer.take(&mut rest, now);
            if self.framer.overruns() > overruns {
                self.desk.reject(Rejection::Overrun);
            }
            if let Some(message) = message {
                self.handle_message(&message, now);
            }
        }
    }

    fn handle_message(&mut self, message: &Message, now: Instant) {
        match &mut self.phase {
            Phase::Busy(dialogue) => {
                let outcome = dialogue.on_message(message, now, &mut self.desk);
                self.conclude(outcome);
            }
            Phase::Idle => self.desk.reject(Rejection::Unsolicited {
                echo: message.echo().into(),
            }),
            Phase::Closed | Phase::Faulted => {}
        }
    }

    /// Tells that [`deadline`](Self::deadline) may have passed. Too early a call does nothing.
    pub fn handle_deadline(&mut self, now: Instant) {
        if let Phase::Busy(dialogue) = &mut self.phase
            && dialogue.deadline() <= now
        {
            let outcome = dialogue.on_deadline(now, &mut self.desk);
            self.conclude(outcome);
        }
    }

    /// When [`handle_deadline`](Self::handle_deadline) is wanted; `None`: nothing is waited for.
    #[must_use]
    pub fn deadline(&self) -> Option<Instant> {
        match &self.phase {
            Phase::Busy(dialogue) => Some(dialogue.deadline()),
            Phase::Closed | Phase::Idle | Phase::Faulted => None,
        }
    }

    /// The next output, until `None`.
    pub fn poll_action(&mut self) -> Option<Action> {
        self.desk.actions.pop_front()
    }

    /// Begins the dialogue, whatever the device is doing and whatever was under way here.
    pub fn connect(&mut self, now: Instant) {
        self.framer.clear();
        self.phase = Phase::Busy(Box::new(Connecting::begin(now, &mut self.desk)));
    }

    /// Reads the device's timer `samples` times. It turns the laser off.
    ///
    /// # Errors
    /// [`SensorError::NotReady`] unless idle.
    pub fn exchange_time(&mut self, samples: u32, now: Instant) -> Result<(), SensorError> {
        self.idle_parameters("a time exchange")?;
        self.phase = Phase::Busy(Box::new(TimeExchange::begin(samples, now, &mut self.desk)));
        Ok(())
    }

    /// Streams scans until [`stop`](Self::stop).
    ///
    /// # Errors
    /// [`SensorError::NotReady`] unless idle, [`SensorError::Plan`] for a plan that cannot be asked for,
    /// [`SensorError::Unsupported`] for intensity of a model not known to have it.
    pub fn start_streaming(&mut self, plan: StreamPlan, now: Instant) -> Result<(), SensorError> {
        let parameters = self.idle_parameters("streaming")?;
        let request = plan.request()?;
        self.supports(plan.coding)?;
        let period = parameters.scan_period() * (u32::from(plan.interval) + 1);
        self.phase = Phase::Busy(Box::new(Streaming::begin(
            request,
            period,
            now,
            &mut self.desk,
        )));
        Ok(())
    }

    /// Asks how the device is.
    ///
    /// # Errors
    /// [`SensorError::NotReady`] unless idle; asked during streaming it would stop the stream.
    pub fn query_info(&mut self, now: Instant) -> Result<(), SensorError> {
        self.idle_parameters("a query")?;
        self.phase = Phase::Busy(Box::new(Asking::info(now, &mut self.desk)));
        Ok(())
    }

    /// Takes one scan. The laser stays on until [`stop`](Self::stop).
    ///
    /// # Errors
    /// [`SensorError::NotReady`] unless idle, [`SensorError::Plan`] for a span that cannot be asked for,
    /// [`SensorError::Unsupported`] for intensity of a model not known to have it.
    pub fn single(&mut self, span: Span, now: Instant) -> Result<(), SensorError> {
        self.idle_parameters("a single scan")?;
        let request = MeasureOnce(span.checked()?);
        self.supports(span.coding)?;
        self.phase = Phase::Busy(Box::new(Asking::scan(request, now, &mut self.desk)));
        Ok(())
    }

    /// Makes a setting.
    ///
    /// # Errors
    /// [`SensorError::NotReady`] unless idle.
    pub fn apply(&mut self, setting: Setting, now: Instant) -> Result<(), SensorError> {
        self.idle_parameters("a setting")?;
        self.phase = Phase::Busy(Box::new(Asking::setting(setting, now, &mut self.desk)));
        Ok(())
    }

    /// Stops whatever is under way and turns the laser off. Never connected or after a fault, `QT` is sent but not
    /// waited for: the last thing to do before the port is closed.
    pub fn stop(&mut self, now: Instant) {
        match self.phase {
            Phase::Idle | Phase::Busy(_) => {
                self.phase = Phase::Busy(Box::new(Stopping::begin(now, &mut self.desk)));
            }
            Phase::Closed | Phase::Faulted => self.desk.send(Quit.to_bytes()),
        }
    }

    fn idle_parameters(&self, request: &'static str) -> Result<Parameters, SensorError> {
        let state = match (&self.phase, &self.desk.identity) {
            (Phase::Idle, Some(identity)) => return Ok(identity.parameters),
            (Phase::Idle | Phase::Closed, _) => "not connected",
            (Phase::Busy(dialogue), _) => dialogue.state(),
            (Phase::Faulted, _) => "at fault",
        };
        Err(SensorError::NotReady { request, state })
    }

    fn supports(&self, coding: Coding) -> Result<(), SensorError> {
        match &self.desk.identity {
            Some(identity) if coding == Coding::WithIntensity && !identity.has_intensity() => {
                Err(SensorError::Unsupported {
                    what: "intensity",
                    model: identity.model.clone(),
                })
            }
            _ => Ok(()),
        }
    }

    fn conclude(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Continue => {}
            Outcome::Idle if self.desk.identity.is_some() => self.phase = Phase::Idle,
            Outcome::Idle => self.phase = Phase::Closed,
            Outcome::Fault(error) => {
                self.desk.tell(Event::Fault(error));
                self.phase = Phase::Faulted;
            }
        }
    }
}
