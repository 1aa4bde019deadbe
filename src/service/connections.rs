//! The connections of the control socket, accepted as long as the service runs.

use super::connection::serve_connection;
use super::connection_slots::Slots;
use super::constants::ACCEPT_RETRY_PAUSE;
use axum::Router;
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::{oneshot, watch};
use tokio::task::JoinSet;
use tokio::time::sleep;

/// Serves `listener` until `stop` is sent or dropped, then finishes the requests under way.
///
/// A client is never kept waiting by others that send nothing: where there are too many connections, the one that has had
/// no whole request for the longest time is closed.
pub(super) async fn serve_connections(
    listener: UnixListener,
    routes: Router,
    stop: oneshot::Receiver<()>,
) {
    let (stopping, stopped) = watch::channel(false);
    let slots = Slots::default();
    let mut tasks = JoinSet::new();
    let accepting = async {
        loop {
            let stream = accept(&listener).await;
            while tasks.try_join_next().is_some() {}
            slots.make_room().await;
            let slot = slots.take();
            let number = slot.number();
            let task = serve_connection(stream, routes.clone(), slot, stopped.clone());
            slots.set_task(number, tasks.spawn(task));
        }
    };
    tokio::select! {
        () = accepting => {}
        _ = stop => {}
    }
    drop(listener);
    stopping.send_replace(true);
    while tasks.join_next().await.is_some() {}
}

async fn accept(listener: &UnixListener) -> UnixStream {
    loop {
        match listener.accept().await {
            Ok((stream, _)) => return stream,
            Err(error) => {
                tracing::warn!("control socket: {error}; trying again");
                sleep(ACCEPT_RETRY_PAUSE).await;
            }
        }
    }
}
