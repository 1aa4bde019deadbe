//! What the handlers of the control socket share, and who asks them.

use super::message::ServiceMessage;
use super::replies::StatusReply;
use axum::extract::connect_info::Connected;
use axum::serve::IncomingStream;
use tokio::net::UnixListener;
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
    pub(super) fn uid(&self) -> Option<u32> {
        self.0.map(|(uid, _)| uid)
    }
}

impl Connected<IncomingStream<'_, UnixListener>> for Peer {
    fn connect_info(stream: IncomingStream<'_, UnixListener>) -> Self {
        let credentials = stream.io().peer_cred().ok();
        Self(credentials.map(|c| (c.uid(), c.pid())))
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
