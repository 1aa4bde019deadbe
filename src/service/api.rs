//! HTTP API on the control socket: POST /visit, /teach, /sweep, /reload; GET /status.

use super::constants::MAX_WAYPOINT_NAME_BYTES;
use super::message::{ClientRequest, ServiceMessage, TeachOptions};
use super::replies::{ErrorReply, ServiceReply, StatusReply};
use crate::patrol::event::{PatrolTask, RefusalReason};
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

/// Header of a `/sweep` answer with its [`SweepInfo`](super::replies::SweepInfo) as JSON; the body is the PLY.
pub const SWEEP_INFO_HEADER: HeaderName = HeaderName::from_static("x-patrold-sweep");

#[derive(Clone)]
struct ApiState {
    inbox: UnboundedSender<ServiceMessage>,
    status: watch::Receiver<StatusReply>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WaypointRequest {
    waypoint: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TeachRequest {
    waypoint: String,
    #[serde(default)]
    accept: Vec<i64>,
    #[serde(default)]
    new: bool,
}

/// User id and process id of the client, from the socket's peer credentials.
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

/// Serves `listener` until `stop` is sent or dropped, then finishes the requests under way.
pub(super) async fn serve(
    listener: UnixListener,
    inbox: UnboundedSender<ServiceMessage>,
    status: watch::Receiver<StatusReply>,
    stop: oneshot::Receiver<()>,
) {
    let routes = Router::new()
        .route("/visit", post(visit))
        .route("/teach", post(teach))
        .route("/sweep", post(sweep))
        .route("/reload", post(reload))
        .route("/status", get(get_status))
        .fallback(unknown_path)
        .method_not_allowed_fallback(wrong_method)
        .with_state(ApiState { inbox, status });
    let service = routes.into_make_service_with_connect_info::<Peer>();
    let stopped = async {
        let _ = stop.await;
    };
    let served = axum::serve(listener, service).with_graceful_shutdown(stopped);
    if let Err(error) = served.await {
        tracing::error!("control socket failed: {error}");
    }
}

async fn visit(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    request: Result<Json<WaypointRequest>, JsonRejection>,
) -> Response {
    let request = request.map(|Json(r)| (r.waypoint, TeachOptions::default()));
    submit_at_waypoint(&state, &peer, PatrolTask::Visit, request).await
}

async fn teach(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    request: Result<Json<TeachRequest>, JsonRejection>,
) -> Response {
    let request = request.map(|Json(r)| {
        let (accept, new_name) = (r.accept, r.new);
        (r.waypoint, TeachOptions { accept, new_name })
    });
    submit_at_waypoint(&state, &peer, PatrolTask::Teach, request).await
}

async fn sweep(State(state): State<ApiState>, ConnectInfo(peer): ConnectInfo<Peer>) -> Response {
    let no_options = TeachOptions::default();
    submit(&state, &peer, PatrolTask::Sweep, String::new(), no_options).await
}

/// Answers when the files are in force, or refused.
async fn reload(State(state): State<ApiState>, ConnectInfo(peer): ConnectInfo<Peer>) -> Response {
    tracing::info!("reload requested by {peer}");
    let (client, reply) = oneshot::channel();
    let sent = state.inbox.send(ServiceMessage::ReloadRequested(client));
    match (sent, reply.await) {
        (Ok(()), Ok(reply)) => Json(reply).into_response(),
        // The sender is dropped without a reply when the service ends.
        _ => respond(ServiceReply::Refused(RefusalReason::Stopping)),
    }
}

async fn get_status(State(state): State<ApiState>) -> Response {
    let status = state.status.borrow().clone();
    Json(status).into_response()
}

async fn unknown_path() -> Response {
    let paths = "POST /visit, /teach, /sweep, /reload; GET /status";
    error(
        StatusCode::NOT_FOUND,
        format!("no such path; there are {paths}"),
    )
}

async fn wrong_method() -> Response {
    let text = "wrong method: POST /visit, /teach, /sweep, /reload; GET /status";
    error(StatusCode::METHOD_NOT_ALLOWED, text.to_owned())
}

async fn submit_at_waypoint(
    state: &ApiState,
    peer: &Peer,
    task: PatrolTask,
    request: Result<(String, TeachOptions), JsonRejection>,
) -> Response {
    let (waypoint, teach) = match request {
        Ok(request) => request,
        Err(rejection) => {
            let text = rejection.body_text();
            return error(rejection.status(), text.replace('\n', " "));
        }
    };
    match waypoint_name_error(&waypoint) {
        Some(text) => error(StatusCode::BAD_REQUEST, text),
        None => submit(state, peer, task, waypoint, teach).await,
    }
}

async fn submit(
    state: &ApiState,
    peer: &Peer,
    task: PatrolTask,
    waypoint: String,
    teach: TeachOptions,
) -> Response {
    tracing::info!(WAYPOINT = %waypoint, "{} {waypoint} requested by {peer}", task.as_str());
    let (reply_to, reply) = oneshot::channel();
    let request = ClientRequest {
        task,
        waypoint,
        teach,
        reply_to,
    };
    if state.inbox.send(ServiceMessage::Request(request)).is_err() {
        return respond(ServiceReply::Refused(RefusalReason::Stopping));
    }
    // The sender is dropped without a reply when the service ends.
    respond(
        reply
            .await
            .unwrap_or(ServiceReply::Refused(RefusalReason::Stopping)),
    )
}

fn respond(reply: ServiceReply) -> Response {
    match reply {
        ServiceReply::Visit(visit) => Json(visit).into_response(),
        ServiceReply::Teach(teach) => Json(teach).into_response(),
        ServiceReply::Sweep(sweep) => {
            let info = serde_json::to_string(&sweep.info).unwrap_or_default();
            let headers = [
                (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
                (SWEEP_INFO_HEADER, info),
            ];
            (headers, sweep.ply).into_response()
        }
        ServiceReply::Refused(refusal) => {
            let code = match &refusal {
                RefusalReason::UnknownWaypoint(_) => StatusCode::NOT_FOUND,
                RefusalReason::NoReference(_) | RefusalReason::Undecided(_) => StatusCode::CONFLICT,
                RefusalReason::BadSweep(_) => StatusCode::UNPROCESSABLE_ENTITY,
                RefusalReason::Busy | RefusalReason::Stopping | RefusalReason::NoSweep(_) => {
                    StatusCode::SERVICE_UNAVAILABLE
                }
                RefusalReason::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
            };
            error(code, refusal.to_string())
        }
    }
}

fn error(code: StatusCode, error: String) -> Response {
    (code, Json(ErrorReply { error })).into_response()
}

/// A name must fit into the configuration's `[waypoint.NAME]`, a shell and a log line.
fn waypoint_name_error(name: &str) -> Option<String> {
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let valid =
        !name.is_empty() && name.len() <= MAX_WAYPOINT_NAME_BYTES && name.chars().all(allowed);
    (!valid).then(|| {
        format!("a waypoint's name is 1 to {MAX_WAYPOINT_NAME_BYTES} letters, digits, '-', '_' or '.', got {name:?}")
    })
}

#[cfg(test)]
mod tests {
    use super::waypoint_name_error;

    #[test]
    fn waypoint_names_are_checked() {
        for valid in ["hall", "hall-2", "küche", "a.b_c"] {
            assert_eq!(waypoint_name_error(valid), None, "{valid}");
        }
        for invalid in ["", "two words", "a/b", "a\nb", &"x".repeat(65)] {
            assert!(waypoint_name_error(invalid).is_some(), "{invalid:?}");
        }
    }
}
