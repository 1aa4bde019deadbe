//! A driver as the thread of its port (or a test in lockstep) sees it: requests as data, bytes in, bytes and events out.

use super::error::DeviceError;
use super::port_name::PortName;
use std::time::Duration;

/// What a driver wants done.
#[derive(Debug, Clone, PartialEq)]
pub enum Output<E> {
    /// Write these bytes, now.
    Send(Vec<u8>),
    /// Tell this.
    Event(E),
}

/// A sans-IO driver of one device. One input, then drain [`poll`](Self::poll), then the next; instants are virtual.
pub trait Driver: Send {
    /// What can be asked of it.
    type Command: Send + 'static;
    /// What it tells.
    type Event: Send + 'static;

    /// A driver that has not spoken yet, for a line of this speed (0: a link without one). `probing`: a rate is being
    /// searched for, so silence should be called soon.
    fn new(port: &PortName, baud: u32, probing: bool) -> Self;
    /// Begins the dialogue.
    fn connect(&mut self, now: Duration);
    /// Takes a request; one that cannot be taken is answered by an event.
    fn command(&mut self, command: Self::Command, now: Duration);
    /// Takes bytes that came at `now`.
    fn handle_bytes(&mut self, bytes: &[u8], now: Duration);
    /// Takes the passing of time.
    fn handle_deadline(&mut self, now: Duration);
    /// When [`handle_deadline`](Self::handle_deadline) is wanted.
    fn deadline(&self) -> Option<Duration>;
    /// The next output.
    fn poll(&mut self) -> Option<Output<Self::Event>>;

    /// Whether this event says that the device works, so that the next failure is a first one.
    fn is_proof_of_life(event: &Self::Event) -> bool;
    /// Whether this event says that the device is known now.
    fn is_connected(event: &Self::Event) -> bool;
    /// Why this event ends the dialogue, if it does: close the port, open it anew.
    fn fault(event: &Self::Event, port: &PortName) -> Option<DeviceError>;
    /// Brings the device to rest: laser off, head halted. Ends in an event that [`is_rest`](Self::is_rest) knows.
    fn rest(&mut self, now: Duration);
    /// Whether the device is at rest, or nothing more can be done for it.
    fn is_rest(event: &Self::Event) -> bool;
}
