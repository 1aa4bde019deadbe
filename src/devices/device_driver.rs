//! The interface of both drivers to port threads and tests: commands and bytes in, bytes and events out.

use super::error::DeviceError;
use super::port_config::PortConfig;
use super::recording::DialogueError;
use std::time::Duration;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum DriverOutput<E> {
    /// Write these bytes now.
    Send(Vec<u8>),
    /// Change the line rate of the port, bit/s, now.
    SetBitRate(u32),
    /// Report this event.
    Event(E),
}

/// A sans-IO driver of one device. After each input, drain [`poll`](Self::poll). All times are on the clock of the caller.
pub(crate) trait DeviceDriver: Send {
    type Command: Send + 'static;
    type Event: Send + 'static;

    /// `baud`: bit/s, 0 for a link without a line rate. `probing`: the line rate is being searched, so a silent device should
    /// be given up soon.
    fn new(port: &PortConfig, baud: u32, probing: bool) -> Self;
    fn connect(&mut self, now: Duration);
    /// A command that cannot be carried out is reported by an event.
    fn command(&mut self, command: Self::Command, now: Duration);
    fn handle_bytes(&mut self, bytes: &[u8], now: Duration);
    fn handle_deadline(&mut self, now: Duration);
    /// When to call [`handle_deadline`](Self::handle_deadline).
    fn deadline(&self) -> Option<Duration>;
    fn poll(&mut self) -> Option<DriverOutput<Self::Event>>;

    /// The state of a connected driver with nothing to do, encoded; `None`: it is not so.
    fn idle_state(&self) -> Option<Vec<u8>>;
    /// The driver in that state.
    fn resumed(state: &[u8]) -> Result<Self, DialogueError>
    where
        Self: Sized;

    /// Whether this event shows that the device works, so that the retry pause starts over.
    fn is_sign_of_life(event: &Self::Event) -> bool;
    /// Whether this event shows that the line or the device does not do with another line rate.
    fn keeps_bit_rate(_event: &Self::Event) -> bool {
        false
    }
    /// Whether this event reports the device's identity.
    fn is_connected(event: &Self::Event) -> bool;
    /// The error if this event requires closing and reopening the port.
    fn fault(event: &Self::Event, port: &PortConfig) -> Option<DeviceError>;
    /// Laser off, head halted; ends with an event for which [`is_stopped`](Self::is_stopped) holds.
    fn stop(&mut self, now: Duration);
    /// Whether the device has stopped, or nothing more can be done.
    fn is_stopped(event: &Self::Event) -> bool;
}
