//! Client of the service: HTTP over its Unix socket.

use super::failure::Failure;
use super::progress::Work;
use crate::service::SWEEP_INFO_HEADER;
use crate::service::replies::{
    AcceptReply, AckReply, ErrorReply, ReloadReply, StatusReply, SweepInfo, TeachReply,
    WorkProgress,
};
use crate::store::{BackupResult, access_remedy};
use http_body_util::{BodyExt as _, Full};
use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HOST};
use hyper::{HeaderMap, Method, Request, StatusCode};
use hyper_util::rt::TokioIo;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;
use tokio::net::UnixStream;

enum ClientError {
    /// Nothing listens at the socket.
    NoService(String),
    /// The service asks whether a name is new: its reason, and the known name.
    NearName(String, String),
    Failed(String),
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        match error {
            ClientError::NoService(text)
            | ClientError::NearName(text, _)
            | ClientError::Failed(text) => Self::Failed(text),
        }
    }
}

/// Requests `/visit` and waits for the reply; `options` go into the body beside the name. Progress is shown under `title`.
///
/// # Errors
/// No service, no permission for its socket, or its error reply.
pub(super) fn request_at_waypoint<T: DeserializeOwned>(
    socket: &Path,
    path: &'static str,
    waypoint: &str,
    options: Value,
    title: &str,
) -> Result<T, Failure> {
    Ok(at_waypoint(socket, path, waypoint, options, title)?)
}

fn at_waypoint<T: DeserializeOwned>(
    socket: &Path,
    path: &'static str,
    waypoint: &str,
    options: Value,
    title: &str,
) -> Result<T, ClientError> {
    let mut body = options;
    body["waypoint"] = json!(waypoint);
    let (_, body) = post_and_watch(socket, path, Some(body), title)?;
    serde_json::from_slice(&body)
        .map_err(|error| ClientError::Failed(format!("{}: {path}: {error}", socket.display())))
}

/// Requests `/teach`; `Err` with the known name where the new one is nearly that, and nobody said that it is new.
///
/// # Errors
/// As [`request_at_waypoint`]; off a terminal also that the name is nearly a known one.
pub(super) fn request_teach(
    socket: &Path,
    waypoint: &str,
    accept: &[i64],
    new: bool,
    may_ask: bool,
) -> Result<Result<TeachReply, String>, Failure> {
    let options = json!({"accept": accept, "new": new});
    match at_waypoint(socket, "/teach", waypoint, options, waypoint) {
        Err(ClientError::NearName(_, known)) if may_ask => Ok(Err(known)),
        other => Ok(Ok(other?)),
    }
}

/// Requests a sweep; `None` where no service runs. The bytes are a PLY file.
///
/// # Errors
/// No permission for the socket, or the error reply of the service.
pub(super) fn request_sweep(socket: &Path) -> Result<Option<(SweepInfo, Vec<u8>)>, Failure> {
    let (headers, body) = match post_and_watch(socket, "/sweep", None, "sweep") {
        Err(ClientError::NoService(_)) => return Ok(None),
        other => other?,
    };
    let info = headers
        .get(SWEEP_INFO_HEADER)
        .map_or(&b""[..], |v| v.as_bytes());
    let info = serde_json::from_slice(info)
        .map_err(|error| Failure::Failed(format!("{}: /sweep: {error}", socket.display())))?;
    Ok(Some((info, body)))
}

/// Between two looks at the status of work that takes long.
const WATCH_INTERVAL: Duration = Duration::from_millis(250);

/// A service that is well answers its status at once.
const STATUS_LIMIT: Duration = Duration::from_secs(5);

/// Why there is no status.
#[derive(Debug)]
pub(super) struct NoStatus {
    /// Nothing listens at the socket; else a service may run.
    pub(super) is_down: bool,
    pub(super) why: String,
}

/// Asks for the status; `Err` with the reason where no service answers in time.
///
/// # Errors
/// An answer that is none of the service's.
pub(super) fn request_status(socket: &Path) -> Result<Result<StatusReply, NoStatus>, Failure> {
    request_status_within(socket, STATUS_LIMIT)
}

fn request_status_within(
    socket: &Path,
    limit: Duration,
) -> Result<Result<StatusReply, NoStatus>, Failure> {
    let no_status = |is_down, why| Ok(Err(NoStatus { is_down, why }));
    let body = match exchange(socket, Method::GET, "/status", None, Some(limit)) {
        Err(ClientError::NoService(why)) => return no_status(true, why),
        Err(ClientError::NearName(why, _) | ClientError::Failed(why)) => {
            return no_status(false, why);
        }
        Ok((_, body)) => body,
    };
    serde_json::from_slice(&body)
        .map(Ok)
        .map_err(|error| Failure::Failed(format!("{}: /status: {error}", socket.display())))
}

/// Asks for a reload and waits until it is in force or refused.
///
/// # Errors
/// No service, no permission for its socket, or its error reply.
pub(super) fn request_reload(socket: &Path) -> Result<ReloadReply, Failure> {
    let (_, body) = post(socket, "/reload", None)?;
    serde_json::from_slice(&body)
        .map_err(|error| Failure::Failed(format!("{}: /reload: {error}", socket.display())))
}

/// What acknowledging takes at most: the service may be waiting for another program that writes.
const ACK_LIMIT: Duration = Duration::from_secs(60);

/// Acknowledges an alarm; `None` where no service runs.
///
/// # Errors
/// No permission for the socket, or the error reply of the service.
pub(super) fn request_ack(socket: &Path, body: Value) -> Result<Option<AckReply>, Failure> {
    let answer = exchange(socket, Method::POST, "/ack", Some(body), Some(ACK_LIMIT));
    reply_if_running(socket, "/ack", answer)
}

/// Accepts an alarm; `None` where no service runs.
///
/// # Errors
/// No permission for the socket, or the error reply of the service.
pub(super) fn request_accept(
    socket: &Path,
    id: i64,
    body: Value,
) -> Result<Option<AcceptReply>, Failure> {
    let working = Work::start(format!("alarm {id}: the service makes it normal"));
    let answer = post(socket, "/accept", Some(body));
    drop(working);
    reply_if_running(socket, "/accept", answer)
}

/// Restores the store of the service from a backup; `None` where no service runs.
///
/// # Errors
/// No permission for the socket, or the error reply of the service.
pub(super) fn request_restore(socket: &Path, from: &Path) -> Result<Option<BackupResult>, Failure> {
    let answer = post_and_watch(socket, "/restore", Some(json!({"dir": from})), "restoring");
    reply_if_running(socket, "/restore", answer)
}

fn reply_if_running<T: DeserializeOwned>(
    socket: &Path,
    path: &str,
    answer: Result<(HeaderMap, Vec<u8>), ClientError>,
) -> Result<Option<T>, Failure> {
    let (_, body) = match answer {
        Err(ClientError::NoService(_)) => return Ok(None),
        answer => answer?,
    };
    serde_json::from_slice(&body)
        .map(Some)
        .map_err(|error| Failure::Failed(format!("{}: {path}: {error}", socket.display())))
}

fn post(
    socket: &Path,
    path: &'static str,
    body: Option<Value>,
) -> Result<(HeaderMap, Vec<u8>), ClientError> {
    exchange(socket, Method::POST, path, body, None)
}

/// As [`post`], for work that takes long: what the status says of it meanwhile is shown.
fn post_and_watch(
    socket: &Path,
    path: &'static str,
    body: Option<Value>,
    title: &str,
) -> Result<(HeaderMap, Vec<u8>), ClientError> {
    let work = Work::start(title);
    let watching = async {
        loop {
            tokio::time::sleep(WATCH_INTERVAL).await;
            let Ok((_, body)) = exchange_on(socket, Method::GET, "/status", None).await else {
                continue;
            };
            if let Ok(status) = serde_json::from_slice::<StatusReply>(&body) {
                show_status(&work, &status);
            }
        }
    };
    runtime(socket, path)?.block_on(async {
        tokio::select! {
            answer = exchange_on(socket, Method::POST, path, body) => answer,
            () = watching => Err(ClientError::Failed(format!("{path}: no answer"))),
        }
    })
}

fn show_status(work: &Work, status: &StatusReply) {
    match &status.current {
        Some(current) => {
            let WorkProgress {
                share,
                seconds_left,
            } = current.progress;
            let phase = match status.waiting {
                0 => status.phase.clone(),
                waiting => format!("{}, {waiting} waiting", status.phase),
            };
            work.show(&phase, Some(share), seconds_left);
        }
        None => work.show(&status.phase, None, None),
    }
}

fn exchange(
    socket: &Path,
    method: Method,
    path: &'static str,
    body: Option<Value>,
    limit: Option<Duration>,
) -> Result<(HeaderMap, Vec<u8>), ClientError> {
    let answer = exchange_on(socket, method, path, body);
    runtime(socket, path)?.block_on(async {
        match limit {
            None => answer.await,
            Some(limit) => tokio::time::timeout(limit, answer)
                .await
                .unwrap_or_else(|_| {
                    let text = format!("no answer within {limit:?}; the service hangs");
                    Err(failed(socket, path, &text))
                }),
        }
    })
}

fn runtime(socket: &Path, path: &'static str) -> Result<tokio::runtime::Runtime, ClientError> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| failed(socket, path, &error))
}

fn failed(socket: &Path, path: &str, error: &dyn std::fmt::Display) -> ClientError {
    ClientError::Failed(format!("{}: {path}: {error}", socket.display()))
}

async fn exchange_on(
    socket: &Path,
    method: Method,
    path: &'static str,
    body: Option<Value>,
) -> Result<(HeaderMap, Vec<u8>), ClientError> {
    let failed = |error: &dyn std::fmt::Display| failed(socket, path, error);
    let stream = UnixStream::connect(socket)
        .await
        .map_err(|e| connect_error(socket, &e))?;
    let (mut sender, connection) = hyper::client::conn::http1::handshake(TokioIo::new(stream))
        .await
        .map_err(|e| failed(&e))?;
    let exchange = async {
        let text = body.map_or_else(String::new, |b| b.to_string());
        let request = Request::builder()
            .method(method)
            .uri(path)
            .header(HOST, "patrold")
            .header(CONTENT_TYPE, "application/json")
            .body(Full::new(Bytes::from(text)))
            .map_err(|e| failed(&e))?;
        let response = sender.send_request(request).await.map_err(|e| failed(&e))?;
        let (head, body) = response.into_parts();
        let body = body.collect().await.map_err(|e| failed(&e))?.to_bytes();
        if head.status == StatusCode::OK {
            return Ok((head.headers, body.to_vec()));
        }
        Err(match serde_json::from_slice::<ErrorReply>(&body) {
            Ok(ErrorReply {
                error,
                nearly: Some(known),
            }) => ClientError::NearName(error, known),
            Ok(reply) => ClientError::Failed(reply.error),
            Err(_) => failed(&format!("the service replied {}", head.status)),
        })
    };
    tokio::pin!(exchange);
    tokio::select! {
        response = &mut exchange => response,
        // The connection may end before its response has been read.
        ended = connection => match ended {
            Ok(()) => exchange.await,
            Err(error) => Err(failed(&error)),
        },
    }
}

fn connect_error(socket: &Path, error: &std::io::Error) -> ClientError {
    let at = socket.display();
    match error.kind() {
        ErrorKind::NotFound | ErrorKind::ConnectionRefused => ClientError::NoService(format!(
            "no service at {at}; start it: systemctl start patrold"
        )),
        ErrorKind::PermissionDenied => ClientError::Failed(format!(
            "{at}: this user may not command the robot; {}",
            access_remedy(socket)
        )),
        _ => ClientError::Failed(format!("{at}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::{request_at_waypoint, request_status_within, request_sweep};
    use serde_json::{Value, json};
    use std::os::unix::net::UnixListener;
    use std::time::Duration;

    #[test]
    fn a_service_that_hangs_does_not_hang_its_status() {
        let dir = tempfile::tempdir().expect("temp dir");
        let socket = dir.path().join("p.sock");
        // Connections wait in its queue for ever.
        let _listener = UnixListener::bind(&socket).expect("bound");
        let answer = request_status_within(&socket, Duration::from_millis(1)).expect("no failure");
        let no = answer.expect_err("no answer");
        assert!(
            !no.is_down
                && no
                    .why
                    .ends_with("/status: no answer within 1ms; the service hangs"),
            "{no:?}"
        );
    }

    #[test]
    fn without_a_service_the_error_names_how_to_start_it() {
        let dir = tempfile::tempdir().expect("temp dir");
        let socket = dir.path().join("p.sock");
        let reply = request_at_waypoint::<Value>(&socket, "/visit", "hall", json!({}), "hall");
        let error = reply.expect_err("no service").to_string();
        let at = socket.display();
        assert_eq!(
            error,
            format!("no service at {at}; start it: systemctl start patrold")
        );
        assert!(request_sweep(&socket).expect("no failure").is_none());
    }
}
