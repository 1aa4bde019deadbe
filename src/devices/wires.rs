//! Both ports as the station uses them: commands out, what they told in, one clock. Threads carry them; tests bring
//! wires without any.

use super::constants::CANCEL_CHECK;
use super::error::DeviceError;
use super::head::{HeadCommand, HeadDriver, HeadEvent};
use super::laser::{LaserCommand, LaserDriver};
use super::port::{Port, PortEvent};
use super::port_name::PortName;
use link::Clock;
use std::fmt;
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

/// What a port told.
#[derive(Debug, Clone, PartialEq)]
pub enum Told {
    /// Of the laser.
    Laser(PortEvent<scip::Event>),
    /// Of the head.
    Head(PortEvent<HeadEvent>),
}

/// Both ports. Dropping it turns the laser off, halts the head and closes both within a second.
pub trait Wires: Send + fmt::Debug {
    /// The time of every deadline.
    fn now(&self) -> Duration;

    /// Asks the laser.
    fn laser(&mut self, command: LaserCommand);

    /// Asks the head.
    fn head(&mut self, command: HeadCommand);

    /// Waits for the next thing told, until `until` at most or the next look at a cancelled flag.
    fn next(&mut self, until: Duration) -> Option<Told>;

    /// What was told already and not taken yet; does not wait.
    fn heard(&mut self) -> Option<Told>;
}

/// A thread per port.
#[derive(Debug)]
pub(super) struct PortThreads {
    laser: Port<LaserDriver>,
    head: Port<HeadDriver>,
    told: Receiver<Told>,
    clock: Clock,
}

impl PortThreads {
    /// Starts both threads.
    ///
    /// # Errors
    /// [`DeviceError::NoThread`].
    pub(super) fn spawn(
        laser: PortName,
        head: PortName,
        clock: Clock,
    ) -> Result<Self, DeviceError> {
        let (tell, told) = mpsc::channel();
        let tell_head = tell.clone();
        Ok(Self {
            laser: Port::spawn(laser, clock.clone(), move |event, _| {
                tell.send(Told::Laser(event)).is_ok()
            })?,
            head: Port::spawn(head, clock.clone(), move |event, _| {
                tell_head.send(Told::Head(event)).is_ok()
            })?,
            told,
            clock,
        })
    }
}

impl Wires for PortThreads {
    fn now(&self) -> Duration {
        self.clock.now()
    }

    fn laser(&mut self, command: LaserCommand) {
        self.laser.send(command);
    }

    fn head(&mut self, command: HeadCommand) {
        self.head.send(command);
    }

    fn next(&mut self, until: Duration) -> Option<Told> {
        let left = self.clock.wall(until.saturating_sub(self.clock.now()));
        self.told.recv_timeout(left.min(CANCEL_CHECK)).ok()
    }

    fn heard(&mut self) -> Option<Told> {
        self.told.try_recv().ok()
    }
}

impl Drop for PortThreads {
    fn drop(&mut self) {
        // Both at once; their own drops wait.
        self.laser.begin_close();
        self.head.begin_close();
    }
}
