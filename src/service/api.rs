//! HTTP API on the control socket: POST /visit, /teach, /sweep, /reload, and those of `store_api`; GET /status; what became
//! of requests whose clients do not wait.

use super::api_body::{JsonObject, NoBody};
use super::api_reply::{error, respond};
use super::api_state::{ApiState, Peer};
use super::connections::serve_connections;
use super::message::{CancelResult, ClientRequest, ReplyTo, ServiceMessage, TeachOptions};
use super::replies::{RefusalReply, RequestReply, ServiceReply, StatusReply};
use super::store_api::{accept, acknowledge, restore};
use crate::patrol::event::{PatrolTask, RefusalReason};
use crate::patrol::name::waypoint_name_error;
use axum::extract::connect_info::ConnectInfo;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
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
    #[serde(default = "waits")]
    wait: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TeachRequest {
    waypoint: String,
    #[serde(default)]
    accept: Vec<i64>,
    #[serde(default)]
    new: bool,
    #[serde(default = "waits")]
    wait: bool,
}

fn waits() -> bool {
    true
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
        .route("/accept", post(accept))
        .route("/restore", post(restore))
        .route("/status", get(get_status))
        .route("/requests/{id}", get(request_state).delete(cancel_request))
        .fallback(unknown_path)
        .method_not_allowed_fallback(wrong_method)
        .with_state(ApiState { inbox, status });
    serve_connections(listener, routes, stop).await;
}

async fn visit(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    JsonObject(body): JsonObject<WaypointRequest>,
) -> Response {
    let teach = TeachOptions::default();
    submit_at_waypoint(
        &state,
        &peer,
        PatrolTask::Visit,
        body.waypoint,
        teach,
        body.wait,
    )
    .await
}

async fn teach(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    JsonObject(body): JsonObject<TeachRequest>,
) -> Response {
    let (accept, new_name) = (body.accept, body.new);
    let teach = TeachOptions { accept, new_name };
    submit_at_waypoint(
        &state,
        &peer,
        PatrolTask::Teach,
        body.waypoint,
        teach,
        body.wait,
    )
    .await
}

async fn sweep(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    NoBody: NoBody,
) -> Response {
    let no_options = TeachOptions::default();
    submit(
        &state,
        &peer,
        PatrolTask::Sweep,
        String::new(),
        no_options,
        true,
    )
    .await
}

/// Answers when the files are in force, or refused.
async fn reload(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    NoBody: NoBody,
) -> Response {
    tracing::info!("reload requested by {peer}");
    let (client, reply) = oneshot::channel();
    let sent = state.inbox.send(ServiceMessage::ReloadRequested(client));
    match (sent, reply.await) {
        (Ok(()), Ok(reply)) => Json(reply).into_response(),
        _ => stopping(),
    }
}

async fn get_status(State(state): State<ApiState>) -> Response {
    let status = state.status.borrow().clone();
    Json(status).into_response()
}

async fn request_state(State(state): State<ApiState>, Path(id): Path<String>) -> Response {
    let (client, reply) = oneshot::channel();
    let message = ServiceMessage::RequestState(id.clone(), client);
    match (state.inbox.send(message), reply.await) {
        (Ok(()), Ok(Some(reply))) => Json(reply).into_response(),
        (Ok(()), Ok(None)) => unknown_request(&id),
        _ => stopping(),
    }
}

async fn cancel_request(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    Path(id): Path<String>,
) -> Response {
    tracing::info!("end of request {id:?} requested by {peer}");
    let (client, reply) = oneshot::channel();
    let message = ServiceMessage::CancelRequest(id.clone(), client);
    match (state.inbox.send(message), reply.await) {
        (Ok(()), Ok(CancelResult::Cancelled(reply))) => Json(reply).into_response(),
        (Ok(()), Ok(CancelResult::TooLate(now))) => error(
            StatusCode::CONFLICT,
            format!("too late to cancel: {now}; GET /requests/{id} has the outcome"),
        ),
        (Ok(()), Ok(CancelResult::Unknown)) => unknown_request(&id),
        _ => stopping(),
    }
}

fn unknown_request(id: &str) -> Response {
    error(
        StatusCode::NOT_FOUND,
        format!(
            "no request {id:?}, or finished long ago, or before a start of the service; `patrold visits` has its outcome"
        ),
    )
}

const PATHS: &str = "POST /visit, /teach, /sweep, /reload, /ack, /accept, /restore; GET /status, /requests/ID; DELETE /requests/ID";

async fn unknown_path() -> Response {
    error(
        StatusCode::NOT_FOUND,
        format!("no such path; there are {PATHS}"),
    )
}

async fn wrong_method() -> Response {
    error(
        StatusCode::METHOD_NOT_ALLOWED,
        format!("wrong method; there are {PATHS}"),
    )
}

async fn submit_at_waypoint(
    state: &ApiState,
    peer: &Peer,
    task: PatrolTask,
    waypoint: String,
    teach: TeachOptions,
    wait: bool,
) -> Response {
    match waypoint_name_error(&waypoint) {
        Some(text) => error(StatusCode::BAD_REQUEST, text),
        None => submit(state, peer, task, waypoint, teach, wait).await,
    }
}

/// Answers with the outcome, or where the client does not wait at once, with how to ask for it.
async fn submit(
    state: &ApiState,
    peer: &Peer,
    task: PatrolTask,
    waypoint: String,
    teach: TeachOptions,
    wait: bool,
) -> Response {
    tracing::info!(WAYPOINT = %waypoint, "{} {waypoint} requested by {peer}", task.as_str());
    let send = |reply_to| {
        let request = ClientRequest {
            task,
            waypoint,
            teach,
            reply_to,
        };
        state.inbox.send(ServiceMessage::Request(request)).is_ok()
    };
    if wait {
        let (client, reply) = oneshot::channel();
        return match (send(ReplyTo::Client(client)), reply.await) {
            (true, Ok(reply)) => respond(reply),
            _ => stopping(),
        };
    }
    let (client, reply) = oneshot::channel();
    match (send(ReplyTo::Later(client)), reply.await) {
        (true, Ok(reply)) => accepted(&reply),
        _ => stopping(),
    }
}

/// What cannot be done at all is refused as to a client that waits.
fn accepted(reply: &RequestReply) -> Response {
    if let Some(RefusalReply { status, reply }) = &reply.refusal {
        let status = StatusCode::from_u16(*status).unwrap_or(StatusCode::SERVICE_UNAVAILABLE);
        return (status, Json(reply)).into_response();
    }
    let place = [(header::LOCATION, format!("/requests/{}", reply.id))];
    (StatusCode::ACCEPTED, place, Json(reply)).into_response()
}

/// The service drops whom it owes a reply when it ends.
fn stopping() -> Response {
    respond(ServiceReply::Refused(RefusalReason::Stopping))
}
