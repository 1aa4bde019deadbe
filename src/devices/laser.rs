//! The laser's driver with its requests as data.

use super::constants::{BITS_PER_BYTE, PROBE};
use super::driver::{Driver, Output};
use super::error::{Device, DeviceError};
use super::port_name::{Line, PortName};
use scip::{Action, Event, Sensor, SensorError, SensorOptions, StreamPlan};
use std::time::Duration;

/// What can be asked of the laser.
#[derive(Debug, Clone, PartialEq)]
pub enum LaserCommand {
    /// Read its timer so many times; turns the laser off.
    ExchangeTime(u32),
    /// Stream scans until stopped.
    Stream(StreamPlan),
    /// Stop, laser off.
    Stop,
}

/// The laser's driver.
#[derive(Debug)]
pub struct LaserDriver {
    sensor: Sensor,
    refused: Option<SensorError>,
}

impl LaserDriver {
    fn note(&mut self, taken: Result<(), SensorError>) {
        if let Err(error) = taken {
            self.refused = Some(error);
        }
    }
}

impl Driver for LaserDriver {
    type Command = LaserCommand;
    type Event = Event;

    fn new(port: &PortName, baud: u32, probing: bool) -> Self {
        let mut options = SensorOptions::default();
        if port.line() == Line::Rs232 {
            options.link_bytes_per_second = Some(baud / BITS_PER_BYTE);
            // `RS` puts a sensor on RS-232 back to its default rate: the line would be lost at once.
            options.reset_on_connect = false;
        }
        if probing {
            (options.reply_timeout, options.attempts) = PROBE;
        }
        Self {
            sensor: Sensor::new(options),
            refused: None,
        }
    }

    fn connect(&mut self, now: Duration) {
        self.sensor.connect(now);
    }

    fn command(&mut self, command: LaserCommand, now: Duration) {
        match command {
            LaserCommand::ExchangeTime(samples) => {
                let taken = self.sensor.exchange_time(samples, now);
                self.note(taken);
            }
            LaserCommand::Stream(plan) => {
                let taken = self.sensor.start_streaming(plan, now);
                self.note(taken);
            }
            LaserCommand::Stop => self.sensor.stop(now),
        }
    }

    fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.sensor.handle_bytes(bytes, now);
    }

    fn handle_deadline(&mut self, now: Duration) {
        self.sensor.handle_deadline(now);
    }

    fn deadline(&self) -> Option<Duration> {
        self.sensor.deadline()
    }

    fn poll(&mut self) -> Option<Output<Event>> {
        match self.sensor.poll_action() {
            Some(Action::Send(bytes)) => Some(Output::Send(bytes)),
            Some(Action::Event(event)) => Some(Output::Event(event)),
            None => self
                .refused
                .take()
                .map(|error| Output::Event(Event::Failed(error))),
        }
    }

    fn is_proof_of_life(event: &Event) -> bool {
        matches!(event, Event::Scan { .. })
    }

    fn is_connected(event: &Event) -> bool {
        matches!(event, Event::Connected(_))
    }

    fn fault(event: &Event, port: &PortName) -> Option<DeviceError> {
        match event {
            Event::Fault(error) => Some(laser_error(error, &port.name)),
            Event::Connected(identity) => port.other_unit(&identity.serial),
            _ => None,
        }
    }

    fn rest(&mut self, now: Duration) {
        self.sensor.stop(now);
    }

    fn is_rest(event: &Event) -> bool {
        matches!(event, Event::Stopped | Event::Fault(_) | Event::Failed(_))
    }
}

/// What the laser's driver says, by what people have to do about it.
pub(super) fn laser_error(error: &SensorError, port: &str) -> DeviceError {
    let (device, port, detail) = (Device::Laser, port.to_owned(), error.to_string());
    match error {
        SensorError::NoReply { .. } => DeviceError::Silent {
            device,
            port,
            detail,
        },
        SensorError::BadReply { .. } | SensorError::ConnectTimeout { .. } => {
            DeviceError::WrongDevice {
                device,
                port,
                detail,
            }
        }
        SensorError::Plan { what, .. } => DeviceError::Refused {
            device,
            port,
            command: (*what).to_owned(),
            detail,
        },
        _ => DeviceError::Fault {
            device,
            port,
            detail,
        },
    }
}
