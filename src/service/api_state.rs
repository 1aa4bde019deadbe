//! What the handlers of the control socket share, and who asks them.

use super::message::ServiceMessage;
use super::replies::StatusReply;
use tokio::net::UnixStream;
use tokio::sync::mpsc::UnboundedSender;
use tokio::sync::watch;

#[derive(Clone)]
pub(super) struct ApiState {
    pub(super) inbox: UnboundedSender<ServiceMessage>,
    pub(super) status: watch::Receiver<StatusReply>,
}

/// User id and process id of the client, from the socket's peer credentials.
#[derive(Debug, Clone, Default)]
pub(super) struct Peer(Option<(u32, Option<i32>)>);

impl Peer {
    pub(super) fn of(stream: &UnixStream) -> Self {
        let credentials = stream.peer_cred().ok();
        Self(credentials.map(|c| (c.uid(), c.pid())))
    }

    pub(super) fn uid(&self) -> Option<u32> {
        self.0.map(|(uid, _)| uid)
    }
}

impl std::fmt::Display for Peer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some((uid, Some(pid))) => write!(f, "uid {uid}, pid {pid}"),
            Some((uid, None)) => write!(f, "uid {uid}"),
            None => f.write_str("an unknown peer"),
        }
    }
}
