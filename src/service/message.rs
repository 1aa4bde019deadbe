//! Everything that reaches the loop from elsewhere.

use super::judge::Judged;
use super::replies::Reply;
use super::robot_thread::RobotEvent;
use crate::config::{Loaded, Mistake};
use crate::patrol::event::{Refusal, Task};
use crate::store::{Level, StoredReference};
use tokio::sync::oneshot;

/// A request as it comes from the socket.
#[derive(Debug)]
pub struct Ask {
    /// What is asked.
    pub task: Task,
    /// At which waypoint; empty for a bare sweep.
    pub waypoint: String,
    /// Where the outcome goes.
    pub answer: oneshot::Sender<Reply>,
}

/// What reaches the loop.
#[derive(Debug)]
pub enum Message {
    /// From the robot's thread.
    Robot(RobotEvent),
    /// From the socket.
    Ask(Ask),
    /// The waypoint's reference was looked up.
    Prepared(u64, Result<StoredReference, Refusal>),
    /// The sweep was judged.
    Judged(u64, Judged),
    /// The outcome is on disk.
    Recorded(u64, Result<Reply, Refusal>),
    /// The configuration was read again.
    Reread(Result<Box<Loaded>, Vec<Mistake>>),
    /// Something worth noting: how bad, which device, what.
    Note(Level, String, String),
}

/// What the world outside asks of the service as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Read the configuration again.
    Reload,
    /// End.
    Stop,
}
