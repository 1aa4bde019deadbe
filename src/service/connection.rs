//! One connection of the control socket: HTTP with time limits, and each request handed on when it is whole.

use super::api_reply::error;
use super::api_state::Peer;
use super::connection_slots::ConnectionSlot;
use super::constants::{MAX_REQUEST_BYTES, REQUEST_BODY_LIMIT, REQUEST_HEAD_LIMIT};
use super::write_limit::WriteLimit;
use axum::body::Body;
use axum::extract::connect_info::ConnectInfo;
use axum::http::{Request, StatusCode};
use axum::response::Response;
use axum::{Extension, Router};
use http_body_util::{BodyExt as _, LengthLimitError, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::convert::Infallible;
use std::sync::Arc;
use tokio::net::UnixStream;
use tokio::sync::watch;
use tokio::time::timeout;

/// Answers the requests of a connection until it ends; once `stopped` is true, only the one under way.
pub(super) async fn serve_connection(
    stream: UnixStream,
    routes: Router,
    slot: ConnectionSlot,
    mut stopped: watch::Receiver<bool>,
) {
    let peer = ConnectInfo(Peer::of(&stream));
    let routes = TowerToHyperService::new(routes.layer(Extension(peer)));
    let slot = Arc::new(slot);
    let answer = service_fn(move |request: Request<Incoming>| {
        let (routes, slot) = (routes.clone(), Arc::clone(&slot));
        async move {
            let request = match whole_request(request).await {
                Ok(request) => request,
                Err(refusal) => return Ok(refusal),
            };
            let _answering = slot.begin_answer();
            let answered: Result<Response, Infallible> = routes.call(request).await;
            answered
        }
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(REQUEST_HEAD_LIMIT)
        .serve_connection(TokioIo::new(WriteLimit::new(stream)), answer);
    tokio::pin!(connection);
    // A failure is the client's: it is gone, or what it sent is no HTTP.
    let is_stopped = async {
        let _ = stopped.wait_for(|stopped| *stopped).await;
    };
    tokio::select! {
        _ = connection.as_mut() => {}
        () = is_stopped => {
            connection.as_mut().graceful_shutdown();
            let _ = connection.await;
        }
    }
}

/// The request with all of its body, or the answer to one that does not become whole.
async fn whole_request(request: Request<Incoming>) -> Result<Request<Body>, Response> {
    let (head, body) = request.into_parts();
    let bytes = whole_body(body).await?;
    Ok(Request::from_parts(head, Body::from(bytes)))
}

async fn whole_body(body: Incoming) -> Result<Bytes, Response> {
    let collected = timeout(
        REQUEST_BODY_LIMIT,
        Limited::new(body, MAX_REQUEST_BYTES).collect(),
    );
    match collected.await {
        Ok(Ok(body)) => Ok(body.to_bytes()),
        Ok(Err(why)) if why.is::<LengthLimitError>() => Err(error(
            StatusCode::PAYLOAD_TOO_LARGE,
            format!("the body is too long; at most {MAX_REQUEST_BYTES} bytes"),
        )),
        Ok(Err(why)) => Err(error(
            StatusCode::BAD_REQUEST,
            format!("the body cannot be read: {why}"),
        )),
        Err(_) => Err(error(
            StatusCode::REQUEST_TIMEOUT,
            format!(
                "the body did not come within {} s",
                REQUEST_BODY_LIMIT.as_secs()
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    use crate::service::connections::serve_connections;
    use axum::Router;
    use axum::routing::post;
    use std::time::Duration;
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
    use tokio::net::{UnixListener, UnixStream};
    use tokio::sync::oneshot;
    use tokio::time::{Instant, timeout};

    /// The bytes that come on a connection that sends `sent`, and how long it stood, in virtual time.
    async fn answer_to(sent: &str) -> (String, Duration) {
        let dir = tempfile::tempdir().expect("temp dir");
        let path = dir.path().join("p.sock");
        let listener = UnixListener::bind(&path).expect("bound");
        let routes = Router::new().route("/echo", post(|body: String| async { body }));
        let (_stop, stopped) = oneshot::channel();
        tokio::spawn(serve_connections(listener, routes, stopped));
        let mut client = UnixStream::connect(&path).await.expect("listens");
        client.write_all(sent.as_bytes()).await.expect("sent");
        let start = Instant::now();
        let mut answer = Vec::new();
        // A connection that is closed with bytes unread ends with an error.
        let ended = timeout(Duration::from_secs(60), client.read_to_end(&mut answer)).await;
        ended.expect("closed within a minute").ok();
        (
            String::from_utf8_lossy(&answer).into_owned(),
            start.elapsed(),
        )
    }

    #[tokio::test(start_paused = true)]
    async fn half_a_request_stands_for_seconds_only() {
        for half in ["", "P", "POST /echo HTTP/1.1\r\nhost: x\r\n"] {
            let (answer, stood) = answer_to(half).await;
            assert_eq!(answer, "", "{half:?}");
            assert_eq!(stood.as_secs(), 10, "{half:?}");
        }
        let half = "POST /echo HTTP/1.1\r\nhost: x\r\ncontent-length: 9\r\n\r\n{";
        let (answer, stood) = answer_to(half).await;
        assert!(answer.starts_with("HTTP/1.1 408 "), "{answer}");
        assert!(
            answer.contains("{\"error\":\"the body did not come"),
            "{answer}"
        );
        assert!((5..=15).contains(&stood.as_secs()), "{stood:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn an_idle_connection_is_closed_after_its_answer() {
        let whole = "POST /echo HTTP/1.1\r\nhost: x\r\ncontent-length: 2\r\n\r\nok";
        let (answer, stood) = answer_to(whole).await;
        assert!(
            answer.starts_with("HTTP/1.1 200 ") && answer.ends_with("\r\n\r\nok"),
            "{answer}"
        );
        assert_eq!(stood.as_secs(), 10);
    }

    #[tokio::test(start_paused = true)]
    async fn a_body_that_is_too_long_or_broken_is_refused_in_words() {
        let long = format!(
            "POST /echo HTTP/1.1\r\nhost: x\r\ncontent-length: 70000\r\n\r\n{}",
            "x".repeat(70_000)
        );
        let (answer, _) = answer_to(&long).await;
        assert!(answer.starts_with("HTTP/1.1 413 "), "{answer}");
        assert!(
            answer.contains("{\"error\":\"the body is too long"),
            "{answer}"
        );
        let broken = "POST /echo HTTP/1.1\r\nhost: x\r\ntransfer-encoding: chunked\r\n\r\nzz\r\n";
        let (answer, _) = answer_to(broken).await;
        assert!(answer.starts_with("HTTP/1.1 400 "), "{answer}");
        assert!(
            answer.contains("{\"error\":\"the body cannot be read"),
            "{answer}"
        );
    }
}
