//! A driver whose inputs and outputs are recorded.

use super::dialogue::DialogueEntryKind;
use super::tap::DialogueTap;
use crate::devices::device_driver::{DeviceDriver, DriverOutput};
use crate::devices::error::Device;
use crate::devices::port_config::PortConfig;
use std::time::Duration;

/// Passes everything on to the driver, and notes it where a sweep is recorded. A time limit that is not over is no input.
#[derive(Debug)]
pub(crate) struct RecordedDriver<D> {
    driver: D,
    device: Device,
    /// The recording to join when the driver is idle, or that it has joined.
    tap: Option<DialogueTap>,
    /// Instant of the last input.
    now: Duration,
}

impl<D: DeviceDriver> RecordedDriver<D> {
    pub(crate) fn new(port: &PortConfig, baud: u32, probing: bool) -> Self {
        Self {
            driver: D::new(port, baud, probing),
            device: port.device,
            tap: None,
            now: Duration::ZERO,
        }
    }

    /// From the next idle moment on everything is noted there.
    pub(crate) fn record(&mut self, tap: DialogueTap) {
        self.tap = Some(tap);
    }

    fn note(&mut self, kind: &DialogueEntryKind, now: Duration, bytes: Option<&[u8]>) {
        self.now = now;
        if let Some(tap) = &self.tap {
            tap.note_driver(self.device, kind, now, bytes);
        }
    }

    pub(crate) fn connect(&mut self, now: Duration) {
        self.now = now;
        self.driver.connect(now);
    }

    pub(crate) fn command(&mut self, command: D::Command, now: Duration) {
        self.note(&DialogueEntryKind::CommandTaken, now, None);
        self.driver.command(command, now);
    }

    pub(crate) fn handle_bytes(&mut self, bytes: &[u8], now: Duration) {
        let kind = DialogueEntryKind::Received(Vec::new());
        self.note(&kind, now, Some(bytes));
        self.driver.handle_bytes(bytes, now);
    }

    pub(crate) fn handle_deadline(&mut self, now: Duration) {
        if self.driver.deadline().is_some_and(|due| due <= now) {
            self.note(&DialogueEntryKind::DriverDeadline, now, None);
            self.driver.handle_deadline(now);
        }
    }

    pub(crate) fn deadline(&self) -> Option<Duration> {
        self.driver.deadline()
    }

    pub(crate) fn poll(&mut self) -> Option<DriverOutput<D::Event>> {
        let output = self.driver.poll();
        match &output {
            Some(DriverOutput::Send(bytes)) => {
                let kind = DialogueEntryKind::Sent(Vec::new());
                self.note(&kind, self.now, Some(bytes));
            }
            Some(DriverOutput::Event(_)) => {
                if let Some(tap) = &self.tap {
                    tap.note_spoken(self.device);
                }
            }
            // A part of connecting, of which nothing is recorded.
            Some(DriverOutput::SetBitRate(_)) => {}
            None => {
                let (driver, device) = (&self.driver, self.device);
                self.tap
                    .take_if(|tap| !tap.join(device, || driver.idle_state()));
            }
        }
        output
    }

    pub(crate) fn stop(&mut self, now: Duration) {
        self.now = now;
        self.driver.stop(now);
    }
}
