//! The body of a request: one JSON object of the form that its path has.

use super::api_reply::error;
use axum::body::Bytes;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::Response;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// The body as a `T`. Any other is answered with what is wrong with it, and nothing is done.
#[derive(Debug)]
pub(super) struct JsonObject<T>(pub(super) T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for JsonObject<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Response> {
        let is_json = is_json(request.headers());
        let body = whole(request, state).await?;
        if !is_json {
            let text = "the body must be JSON, with Content-Type: application/json";
            return Err(error(StatusCode::UNSUPPORTED_MEDIA_TYPE, text.to_owned()));
        }
        parse(&body).map(Self).map_err(bad_request)
    }
}

/// No body, or an empty object.
#[derive(Debug)]
pub(super) struct NoBody;

impl<S: Send + Sync> FromRequest<S> for NoBody {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Response> {
        let body = whole(request, state).await?;
        match body.trim_ascii() {
            b"" | b"{}" => Ok(Self),
            _ => Err(bad_request("this request takes no body".to_owned())),
        }
    }
}

async fn whole(request: Request, state: &(impl Send + Sync)) -> Result<Bytes, Response> {
    let body = Bytes::from_request(request, state).await;
    body.map_err(|why| error(why.status(), why.body_text()))
}

fn bad_request(text: String) -> Response {
    error(StatusCode::BAD_REQUEST, text)
}

fn is_json(headers: &HeaderMap) -> bool {
    let kind = headers
        .get(header::CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
        .unwrap_or_default();
    let kind = kind.split(';').next().unwrap_or_default().trim();
    kind.eq_ignore_ascii_case("application/json")
}

fn parse<T: DeserializeOwned>(body: &[u8]) -> Result<T, String> {
    let value: Value =
        serde_json::from_slice(body).map_err(|why| format!("the body is no JSON: {why}"))?;
    // An array would be taken for the keys in their order.
    if !value.is_object() {
        return Err("the body must be a JSON object".to_owned());
    }
    serde_json::from_value(value).map_err(|why| format!("the body is of another form: {why}"))
}

#[cfg(test)]
mod tests {
    use super::parse;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Place {
        waypoint: String,
    }

    #[test]
    fn only_an_object_of_the_form_is_taken() {
        let place: Place = parse(b"{\"waypoint\": \"hall\"}").expect("the form");
        assert_eq!(place.waypoint, "hall");
        for (body, why) in [
            (&b""[..], "no JSON"),
            (b"{\"waypoint\": \"hall\"", "no JSON"),
            (b"{\"waypoint\": \"h\xff\"}", "no JSON"),
            (b"{\"waypoint\": \"hall\"} {}", "no JSON"),
            (b"[\"hall\"]", "must be a JSON object"),
            (b"\"hall\"", "must be a JSON object"),
            (b"null", "must be a JSON object"),
            (b"{}", "missing field `waypoint`"),
            (b"{\"waypoint\": 7}", "invalid type"),
            (b"{\"waypoint\": [\"hall\"]}", "invalid type"),
            (
                b"{\"waypoint\": \"hall\", \"speed\": 2}",
                "unknown field `speed`",
            ),
        ] {
            let error = parse::<Place>(body).expect_err("refused");
            let shown = String::from_utf8_lossy(body);
            assert!(error.contains(why), "{shown}: {error}");
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }
}
