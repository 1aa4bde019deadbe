//! The head's driver behind the common interface, its requests as commands; polls the position of an axis, each time as soon
//! as the last poll is answered and the interval between two polls is over.

use super::constants::{HEAD_PROBE_ATTEMPTS, POLL_INTERVAL};
use super::device_driver::{DeviceDriver, DriverOutput};
use super::error::{Device, DeviceError};
use super::port_config::PortConfig;
use super::recording::{ByteReader, ByteWriter, DialogueError};
use ptu::{Axis, HeadError, HeadLine, PtuAction, PtuDriver, PtuEvent, PtuOptions, RequestError};
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
    /// Shortest time between two polls.
    poll_interval: Duration,
    next_poll_at: Duration,
    rejected: VecDeque<RequestError>,
    now: Duration,
}

impl HeadDriver {
    fn collect_rejection(&mut self, result: Result<(), RequestError>) {
        self.rejected.extend(result.err());
    }

    fn with_driver(driver: PtuDriver, poll_interval: Duration) -> Self {
        Self {
            driver,
            polled: None,
            poll_interval,
            next_poll_at: Duration::ZERO,
            rejected: VecDeque::new(),
            now: Duration::ZERO,
        }
    }

    /// The axis to poll, while nothing else is pending.
    fn axis_to_poll(&self) -> Option<Axis> {
        self.polled
            .filter(|_| self.driver.is_connected() && self.driver.pending() == 0)
    }

    /// Sends the next poll when it is due.
    fn continue_polling(&mut self) {
        let Some(axis) = self.axis_to_poll() else {
            return;
        };
        if self.now >= self.next_poll_at {
            self.next_poll_at = self.now.saturating_add(self.poll_interval);
            // Connected and idle: never rejected.
            let _ = self.driver.poll_position(axis, self.now);
        }
    }
}

impl DeviceDriver for HeadDriver {
    type Command = HeadCommand;
    type Event = HeadEvent;

    fn new(_port: &PortConfig, baud: u32, probing: bool) -> Self {
        let mut options = PtuOptions {
            baud,
            ..PtuOptions::default()
        };
        if probing {
            options.attempts = HEAD_PROBE_ATTEMPTS;
            options.gives_up_on_garbage = true;
        }
        Self::with_driver(PtuDriver::new(options), POLL_INTERVAL)
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
                if self.polled.is_none() {
                    // At once, whenever the last one was: a recording that begins here does not know it.
                    self.next_poll_at = now;
                }
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
        // One that is due is no time limit: it goes out with the next output.
        let next_poll = self
            .axis_to_poll()
            .map(|_| self.next_poll_at)
            .filter(|at| *at > self.now);
        [self.driver.deadline(), next_poll]
            .into_iter()
            .flatten()
            .min()
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
        is_idle.then(|| {
            let mut state = ByteWriter::default();
            state.u32(self.driver.options().baud);
            state.u32(u32::try_from(self.poll_interval.as_micros()).unwrap_or(u32::MAX));
            state.0
        })
    }

    fn resumed(state: &[u8]) -> Result<Self, DialogueError> {
        let mut input = ByteReader::new(state);
        let options = PtuOptions {
            baud: input.u32("the line rate of the head")?,
            ..PtuOptions::default()
        };
        // Polls had no interval when there was none in the recording.
        let poll_interval_us = if input.is_at_end() {
            0
        } else {
            input.u32("the interval of polls")?
        };
        let poll_interval = Duration::from_micros(poll_interval_us.into());
        Ok(Self::with_driver(
            PtuDriver::resumed(options),
            poll_interval,
        ))
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
            HeadEvent::Ptu(PtuEvent::Fault(error)) => {
                Some(head_error(error, &port.name, &port.setting()))
            }
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
pub(super) fn head_error(error: &HeadError, port: &str, setting: &str) -> DeviceError {
    let (device, port, detail) = (Device::Head, port.to_owned(), error.to_string());
    let setting = setting.to_owned();
    match error {
        HeadError::Silent => DeviceError::Silent {
            device,
            port,
            setting,
            detail,
        },
        HeadError::NotAHead { line, .. } => DeviceError::WrongDevice {
            device,
            port,
            setting,
            detail,
            readable: *line != HeadLine::NotText,
        },
        HeadError::OutOfStep { .. } | HeadError::ImpossibleValue { .. } => {
            DeviceError::WrongDevice {
                device,
                port,
                setting,
                detail,
                readable: true,
            }
        }
        HeadError::SetupRefused { command, text } => DeviceError::Refused {
            device,
            port,
            command: command.clone(),
            detail: format!("{text}; power-cycle it if this repeats"),
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
    use super::{
        DeviceDriver, DriverOutput, HeadCommand, HeadDriver, HeadEvent, POLL_INTERVAL, head_error,
    };
    use crate::config::SettingOrigins;
    use crate::devices::error::Device;
    use crate::devices::lockstep::rig::ROOM;
    use crate::devices::port_config::PortConfig;
    use patrold_sim::emulator::{Emulation, EmulationOptions};
    use patrold_sim::world::Scene;
    use ptu::{Axis, HeadError, HeadLine, PtuEvent};
    use std::sync::Arc;
    use std::time::Duration;

    #[test]
    fn each_error_of_the_driver_is_one_line_with_port_and_remedy() {
        let text = |text: &str| text.to_owned();
        for (error, parts) in [
            (
                HeadError::Silent,
                &["is silent", "power and cable", "ptu.port"][..],
            ),
            (
                HeadError::NotAHead {
                    line: HeadLine::Laser,
                    heard: text("QT"),
                    bytes_heard: 2,
                },
                &[
                    "ptu.port",
                    "heard \"QT\" (2 bytes)",
                    "exchange the two ports",
                ],
            ),
            (
                HeadError::OutOfStep {
                    command: text("F"),
                    heard: text("*"),
                },
                &["ptu.port", "`F`", "replies come twice", "power-cycle"],
            ),
            (
                HeadError::ImpossibleValue {
                    command: text("TX"),
                    expected: text("more than 0"),
                    got: text("-907"),
                },
                &["ptu.port", "`TX` answered -907", "power-cycle"],
            ),
            (
                HeadError::SetupRefused {
                    command: text("PN"),
                    text: text("Axis Error"),
                },
                &["refused PN: Axis Error", "power-cycle"],
            ),
            (
                HeadError::ResetFailed {
                    text: text("Axis Error"),
                },
                &["Axis Error", "not trusted", "home it"],
            ),
            (
                HeadError::ResetTimedOut { waited_s: 60 },
                &["60 s", "reconnecting", "power-cycle"],
            ),
        ] {
            let told = head_error(&error, "/dev/ptu", "ptu.port").to_string();
            assert!(
                told.contains("pan-tilt on /dev/ptu") && !told.contains('\n'),
                "{told}"
            );
            for part in parts {
                assert!(told.contains(part), "{part}: {told}");
            }
        }
    }

    /// The driver on an emulated unit whose answers have no pace of a line.
    fn driver_and_unit() -> (HeadDriver, Emulation) {
        let scene = Scene::parse(ROOM).expect("a scene");
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        let mut options = EmulationOptions::seeded(1);
        options.head.set("pacing=off").expect("an option");
        options.head.set("latency=0/0").expect("an option");
        let unit = Emulation::new(options, world, scene.map_from_base, Duration::ZERO);
        let port = PortConfig {
            device: Device::Head,
            name: "ptu".to_owned(),
            baud: 9600,
            unit: None,
            origins: SettingOrigins::default(),
        };
        (HeadDriver::new(&port, 9600, false), unit)
    }

    /// Lets both work until `until`, or the driver is connected; what was sent, and the positions.
    fn work(
        head: &mut HeadDriver,
        unit: &mut Emulation,
        now: &mut Duration,
        until: Duration,
    ) -> (Vec<String>, Vec<i32>) {
        let (mut sent, mut positions) = (Vec::new(), Vec::new());
        loop {
            while let Some(output) = head.poll() {
                match output {
                    DriverOutput::Send(bytes) => {
                        sent.push(String::from_utf8_lossy(&bytes).into_owned());
                        unit.handle_head_bytes(&bytes, *now);
                    }
                    DriverOutput::Event(HeadEvent::Ptu(PtuEvent::Position { steps, .. })) => {
                        positions.push(steps);
                    }
                    DriverOutput::Event(event) if HeadDriver::is_connected(&event) => {
                        return (sent, positions);
                    }
                    DriverOutput::Event(_) | DriverOutput::SetBitRate(_) => {}
                }
            }
            let next = [unit.next_head_event(), head.deadline(), Some(until)];
            *now = (*now).max(next.into_iter().flatten().min().expect("an end"));
            if *now >= until {
                return (sent, positions);
            }
            unit.advance(*now);
            while let Some((_, bytes)) = unit.poll_head() {
                head.handle_bytes(&bytes, *now);
            }
            head.handle_deadline(*now);
        }
    }

    #[test]
    fn a_link_without_a_pace_is_polled_at_the_rate_of_a_9600_baud_line() {
        let (mut head, mut unit) = driver_and_unit();
        let mut now = Duration::ZERO;
        head.connect(now);
        work(&mut head, &mut unit, &mut now, Duration::from_secs(30));
        head.command(HeadCommand::PollPosition(Some(Axis::Tilt)), now);
        let until = now + Duration::from_secs(2);
        let (sent, positions) = work(&mut head, &mut unit, &mut now, until);
        assert_eq!((sent.len(), positions.len()), (160, 160), "80 a second");
        // Another request goes out between two polls, at once.
        head.command(HeadCommand::QueryHealth, now);
        let Some(DriverOutput::Send(bytes)) = head.poll() else {
            panic!("it waits")
        };
        assert_eq!(bytes, b"O ");
        unit.handle_head_bytes(&bytes, now);
        head.command(HeadCommand::PollPosition(None), now);
        let until = now + Duration::from_secs(1);
        let (sent, _) = work(&mut head, &mut unit, &mut now, until);
        assert_eq!(sent, [""; 0], "nothing is polled any more");
        assert_eq!(head.deadline(), None);
    }

    #[test]
    fn the_state_of_an_idle_driver_is_read_back_and_an_older_one_has_no_interval() {
        let (mut head, mut unit) = driver_and_unit();
        let mut now = Duration::ZERO;
        head.connect(now);
        work(&mut head, &mut unit, &mut now, Duration::from_secs(30));
        while head.poll().is_some() {}
        let state = head.idle_state().expect("idle");
        let resumed = HeadDriver::resumed(&state).expect("readable");
        assert_eq!(resumed.poll_interval, POLL_INTERVAL);
        assert_eq!(resumed.driver.options().baud, 9600);
        let old = HeadDriver::resumed(&state[..4]).expect("readable");
        assert_eq!(old.poll_interval, Duration::ZERO);
        assert!(HeadDriver::resumed(&state[..6]).is_err());
    }

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
            origins: SettingOrigins::default(),
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
                    DriverOutput::Event(_) | DriverOutput::SetBitRate(_) => {}
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
