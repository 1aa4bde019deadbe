//! HTTP API on the control socket: POST /visit, /teach, /sweep, /reload, and those of `store_api`; GET /status.

use super::api_reply::{error, respond};
use super::api_state::{ApiState, Peer};
use super::constants::MAX_WAYPOINT_NAME_BYTES;
use super::message::{ClientRequest, ServiceMessage, TeachOptions};
use super::replies::{ServiceReply, StatusReply};
use super::store_api::{acknowledge, restore};
use crate::patrol::event::{PatrolTask, RefusalReason};
use axum::extract::State;
use axum::extract::connect_info::ConnectInfo;
use axum::extract::rejection::JsonRejection;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use tokio::net::UnixListener;
use tokio::sync::mpsc::UnboundedSender;
use tokio::sync::{oneshot, watch};

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
        .route("/ack", post(acknowledge))
        .route("/restore", post(restore))
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
    let paths = "POST /visit, /teach, /sweep, /reload, /ack, /restore; GET /status";
    error(
        StatusCode::NOT_FOUND,
        format!("no such path; there are {paths}"),
    )
}

async fn wrong_method() -> Response {
    let text = "wrong method: POST /visit, /teach, /sweep, /reload, /ack, /restore; GET /status";
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
