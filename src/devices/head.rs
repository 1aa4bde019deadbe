//! The head's driver with its requests as data, and the polling of an axis as fast as it answers.

use super::driver::{Driver, Output};
use super::error::{Device, DeviceError};
use super::port_name::PortName;
use ptu::{Action, Axis, Event, Head, HeadError, HeadOptions, RequestError};
use std::collections::VecDeque;
use std::time::Duration;

/// What can be asked of the head.
#[derive(Debug, Clone, PartialEq)]
pub enum HeadCommand {
    /// Calibrate both axes.
    Home,
    /// Set the speed of an axis, counts per second.
    SetSpeed(Axis, i32),
    /// Send an axis to a position, counts.
    MoveTo(Axis, i32),
    /// Ask the position of this axis again and again, or of none.
    Watch(Option<Axis>),
    /// Ask supply and temperature.
    QueryHealth,
    /// Stop both axes.
    Halt,
    /// Hold power low, for parking.
    HoldLow,
}

/// What the head's driver tells.
#[derive(Debug, Clone, PartialEq)]
pub enum HeadEvent {
    /// From the unit.
    Unit(Event),
    /// A request was not taken.
    NotTaken(RequestError),
}

/// The head's driver.
#[derive(Debug)]
pub struct HeadDriver {
    head: Head,
    watched: Option<Axis>,
    not_taken: VecDeque<RequestError>,
    now: Duration,
}

impl HeadDriver {
    fn note(&mut self, taken: Result<(), RequestError>) {
        self.not_taken.extend(taken.err());
    }

    /// The next poll goes out when nothing else waits.
    fn poll_again(&mut self) {
        let Some(axis) = self.watched else { return };
        if self.head.is_connected() && self.head.pending() == 0 {
            // Connected, and nothing waits: it is taken.
            let _ = self.head.poll_position(axis, self.now);
        }
    }
}

impl Driver for HeadDriver {
    type Command = HeadCommand;
    type Event = HeadEvent;

    fn new(_port: &PortName, baud: u32, _probing: bool) -> Self {
        let options = HeadOptions {
            baud,
            ..HeadOptions::default()
        };
        Self {
            head: Head::new(options),
            watched: None,
            not_taken: VecDeque::new(),
            now: Duration::ZERO,
        }
    }

    fn connect(&mut self, now: Duration) {
        self.now = now;
        self.head.connect(now);
    }

    fn command(&mut self, command: HeadCommand, now: Duration) {
        self.now = now;
        let taken = match command {
            HeadCommand::Home => self.head.reset(now),
            HeadCommand::SetSpeed(axis, speed) => self.head.set_speed(axis, speed, now),
            HeadCommand::MoveTo(axis, target) => self.head.move_to(axis, target, now),
            HeadCommand::Watch(axis) => {
                self.watched = axis;
                Ok(())
            }
            HeadCommand::QueryHealth => self.head.query_health(now),
            HeadCommand::Halt => self.head.halt(now),
            HeadCommand::HoldLow => self.head.hold_power_low(now),
        };
        self.note(taken);
    }

    fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.now = now;
        self.head.handle_bytes(bytes, now);
    }

    fn handle_deadline(&mut self, now: Duration) {
        self.now = now;
        self.head.handle_deadline(now);
    }

    fn deadline(&self) -> Option<Duration> {
        self.head.deadline()
    }

    fn poll(&mut self) -> Option<Output<HeadEvent>> {
        let mut action = self.head.poll_action();
        if action.is_none() {
            self.poll_again();
            action = self.head.poll_action();
        }
        match action {
            Some(Action::Send(bytes)) => Some(Output::Send(bytes)),
            Some(Action::Event(event)) => Some(Output::Event(HeadEvent::Unit(event))),
            None => self
                .not_taken
                .pop_front()
                .map(|error| Output::Event(HeadEvent::NotTaken(error))),
        }
    }

    fn is_proof_of_life(event: &HeadEvent) -> bool {
        matches!(
            event,
            HeadEvent::Unit(Event::Position { .. } | Event::HomeDone { .. })
        )
    }

    fn is_connected(event: &HeadEvent) -> bool {
        matches!(event, HeadEvent::Unit(Event::Connected(_)))
    }

    fn fault(event: &HeadEvent, port: &PortName) -> Option<DeviceError> {
        match event {
            // After a calibration that failed the dialogue goes on.
            HeadEvent::Unit(Event::Fault(HeadError::ResetFailed { .. })) => None,
            HeadEvent::Unit(Event::Fault(error)) => Some(head_error(error, &port.name)),
            HeadEvent::Unit(Event::Connected(identity)) => port.other_unit(&identity.version),
            _ => None,
        }
    }

    fn rest(&mut self, now: Duration) {
        self.now = now;
        self.watched = None;
        // A standing head holds its load at low power; the usual setting, and cool for days (ptu-d46 section 10).
        let taken = self
            .head
            .halt(now)
            .and_then(|()| self.head.hold_power_low(now));
        self.note(taken);
    }

    fn is_rest(event: &HeadEvent) -> bool {
        match event {
            HeadEvent::Unit(Event::HoldPowerLow | Event::Fault(_)) | HeadEvent::NotTaken(_) => true,
            // The last word of the rest.
            HeadEvent::Unit(Event::Refused { command, .. }) => command == "THL",
            HeadEvent::Unit(_) => false,
        }
    }
}

/// What the head's driver says, by what people have to do about it.
pub(super) fn head_error(error: &HeadError, port: &str) -> DeviceError {
    let (device, port, detail) = (Device::Head, port.to_owned(), error.to_string());
    match error {
        HeadError::Silent { bytes_heard: 0 } => DeviceError::Silent {
            device,
            port,
            detail,
        },
        HeadError::Silent { .. } | HeadError::SetupRefused { .. } => DeviceError::WrongDevice {
            device,
            port,
            detail,
        },
        HeadError::ResetFailed { .. } => DeviceError::PositionLost { port, detail },
        _ => DeviceError::Fault {
            device,
            port,
            detail,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::{Driver, HeadDriver, Output};
    use crate::devices::error::Device;
    use crate::devices::lockstep::bench::ROOM;
    use crate::devices::port_name::PortName;
    use patrold_sim::emulator::{Emulation, EmulationOptions};
    use patrold_sim::world::Scene;
    use std::sync::Arc;
    use std::time::Duration;

    #[test]
    fn at_rest_it_stands_and_holds_at_low_power() {
        let scene = Scene::parse(ROOM).expect("a scene");
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        let options = EmulationOptions::seeded(1);
        let mut unit = Emulation::new(options, world, scene.map_from_base, Duration::ZERO);
        let port = PortName {
            device: Device::Head,
            name: "ptu".to_owned(),
            baud: 9600,
            unit: None,
        };
        let mut head = HeadDriver::new(&port, 9600, false);
        let (mut now, mut resting, mut sent) = (Duration::ZERO, false, Vec::new());
        head.connect(now);
        loop {
            while let Some(output) = head.poll() {
                match output {
                    Output::Send(bytes) => {
                        if resting {
                            sent.extend_from_slice(&bytes);
                        }
                        unit.handle_head_bytes(&bytes, now);
                    }
                    Output::Event(event) if resting && HeadDriver::is_rest(&event) => {
                        assert_eq!(String::from_utf8_lossy(&sent), "H PHL THL ");
                        return;
                    }
                    Output::Event(event) if HeadDriver::is_connected(&event) => {
                        resting = true;
                        head.rest(now);
                    }
                    Output::Event(_) => {}
                }
            }
            let next = [unit.next_head_event(), head.deadline()];
            now = now.max(next.into_iter().flatten().min().expect("something waits"));
            unit.advance(now);
            while let Some((_, bytes)) = unit.poll_head() {
                head.handle_bytes(&bytes, now);
            }
            head.handle_deadline(now);
            assert!(now < Duration::from_secs(60), "never at rest");
        }
    }
}
