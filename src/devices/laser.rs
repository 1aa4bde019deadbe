//! The laser's driver behind the common interface, its requests as commands.

use super::constants::{BITS_PER_BYTE, PROBE_ATTEMPTS, PROBE_REPLY_LIMIT};
use super::device_driver::{DeviceDriver, DriverOutput};
use super::error::{Device, DeviceError};
use super::port_config::{LineKind, PortConfig};
use super::recording::{DialogueError, decode_laser, encode_laser};
use scip::{LaserAction, LaserEvent, LaserLine, ScipDriver, ScipError, ScipOptions, StreamPlan};
use std::time::Duration;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum LaserCommand {
    /// Read its timer N times; turns the laser off.
    ExchangeTime(u32),
    /// Stream scans until stopped.
    Stream(StreamPlan),
    /// Stop, laser off.
    Stop,
}

#[derive(Debug)]
pub(crate) struct LaserDriver {
    driver: ScipDriver,
    rejected: Option<ScipError>,
}

impl LaserDriver {
    fn collect_rejection(&mut self, result: Result<(), ScipError>) {
        if let Err(error) = result {
            self.rejected = Some(error);
        }
    }
}

impl DeviceDriver for LaserDriver {
    type Command = LaserCommand;
    type Event = LaserEvent;

    fn new(port: &PortConfig, baud: u32, probing: bool) -> Self {
        let mut options = ScipOptions::default();
        let line = port.line_kind();
        if matches!(line, LineKind::Rs232 | LineKind::PseudoTerminal) {
            options.wanted_bit_rate = Some(port.baud);
        }
        if line == LineKind::Rs232 {
            options.link_bytes_per_second = Some(baud / BITS_PER_BYTE);
            // `RS` resets a sensor on RS-232 to its default line rate: the connection would be lost.
            options.reset_on_connect = false;
        }
        if probing {
            options.gives_up_on_garbage = true;
            // An emulated device has nearly always the rate of the configuration, and perhaps a fast clock.
            options.probe = match line {
                LineKind::PseudoTerminal if baud == port.baud => None,
                LineKind::PseudoTerminal => Some((PROBE_REPLY_LIMIT, 1)),
                _ => Some((PROBE_REPLY_LIMIT, PROBE_ATTEMPTS)),
            };
        }
        Self {
            driver: ScipDriver::new(options),
            rejected: None,
        }
    }

    fn connect(&mut self, now: Duration) {
        self.driver.connect(now);
    }

    fn command(&mut self, command: LaserCommand, now: Duration) {
        match command {
            LaserCommand::ExchangeTime(samples) => {
                let result = self.driver.exchange_time(samples, now);
                self.collect_rejection(result);
            }
            LaserCommand::Stream(plan) => {
                let result = self.driver.start_streaming(plan, now);
                self.collect_rejection(result);
            }
            LaserCommand::Stop => self.driver.stop(now),
        }
    }

    fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        self.driver.handle_bytes(bytes, now);
    }

    fn handle_deadline(&mut self, now: Duration) {
        self.driver.handle_deadline(now);
    }

    fn deadline(&self) -> Option<Duration> {
        self.driver.deadline()
    }

    fn poll(&mut self) -> Option<DriverOutput<LaserEvent>> {
        match self.driver.poll_action() {
            Some(LaserAction::Send(bytes)) => Some(DriverOutput::Send(bytes)),
            Some(LaserAction::SetBitRate(bit_s)) => Some(DriverOutput::SetBitRate(bit_s)),
            Some(LaserAction::Event(event)) => Some(DriverOutput::Event(event)),
            None => self
                .rejected
                .take()
                .map(|error| DriverOutput::Event(LaserEvent::RequestFailed(error))),
        }
    }

    fn idle_state(&self) -> Option<Vec<u8>> {
        let identity = self.driver.identity()?;
        let is_idle = self.driver.is_idle() && self.rejected.is_none();
        is_idle.then(|| encode_laser(self.driver.options(), identity))
    }

    fn resumed(state: &[u8]) -> Result<Self, DialogueError> {
        let (options, identity) = decode_laser(state)?;
        Ok(Self {
            driver: ScipDriver::resumed(options, identity),
            rejected: None,
        })
    }

    fn is_sign_of_life(event: &LaserEvent) -> bool {
        matches!(event, LaserEvent::Scan { .. })
    }

    fn keeps_bit_rate(event: &LaserEvent) -> bool {
        matches!(
            event,
            LaserEvent::BitRateKept { .. }
                | LaserEvent::ConnectionFailed(ScipError::BitRateLost { .. })
        )
    }

    fn is_connected(event: &LaserEvent) -> bool {
        matches!(event, LaserEvent::Connected(_))
    }

    fn fault(event: &LaserEvent, port: &PortConfig) -> Option<DeviceError> {
        match event {
            LaserEvent::ConnectionFailed(error) => {
                Some(laser_error(error, &port.name, &port.setting()))
            }
            LaserEvent::Connected(identity) => port.unit_mismatch(&identity.serial),
            _ => None,
        }
    }

    fn stop(&mut self, now: Duration) {
        self.driver.stop(now);
    }

    fn is_stopped(event: &LaserEvent) -> bool {
        matches!(
            event,
            LaserEvent::Stopped | LaserEvent::ConnectionFailed(_) | LaserEvent::RequestFailed(_)
        )
    }
}

/// A driver error, sorted by what the operator has to do.
pub(super) fn laser_error(error: &ScipError, port: &str, setting: &str) -> DeviceError {
    let (device, port, detail) = (Device::Laser, port.to_owned(), error.to_string());
    let setting = setting.to_owned();
    match error {
        ScipError::NoReply { .. } => DeviceError::Silent {
            device,
            port,
            setting,
            detail,
        },
        ScipError::NotALaser { line, .. } => DeviceError::WrongDevice {
            device,
            port,
            setting,
            detail,
            readable: *line != LaserLine::NotText,
        },
        ScipError::Scip11Only { .. } => DeviceError::WrongDevice {
            device,
            port,
            setting,
            detail,
            readable: true,
        },
        ScipError::BadReply { command, last, .. } if last.refusal().is_some() => {
            DeviceError::Refused {
                device,
                port,
                command: command.to_string(),
                detail: format!("{last}; power-cycle it if this repeats"),
            }
        }
        ScipError::Plan { what, .. } => DeviceError::Refused {
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

#[cfg(test)]
mod tests {
    use super::{DeviceDriver, DriverOutput, LaserCommand, LaserDriver, laser_error};
    use crate::config::SettingOrigins;
    use crate::devices::error::Device;
    use crate::devices::lockstep::rig::TestRig;
    use crate::devices::port_config::PortConfig;
    use patrold_sim::emulator::EmulationOptions;
    use scip::{
        LaserEvent, LaserLine, ParameterError, ReplyError, ScipCommand, ScipDriver, ScipError,
        ScipOptions, StatusMeaning, StreamPlan, ValueCoding,
    };
    use std::time::Duration;

    #[test]
    fn a_request_that_cannot_be_made_is_answered() {
        let port = PortConfig {
            device: Device::Laser,
            name: "/dev/laser".to_owned(),
            baud: 19_200,
            unit: None,
            origins: SettingOrigins::default(),
        };
        let mut laser = LaserDriver::new(&port, 19_200, false);
        let plan = StreamPlan {
            first_step: 44,
            last_step: 725,
            cluster: 1,
            interval: 0,
            coding: ValueCoding::ThreeCharacter,
            count: 0,
        };
        // It is not connected.
        for command in [LaserCommand::ExchangeTime(1), LaserCommand::Stream(plan)] {
            laser.command(command, Duration::ZERO);
            let Some(DriverOutput::Event(event)) = laser.poll() else {
                panic!("no answer")
            };
            let not_ready = matches!(event, LaserEvent::RequestFailed(ScipError::NotReady { .. }));
            assert!(not_ready, "{event:?}");
            assert!(LaserDriver::is_stopped(&event), "its laser is off");
            assert!(laser.poll().is_none(), "once");
        }
    }

    #[test]
    fn it_is_idle_once_everything_is_answered() {
        let rig = TestRig::ready(EmulationOptions::seeded(1));
        let identity = rig.laser_identity.expect("connected");
        let mut laser = LaserDriver {
            driver: ScipDriver::resumed(ScipOptions::default(), identity),
            rejected: None,
        };
        assert!(laser.idle_state().is_some());
        let backwards = StreamPlan {
            first_step: 725,
            last_step: 44,
            cluster: 1,
            interval: 0,
            coding: ValueCoding::ThreeCharacter,
            count: 0,
        };
        laser.command(LaserCommand::Stream(backwards), Duration::ZERO);
        assert!(laser.idle_state().is_none(), "a refusal is to be answered");
        assert!(laser.poll().is_some());
        assert!(laser.idle_state().is_some());
        laser.command(LaserCommand::ExchangeTime(1), Duration::ZERO);
        assert!(laser.idle_state().is_none(), "it is asked");
    }

    #[test]
    fn it_is_stopped_by_its_answer_and_by_its_end() {
        assert!(LaserDriver::is_stopped(&LaserEvent::Stopped));
        let lost = ScipError::BitRateLost { wanted: 115_200 };
        assert!(LaserDriver::is_stopped(&LaserEvent::ConnectionFailed(lost)));
        for event in [LaserEvent::Streaming, LaserEvent::LostScans(1)] {
            assert!(!LaserDriver::is_stopped(&event), "{event:?}");
        }
    }

    #[test]
    fn a_rate_that_the_laser_kept_is_not_asked_for_again() {
        let lost = ScipError::BitRateLost { wanted: 115_200 };
        assert!(LaserDriver::keeps_bit_rate(&LaserEvent::ConnectionFailed(
            lost
        )));
        assert!(LaserDriver::keeps_bit_rate(&LaserEvent::BitRateKept {
            wanted: 115_200
        }));
        let stale = ScipError::StaleStamp {
            stamp_ms: 1,
            repeats: 3,
        };
        for event in [LaserEvent::Stopped, LaserEvent::ConnectionFailed(stale)] {
            assert!(!LaserDriver::keeps_bit_rate(&event), "{event:?}");
        }
    }

    #[test]
    fn each_error_of_the_driver_is_one_line_with_port_and_remedy() {
        let bad_reply = |command, last| ScipError::BadReply {
            command,
            attempts: 3,
            last,
        };
        let refused = |meaning| ReplyError::Refused {
            command: ScipCommand::TimeEnter,
            meaning,
        };
        let heard = |line| ScipError::NotALaser {
            line,
            heard: b"QT\n".as_slice().into(),
            bytes: 3,
        };
        for (error, parts) in [
            (
                ScipError::NoReply {
                    command: ScipCommand::Quit,
                    attempts: 3,
                    timeout: Duration::from_secs(1),
                },
                &["is silent", "power and cable", "laser.port"][..],
            ),
            (
                heard(LaserLine::Loopback),
                &["laser.port", "heard \"QT\\n\"", "bridged"],
            ),
            (heard(LaserLine::NotText), &["laser.port", "line rate"]),
            (
                ScipError::Scip11Only {
                    heard: b"E".as_slice().into(),
                },
                &["laser.port", "SCIP 1.1 only", "updated"],
            ),
            (
                bad_reply(ScipCommand::TimeEnter, refused(StatusMeaning::Denied)),
                &["refused TM0", "present state", "power-cycle"],
            ),
            (
                bad_reply(
                    ScipCommand::Stream,
                    refused(StatusMeaning::BadParameter(ParameterError::EndOutOfRange)),
                ),
                &["refused MD/MS/ME", "power-cycle"],
            ),
            (
                bad_reply(
                    ScipCommand::Parameters,
                    ReplyError::ValueCount {
                        expected: 1,
                        got: 2,
                    },
                ),
                &["no usable reply to PP", "power-cycle"],
            ),
            (
                ScipError::BitRateLost { wanted: 115_200 },
                &["115200 bit/s", "power-cycle"],
            ),
        ] {
            let text = laser_error(&error, "/dev/laser", "laser.port").to_string();
            assert!(
                text.contains("laser on /dev/laser") && !text.contains('\n'),
                "{text}"
            );
            for part in parts {
                assert!(text.contains(part), "{part}: {text}");
            }
        }
    }
}
