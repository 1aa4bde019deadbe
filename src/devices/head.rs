//! The head's driver behind the common interface, its requests as commands; polls the position of an axis as fast as it
//! answers.

use super::device_driver::{DeviceDriver, DriverOutput};
use super::error::{Device, DeviceError};
use super::port_config::PortConfig;
use super::recording::{ByteReader, DialogueError};
use ptu::{Axis, HeadError, PtuAction, PtuDriver, PtuEvent, PtuOptions, RequestError};
use std::collections::VecDeque;
use std::time::Duration;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum HeadCommand {
    /// Connect anew, which sets modes and limits and reads the identity.
    SetUp,
    /// Calibrate both axes (drive to the stops).
    Home,
    /// Set the speed of an axis, counts per second.
    SetSpeed(Axis, i32),
    /// Move an axis to a position, counts.
    MoveTo(Axis, i32),
    /// Poll the position of this axis continuously; `None`: stop polling.
    PollPosition(Option<Axis>),
    /// Read supply voltage and temperatures.
    QueryHealth,
    /// Stop both axes.
    Halt,
    /// Set hold power low, for parking.
    LowerHoldPower,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum HeadEvent {
    /// From the driver.
    Ptu(PtuEvent),
    /// The driver rejected a request.
    Rejected(RequestError),
}

#[derive(Debug)]
pub(crate) struct HeadDriver {
    driver: PtuDriver,
    polled: Option<Axis>,
    rejected: VecDeque<RequestError>,
    now: Duration,
}

impl HeadDriver {
    fn collect_rejection(&mut self, result: Result<(), RequestError>) {
        self.rejected.extend(result.err());
    }

    /// Sends the next poll when nothing else is pending.
    fn continue_polling(&mut self) {
        let Some(axis) = self.polled else { return };
        if self.driver.is_connected() && self.driver.pending() == 0 {
            // Connected and idle: never rejected.
            let _ = self.driver.poll_position(axis, self.now);
        }
    }
}

impl DeviceDriver for HeadDriver {
    type Command = HeadCommand;
    type Event = HeadEvent;

    fn new(_port: &PortConfig, baud: u32, _probing: bool) -> Self {
        let options = PtuOptions {
            baud,
            ..PtuOptions::default()
        };
        Self {
            driver: PtuDriver::new(options),
            polled: None,
            rejected: VecDeque::new(),
            now: Duration::ZERO,
        }
    }

    fn connect(&mut self, now: Duration) {
        self.now = now;
        self.driver.connect(now);
    }

    fn command(&mut self, command: HeadCommand, now: Duration) {
        self.now = now;
        let result = match command {
            HeadCommand::SetUp => {
                self.driver.connect(now);
                Ok(())
            }
            HeadCommand::Home => self.driver.reset(now),
            HeadCommand::SetSpeed(axis, speed) => self.driver.set_speed(axis, speed, now),
            HeadCommand::MoveTo(axis, target) => self.driver.move_to(axis, target, now),
            HeadCommand::PollPosition(axis) => {
                self.polled = axis;
                Ok(())
            }
            HeadCommand::QueryHealth => self.driver.query_health(now),
            HeadCommand::Halt => self.driver.halt(now),
            HeadCommand::LowerHoldPower => self.driver.hold_power_low(now),
        };
        self.collect_rejection(result);
    }

    fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.now = now;
        self.driver.handle_bytes(bytes, now);
    }

    fn handle_deadline(&mut self, now: Duration) {
        self.now = now;
        self.driver.handle_deadline(now);
    }

    fn deadline(&self) -> Option<Duration> {
        self.driver.deadline()
    }

    fn poll(&mut self) -> Option<DriverOutput<HeadEvent>> {
        let mut action = self.driver.poll_action();
        if action.is_none() {
            self.continue_polling();
            action = self.driver.poll_action();
        }
        match action {
            Some(PtuAction::Send(bytes)) => Some(DriverOutput::Send(bytes)),
            Some(PtuAction::Event(event)) => Some(DriverOutput::Event(HeadEvent::Ptu(event))),
            None => self
                .rejected
                .pop_front()
                .map(|error| DriverOutput::Event(HeadEvent::Rejected(error))),
        }
    }

    fn idle_state(&self) -> Option<Vec<u8>> {
        let is_idle = self.driver.is_idle() && self.polled.is_none() && self.rejected.is_empty();
        is_idle.then(|| self.driver.options().baud.to_le_bytes().to_vec())
    }

    fn resumed(state: &[u8]) -> Result<Self, DialogueError> {
        let options = PtuOptions {
            baud: ByteReader::new(state).u32("the line rate of the head")?,
            ..PtuOptions::default()
        };
        Ok(Self {
            driver: PtuDriver::resumed(options),
            polled: None,
            rejected: VecDeque::new(),
            now: Duration::ZERO,
        })
    }

    fn is_sign_of_life(event: &HeadEvent) -> bool {
        matches!(
            event,
            HeadEvent::Ptu(PtuEvent::Position { .. } | PtuEvent::HomeDone { .. })
        )
    }

    fn is_connected(event: &HeadEvent) -> bool {
        matches!(event, HeadEvent::Ptu(PtuEvent::Connected(_)))
    }

    fn fault(event: &HeadEvent, port: &PortConfig) -> Option<DeviceError> {
        match event {
            // The dialogue continues after a failed calibration.
            HeadEvent::Ptu(PtuEvent::Fault(HeadError::ResetFailed { .. })) => None,
            HeadEvent::Ptu(PtuEvent::Fault(error)) => Some(head_error(error, &port.name)),
            HeadEvent::Ptu(PtuEvent::Connected(identity)) => port.unit_mismatch(&identity.version),
            _ => None,
        }
    }

    fn stop(&mut self, now: Duration) {
        self.now = now;
        self.polled = None;
        // Low hold power holds the load and keeps the motors cool (ptu-d46 section 10).
        let result = self
            .driver
            .halt(now)
            .and_then(|()| self.driver.hold_power_low(now));
        self.collect_rejection(result);
    }

    fn is_stopped(event: &HeadEvent) -> bool {
        match event {
            HeadEvent::Ptu(PtuEvent::HoldPowerLow | PtuEvent::Fault(_))
            | HeadEvent::Rejected(_) => true,
            // The last request of `stop`.
            HeadEvent::Ptu(PtuEvent::Refused { command, .. }) => command == "THL",
            HeadEvent::Ptu(_) => false,
        }
    }
}

/// A driver error, sorted by what the operator has to do.
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
    use super::{DeviceDriver, DriverOutput, HeadDriver};
    use crate::devices::error::Device;
    use crate::devices::lockstep::rig::ROOM;
    use crate::devices::port_config::PortConfig;
    use patrold_sim::emulator::{Emulation, EmulationOptions};
    use patrold_sim::world::Scene;
    use std::sync::Arc;
    use std::time::Duration;

    #[test]
    fn stopped_it_is_halted_and_holds_at_low_power() {
        let scene = Scene::parse(ROOM).expect("a scene");
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        let options = EmulationOptions::seeded(1);
        let mut unit = Emulation::new(options, world, scene.map_from_base, Duration::ZERO);
        let port = PortConfig {
            device: Device::Head,
            name: "ptu".to_owned(),
            baud: 9600,
            unit: None,
        };
        let mut head = HeadDriver::new(&port, 9600, false);
        let (mut now, mut stopping, mut sent) = (Duration::ZERO, false, Vec::new());
        head.connect(now);
        loop {
            while let Some(output) = head.poll() {
                match output {
                    DriverOutput::Send(bytes) => {
                        if stopping {
                            sent.extend_from_slice(&bytes);
                        }
                        unit.handle_head_bytes(&bytes, now);
                    }
                    DriverOutput::Event(event) if stopping && HeadDriver::is_stopped(&event) => {
                        assert_eq!(String::from_utf8_lossy(&sent), "H PHL THL ");
                        return;
                    }
                    DriverOutput::Event(event) if HeadDriver::is_connected(&event) => {
                        stopping = true;
                        head.stop(now);
                    }
                    DriverOutput::Event(_) => {}
                }
            }
            let next = [unit.next_head_event(), head.deadline()];
            now = now.max(next.into_iter().flatten().min().expect("a deadline"));
            unit.advance(now);
            while let Some((_, bytes)) = unit.poll_head() {
                head.handle_bytes(&bytes, now);
            }
            head.handle_deadline(now);
            assert!(now < Duration::from_secs(60), "never stopped");
        }
    }
}
