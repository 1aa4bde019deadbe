//! The service's client: HTTP over its Unix socket.

use super::failure::Failure;
use super::progress;
use crate::service::ABOUT_SWEEP;
use crate::service::replies::{ErrorReply, SweepAbout};
use http_body_util::{BodyExt as _, Full};
use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HOST};
use hyper::{HeaderMap, Method, Request, StatusCode};
use hyper_util::rt::TokioIo;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::io::ErrorKind;
use std::path::Path;
use tokio::net::UnixStream;

/// Why the service did not answer.
enum AskError {
    /// Nobody listens at the socket.
    NoService(String),
    /// Anything else.
    Failed(String),
}

impl From<AskError> for Failure {
    fn from(error: AskError) -> Self {
        match error {
            AskError::NoService(text) | AskError::Failed(text) => Self::Failed(text),
        }
    }
}

/// Asks the service to do something at a waypoint (`/visit`, `/teach`) and waits for the outcome.
///
/// # Errors
/// No service, a socket this user may not use, or the service's own refusal.
pub fn ask_at<T: DeserializeOwned>(
    socket: &Path,
    path: &'static str,
    waypoint: &str,
) -> Result<T, Failure> {
    let working = progress::spinner(format!("{waypoint}: sweeping and judging"));
    let answer = ask(socket, path, Some(json!({"waypoint": waypoint})));
    working.finish_and_clear();
    let (_, body) = answer?;
    serde_json::from_slice(&body)
        .map_err(|error| Failure::Failed(format!("{}: {path}: {error}", socket.display())))
}

/// Asks the service for a sweep; `None` where no service runs.
///
/// # Errors
/// A socket this user may not use, or the service's own refusal.
pub fn sweep(socket: &Path) -> Result<Option<(SweepAbout, Vec<u8>)>, Failure> {
    let working = progress::spinner("sweeping".to_owned());
    let answer = ask(socket, "/sweep", None);
    working.finish_and_clear();
    let (headers, body) = match answer {
        Err(AskError::NoService(_)) => return Ok(None),
        other => other?,
    };
    let about = headers.get(ABOUT_SWEEP).map_or(&b""[..], |v| v.as_bytes());
    let about = serde_json::from_slice(about)
        .map_err(|error| Failure::Failed(format!("{}: /sweep: {error}", socket.display())))?;
    Ok(Some((about, body)))
}

fn ask(
    socket: &Path,
    path: &'static str,
    body: Option<Value>,
) -> Result<(HeaderMap, Vec<u8>), AskError> {
    let failed = |error: &dyn std::fmt::Display| {
        AskError::Failed(format!("{}: {path}: {error}", socket.display()))
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|e| failed(&e))?;
    runtime.block_on(async {
        let stream = UnixStream::connect(socket)
            .await
            .map_err(|e| no_connection(socket, &e))?;
        let (mut sender, connection) = hyper::client::conn::http1::handshake(TokioIo::new(stream))
            .await
            .map_err(|e| failed(&e))?;
        let answer = async {
            let text = body.map_or_else(String::new, |b| b.to_string());
            let request = Request::builder()
                .method(Method::POST)
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
            let refusal = serde_json::from_slice::<ErrorReply>(&body);
            Err(match refusal {
                Ok(refusal) => AskError::Failed(refusal.error),
                Err(_) => failed(&format!("the service answered {}", head.status)),
            })
        };
        tokio::pin!(answer);
        tokio::select! {
            answer = &mut answer => answer,
            // The connection may end a moment before its answer is read.
            ended = connection => match ended {
                Ok(()) => answer.await,
                Err(error) => Err(failed(&error)),
            },
        }
    })
}

fn no_connection(socket: &Path, error: &std::io::Error) -> AskError {
    let at = socket.display();
    match error.kind() {
        ErrorKind::NotFound | ErrorKind::ConnectionRefused => AskError::NoService(format!(
            "no service at {at}; start it: systemctl start patrold"
        )),
        ErrorKind::PermissionDenied => AskError::Failed(format!(
            "{at}: this user may not command the robot; join the socket's group (patrold)"
        )),
        _ => AskError::Failed(format!("{at}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::{ask_at, sweep};
    use serde_json::Value;

    #[test]
    fn without_a_service_the_way_to_start_it_is_told() {
        let dir = tempfile::tempdir().expect("temp dir");
        let socket = dir.path().join("p.sock");
        let asked = ask_at::<Value>(&socket, "/visit", "hall");
        let told = asked.expect_err("nobody there").to_string();
        let at = socket.display();
        assert_eq!(
            told,
            format!("no service at {at}; start it: systemctl start patrold")
        );
        assert!(sweep(&socket).expect("no failure").is_none());
    }
}
