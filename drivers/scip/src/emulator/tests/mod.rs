//! The whole emulator, as a host at the other end of the line sees it.

mod clients;
mod faults;
mod golden;
mod hostile;
mod models;
mod rig;
mod statuses;
mod streams;
mod time;

use std::time::Duration;

use super::{LaserLink, LaserOptions, LaserOutput, LaserProfile, LaserStartState};
use rig::{LaserRig, MS, decode, exact, joined, messages, stamps};
