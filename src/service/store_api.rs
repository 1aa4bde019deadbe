//! Requests that are about the store alone: POST /ack, POST /accept, POST /restore.

use super::api_body::JsonObject;
use super::api_reply::{error, respond};
use super::api_state::{ApiState, Peer};
use super::message::{AcceptRequest, AckRequest, ServiceMessage};
use super::operator::operator;
use super::replies::ServiceReply;
use crate::alarm::AlarmAnswer;
use crate::patrol::event::RefusalReason;
use crate::store::StoreError;
use axum::Json;
use axum::extract::State;
use axum::extract::connect_info::ConnectInfo;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use std::path::PathBuf;
use tokio::sync::oneshot;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AckBody {
    id: i64,
    #[serde(default)]
    by: Option<String>,
    #[serde(default)]
    note: Option<String>,
    #[serde(default)]
    answer: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AcceptBody {
    id: i64,
    #[serde(default)]
    by: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RestoreBody {
    dir: PathBuf,
}

fn stopping() -> Response {
    respond(ServiceReply::Refused(RefusalReason::Stopping))
}

fn store_error(why: &StoreError) -> Response {
    let code = match why {
        StoreError::UnknownAlarm(_) => StatusCode::NOT_FOUND,
        StoreError::NotAcceptable { .. } => StatusCode::CONFLICT,
        _ => StatusCode::INTERNAL_SERVER_ERROR,
    };
    error(code, why.to_string())
}

/// The user that the socket saw, and in front of it the name that was given.
fn signed(given: Option<String>, peer: &Peer) -> String {
    match peer.uid() {
        Some(uid) => operator(given.as_deref(), uid),
        None => given.unwrap_or_else(|| peer.to_string()),
    }
}

/// Answers when it is on disk.
pub(super) async fn acknowledge(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    JsonObject(body): JsonObject<AckBody>,
) -> Response {
    let answer = body.answer.as_deref().map(AlarmAnswer::from_text);
    if answer == Some(None) {
        let text = "answer: expected \"confirmed\" or \"false_alarm\"";
        return error(StatusCode::BAD_REQUEST, text.to_owned());
    }
    let request = AckRequest {
        id: body.id,
        by: signed(body.by, &peer),
        note: body.note,
        answer: answer.flatten(),
    };
    let (reply_to, reply) = oneshot::channel();
    let message = ServiceMessage::Acknowledge(request, reply_to);
    match (state.inbox.send(message), reply.await) {
        (Ok(()), Ok(Ok(reply))) => Json(reply).into_response(),
        (Ok(()), Ok(Err(why))) => store_error(&why),
        // The sender is dropped without a reply when the service ends.
        _ => stopping(),
    }
}

/// Answers when the new reference is on disk.
pub(super) async fn accept(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    JsonObject(body): JsonObject<AcceptBody>,
) -> Response {
    let request = AcceptRequest {
        id: body.id,
        by: signed(body.by, &peer),
    };
    let (reply_to, reply) = oneshot::channel();
    let message = ServiceMessage::Accept(request, reply_to);
    match (state.inbox.send(message), reply.await) {
        (Ok(()), Ok(Ok(reply))) => Json(reply).into_response(),
        (Ok(()), Ok(Err(why))) => store_error(&why),
        _ => stopping(),
    }
}

/// Answers when the store is the backup, or as it was.
pub(super) async fn restore(
    State(state): State<ApiState>,
    ConnectInfo(peer): ConnectInfo<Peer>,
    JsonObject(RestoreBody { dir }): JsonObject<RestoreBody>,
) -> Response {
    if !dir.is_absolute() {
        let text = format!("dir: expected an absolute path, got {}", dir.display());
        return error(StatusCode::BAD_REQUEST, text);
    }
    tracing::info!("restore from {} requested by {peer}", dir.display());
    let (reply_to, reply) = oneshot::channel();
    let message = ServiceMessage::Restore(dir, reply_to);
    match (state.inbox.send(message), reply.await) {
        (Ok(()), Ok(Ok(result))) => Json(result).into_response(),
        (Ok(()), Ok(Err(why))) => error(StatusCode::INTERNAL_SERVER_ERROR, why),
        _ => stopping(),
    }
}
