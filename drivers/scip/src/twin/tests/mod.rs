//! The whole twin, as a host on the other end of the line would meet it.

mod bench;
mod clients;
mod faults;
mod golden;
mod hostile;
mod models;
mod statuses;
mod streams;
mod time;

use std::time::Duration;

use super::{Link, Output, Profile, StartState, TwinOptions};
use bench::{Bench, MS, decode, exact, joined, messages, stamps};
