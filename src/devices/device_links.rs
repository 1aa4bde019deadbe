//! The connection of a station to both ports: commands out, messages in, one clock. Port threads implement it; tests
//! implement it without threads.

use super::constants::CANCEL_CHECK;
use super::error::DeviceError;
use super::head::{HeadCommand, HeadDriver, HeadEvent};
use super::laser::{LaserCommand, LaserDriver};
use super::port::{Port, PortEvent};
use super::port_config::PortConfig;
use super::recording::DialogueTap;
use link::Clock;
use std::fmt;
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

/// A message from a port.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PortMessage {
    Laser(PortEvent<scip::LaserEvent>),
    Head(PortEvent<HeadEvent>),
}

/// Dropping it turns the laser off, halts the head and closes both ports within a second.
pub(crate) trait DeviceLinks: Send + fmt::Debug {
    /// Time on the clock of all deadlines.
    fn now(&self) -> Duration;

    fn send_laser(&mut self, command: LaserCommand);

    fn send_head(&mut self, command: HeadCommand);

    /// Waits for the next message, at most until `until` and at most [`CANCEL_CHECK`].
    fn recv(&mut self, until: Duration) -> Option<PortMessage>;

    /// A message that has arrived already; does not wait.
    fn try_recv(&mut self) -> Option<PortMessage>;

    /// Lets both drivers join a recording, each once it has taken all commands sent before.
    fn record(&mut self, tap: &DialogueTap);
}

/// One thread per port.
#[derive(Debug)]
pub(crate) struct PortThreads {
    laser: Port<LaserDriver>,
    head: Port<HeadDriver>,
    messages: Receiver<PortMessage>,
    clock: Clock,
}

impl PortThreads {
    /// Starts both threads.
    ///
    /// # Errors
    /// [`DeviceError::NoThread`].
    pub(super) fn spawn(
        laser: PortConfig,
        head: PortConfig,
        clock: Clock,
    ) -> Result<Self, DeviceError> {
        let (sender, messages) = mpsc::channel();
        let head_sender = sender.clone();
        Ok(Self {
            laser: Port::spawn(laser, clock.clone(), move |event, _| {
                sender.send(PortMessage::Laser(event)).is_ok()
            })?,
            head: Port::spawn(head, clock.clone(), move |event, _| {
                head_sender.send(PortMessage::Head(event)).is_ok()
            })?,
            messages,
            clock,
        })
    }
}

impl DeviceLinks for PortThreads {
    fn now(&self) -> Duration {
        self.clock.now()
    }

    fn send_laser(&mut self, command: LaserCommand) {
        self.laser.send(command);
    }

    fn send_head(&mut self, command: HeadCommand) {
        self.head.send(command);
    }

    fn recv(&mut self, until: Duration) -> Option<PortMessage> {
        let left = self.clock.wall_time(until.saturating_sub(self.clock.now()));
        self.messages.recv_timeout(left.min(CANCEL_CHECK)).ok()
    }

    fn try_recv(&mut self) -> Option<PortMessage> {
        self.messages.try_recv().ok()
    }

    fn record(&mut self, tap: &DialogueTap) {
        self.laser.record(tap.clone());
        self.head.record(tap.clone());
    }
}

impl Drop for PortThreads {
    fn drop(&mut self) {
        // Both start to close before the first drop waits.
        self.laser.start_closing();
        self.head.start_closing();
    }
}
