//! The sweep of a recorded dialogue: the drivers and the sweep again, with their inputs of then.

use super::dialogue::{DialogueEnd, DialogueEntry, DialogueEntryKind, SweepDialogue};
use super::error::DialogueError;
use super::recorded_plan::decode_plan;
use crate::devices::device_driver::{DeviceDriver, DriverOutput};
use crate::devices::error::{Device, DeviceError};
use crate::devices::head::HeadDriver;
use crate::devices::laser::LaserDriver;
use crate::devices::sweep_run::{SweepAction, SweepRun};
use patrold_engine::sweep::RawSweep;
use std::collections::VecDeque;
use std::time::Duration;

/// What a dialogue gives.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayedSweep {
    /// The sweep, or why there is none.
    pub sweep: Result<RawSweep, DeviceError>,
    /// How it ended when it was recorded.
    pub end: DialogueEnd,
}

/// Why a dialogue gives nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// It cannot be read.
    #[error(transparent)]
    Unreadable(#[from] DialogueError),
    /// The drivers of this program talk otherwise than those that recorded it.
    #[error(
        "recorded dialogue: {device} at {at_s:.3} s: {what}; it was recorded by a patrold whose driver differs"
    )]
    OtherDriver {
        /// The device.
        device: Device,
        /// Since the sweep began, seconds.
        at_s: f64,
        /// What differs.
        what: String,
    },
    /// It ends before the sweep does.
    #[error("recorded dialogue: it ends before the sweep does ({why})")]
    Unfinished {
        /// What it says of its end.
        why: String,
    },
}

/// Assembles nothing: gives the raw sweep of a recorded dialogue.
///
/// # Errors
/// [`ReplayError`].
pub fn replay_sweep(bytes: &[u8]) -> Result<ReplayedSweep, ReplayError> {
    let dialogue = SweepDialogue::from_bytes(bytes)?;
    let (plan, ports) = decode_plan(&dialogue.plan)?;
    let mut laser = ReplayedPort::<LaserDriver>::new(Device::Laser, &dialogue)?;
    let mut head = ReplayedPort::<HeadDriver>::new(Device::Head, &dialogue)?;
    let mut run = SweepRun::new(plan, ports, dialogue.began_at);
    let mut outcome = None;
    for entry in &dialogue.entries {
        while let Some(action) = run.poll_action() {
            match action {
                SweepAction::Laser(command) => laser.commands.push_back(command),
                SweepAction::Head(command) => head.commands.push_back(command),
                SweepAction::Note(..) => {}
            }
        }
        outcome = outcome.or_else(|| run.take_outcome());
        if outcome.is_some() {
            break;
        }
        match (&entry.kind, entry.device) {
            (DialogueEntryKind::EventHandled, Device::Laser) => {
                run.on_laser(laser.next_event(entry)?, entry.at);
            }
            (DialogueEntryKind::EventHandled, Device::Head) => {
                run.on_head(head.next_event(entry)?, entry.at);
            }
            (DialogueEntryKind::SweepDeadline, _) => run.on_time(entry.at),
            (DialogueEntryKind::Cancelled, _) => run.cancel(entry.at),
            (DialogueEntryKind::PortLost, device) => {
                let lost = DeviceError::NotConnected {
                    device,
                    port: String::new(),
                    detail: "its port was lost".to_owned(),
                };
                run.on_lost(device, lost, entry.at);
            }
            // Inputs and outputs of the drivers, which are asked for when the sweep takes their events.
            _ => {}
        }
    }
    let why = || match &dialogue.end {
        DialogueEnd::Complete => "it says that it is complete".to_owned(),
        DialogueEnd::Failed(why) => why.clone(),
        DialogueEnd::TooLong => "it reached the largest size of a recording".to_owned(),
    };
    let sweep = outcome
        .or_else(|| run.take_outcome())
        .ok_or_else(|| ReplayError::Unfinished { why: why() })?;
    Ok(ReplayedSweep {
        sweep,
        end: dialogue.end,
    })
}

/// A driver that is given what it was given then.
struct ReplayedPort<'a, D: DeviceDriver> {
    device: Device,
    driver: D,
    began_at: Duration,
    /// Its inputs and outputs.
    entries: VecDeque<&'a DialogueEntry>,
    /// Of the sweep, not yet taken.
    commands: VecDeque<D::Command>,
    events: VecDeque<D::Event>,
}

impl<'a, D: DeviceDriver> ReplayedPort<'a, D> {
    fn new(device: Device, dialogue: &'a SweepDialogue) -> Result<Self, ReplayError> {
        let state = match device {
            Device::Laser => &dialogue.laser,
            Device::Head => &dialogue.head,
        };
        let is_of_driver = |entry: &&DialogueEntry| {
            use DialogueEntryKind as Kind;
            let of_driver = matches!(
                entry.kind,
                Kind::Received(_) | Kind::Sent(_) | Kind::CommandTaken | Kind::DriverDeadline
            );
            of_driver && entry.device == device
        };
        Ok(Self {
            device,
            driver: D::resumed(state)?,
            began_at: dialogue.began_at,
            entries: dialogue.entries.iter().filter(is_of_driver).collect(),
            commands: VecDeque::new(),
            events: VecDeque::new(),
        })
    }

    /// The event that the sweep took at `taken`.
    fn next_event(&mut self, taken: &DialogueEntry) -> Result<D::Event, ReplayError> {
        loop {
            if let Some(event) = self.events.pop_front() {
                return Ok(event);
            }
            let Some(input) = self.entries.pop_front() else {
                let what = "it gave an event that its bytes do not give".to_owned();
                return Err(self.differs(taken, what));
            };
            match &input.kind {
                DialogueEntryKind::Received(bytes) => self.driver.handle_bytes(bytes, input.at),
                DialogueEntryKind::DriverDeadline => self.driver.handle_deadline(input.at),
                DialogueEntryKind::CommandTaken => match self.commands.pop_front() {
                    Some(command) => self.driver.command(command, input.at),
                    None => {
                        let what = "it took a command that is not given".to_owned();
                        return Err(self.differs(input, what));
                    }
                },
                kind => {
                    let what = format!("it {}, which is not sent now", in_words(kind));
                    return Err(self.differs(input, what));
                }
            }
            self.drain(input)?;
        }
    }

    /// What it sends must be what it sent then.
    fn drain(&mut self, input: &DialogueEntry) -> Result<(), ReplayError> {
        while let Some(output) = self.driver.poll() {
            match output {
                DriverOutput::Event(event) => self.events.push_back(event),
                DriverOutput::SetBitRate(_) => {}
                DriverOutput::Send(bytes) => match self.entries.pop_front().map(|e| &e.kind) {
                    Some(DialogueEntryKind::Sent(then)) if *then == bytes => {}
                    // The recording ended in between.
                    None => {}
                    Some(then) => {
                        let now = String::from_utf8_lossy(&bytes);
                        let what = format!("it {}, and sends {now:?} now", in_words(then));
                        return Err(self.differs(input, what));
                    }
                },
            }
        }
        Ok(())
    }

    fn differs(&self, entry: &DialogueEntry, what: String) -> ReplayError {
        ReplayError::OtherDriver {
            device: self.device,
            at_s: entry.at.as_secs_f64() - self.began_at.as_secs_f64(),
            what,
        }
    }
}

/// What a driver did, for messages.
fn in_words(kind: &DialogueEntryKind) -> String {
    match kind {
        DialogueEntryKind::Received(bytes) => {
            format!("received {:?}", String::from_utf8_lossy(bytes))
        }
        DialogueEntryKind::Sent(bytes) => format!("sent {:?}", String::from_utf8_lossy(bytes)),
        DialogueEntryKind::DriverDeadline => "met a time limit".to_owned(),
        _ => "took a command".to_owned(),
    }
}
