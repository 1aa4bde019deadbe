//! HTTP over the control socket: POST /visit, /teach, /sweep; GET /status.

use super::constants::LONGEST_NAME;
use super::message::{Ask, Message};
use super::replies::{ErrorReply, Reply, StatusReply};
use crate::patrol::event::{Refusal, Task};
use axum::extract::State;
use axum::extract::connect_info::{ConnectInfo, Connected};
use axum::extract::rejection::JsonRejection;
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::serve::IncomingStream;
use axum::{Json, Router};
use serde::Deserialize;
use tokio::net::UnixListener;
use tokio::sync::mpsc::UnboundedSender;
use tokio::sync::{oneshot, watch};

/// Header that carries what goes with the points of a sweep, as JSON.
pub const ABOUT_SWEEP: HeaderName = HeaderName::from_static("x-patrold-sweep");

#[derive(Clone)]
struct Desk {
    inbox: UnboundedSender<Message>,
    status: watch::Receiver<StatusReply>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    waypoint: String,
}

/// Who is at the other end.
#[derive(Debug, Clone, Default)]
struct Peer(Option<(u32, Option<i32>)>);

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

/// Answers at `listener` until `stop` is ready or dropped; requests under way get their answers then.
pub async fn serve(
    listener: UnixListener,
    inbox: UnboundedSender<Message>,
    status: watch::Receiver<StatusReply>,
    stop: oneshot::Receiver<()>,
) {
    let routes = Router::new()
        .route("/visit", post(visit))
        .route("/teach", post(teach))
        .route("/sweep", post(sweep))
        .route("/status", get(tell_status))
        .fallback(unknown_path)
        .method_not_allowed_fallback(wrong_method)
        .with_state(Desk { inbox, status });
    let service = routes.into_make_service_with_connect_info::<Peer>();
    let stopped = async {
        // Told or dropped, it is the end.
        let _ = stop.await;
    };
    let served = axum::serve(listener, service).with_graceful_shutdown(stopped);
    if let Err(error) = served.await {
        tracing::error!("the control socket answers no more: {error}");
    }
}

async fn visit(
    State(desk): State<Desk>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    place: Result<Json<Place>, JsonRejection>,
) -> Response {
    ask_about(&desk, &peer, Task::Visit, place).await
}

async fn teach(
    State(desk): State<Desk>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    place: Result<Json<Place>, JsonRejection>,
) -> Response {
    ask_about(&desk, &peer, Task::Teach, place).await
}

async fn sweep(State(desk): State<Desk>, ConnectInfo(peer): ConnectInfo<Peer>) -> Response {
    ask(&desk, &peer, Task::Sweep, String::new()).await
}

async fn tell_status(State(desk): State<Desk>) -> Response {
    let status = desk.status.borrow().clone();
    Json(status).into_response()
}

async fn unknown_path() -> Response {
    let paths = "POST /visit, /teach, /sweep; GET /status";
    error(
        StatusCode::NOT_FOUND,
        format!("no such path; there are {paths}"),
    )
}

async fn wrong_method() -> Response {
    let text = "wrong method: POST /visit, /teach, /sweep; GET /status";
    error(StatusCode::METHOD_NOT_ALLOWED, text.to_owned())
}

async fn ask_about(
    desk: &Desk,
    peer: &Peer,
    task: Task,
    place: Result<Json<Place>, JsonRejection>,
) -> Response {
    let waypoint = match place {
        Ok(Json(place)) => place.waypoint,
        Err(rejection) => {
            let text = rejection.body_text();
            return error(rejection.status(), text.replace('\n', " "));
        }
    };
    match fault_of_name(&waypoint) {
        Some(fault) => error(StatusCode::BAD_REQUEST, fault),
        None => ask(desk, peer, task, waypoint).await,
    }
}

async fn ask(desk: &Desk, peer: &Peer, task: Task, waypoint: String) -> Response {
    tracing::info!(WAYPOINT = %waypoint, "{} {waypoint} asked by {peer}", task.word());
    let (answer, outcome) = oneshot::channel();
    let ask = Ask {
        task,
        waypoint,
        answer,
    };
    if desk.inbox.send(Message::Ask(ask)).is_err() {
        return respond(Reply::Refused(Refusal::Stopping));
    }
    // Dropped unanswered: the service ended.
    respond(outcome.await.unwrap_or(Reply::Refused(Refusal::Stopping)))
}

fn respond(reply: Reply) -> Response {
    match reply {
        Reply::Visit(visit) => Json(visit).into_response(),
        Reply::Teach(teach) => Json(teach).into_response(),
        Reply::Sweep(sweep) => {
            let about = serde_json::to_string(&sweep.about).unwrap_or_default();
            let headers = [
                (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
                (ABOUT_SWEEP, about),
            ];
            (headers, sweep.ply).into_response()
        }
        Reply::Refused(refusal) => {
            let code = match &refusal {
                Refusal::UnknownWaypoint(_) => StatusCode::NOT_FOUND,
                Refusal::NoReference(_) => StatusCode::CONFLICT,
                Refusal::BadSweep(_) => StatusCode::UNPROCESSABLE_ENTITY,
                Refusal::Busy | Refusal::Stopping | Refusal::NoSweep(_) => {
                    StatusCode::SERVICE_UNAVAILABLE
                }
                Refusal::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
            };
            error(code, refusal.to_string())
        }
    }
}

fn error(code: StatusCode, error: String) -> Response {
    (code, Json(ErrorReply { error })).into_response()
}

/// A name must fit into the configuration's `[waypoint.NAME]`, a shell and a log line.
fn fault_of_name(name: &str) -> Option<String> {
    let fits = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let good = !name.is_empty() && name.len() <= LONGEST_NAME && name.chars().all(fits);
    (!good).then(|| {
        format!("a waypoint's name is 1 to {LONGEST_NAME} letters, digits, '-', '_' or '.', got {name:?}")
    })
}

#[cfg(test)]
mod tests {
    use super::fault_of_name;

    #[test]
    fn names_are_plain_words() {
        for good in ["hall", "hall-2", "küche", "a.b_c"] {
            assert_eq!(fault_of_name(good), None, "{good}");
        }
        for bad in ["", "two words", "a/b", "a\nb", &"x".repeat(65)] {
            assert!(fault_of_name(bad).is_some(), "{bad:?}");
        }
    }
}
