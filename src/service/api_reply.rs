//! Replies of the service as answers of HTTP.

use super::replies::{ErrorReply, ServiceReply};
use crate::patrol::event::RefusalReason;
use axum::Json;
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};

/// Header of a `/sweep` answer with its [`SweepInfo`](super::replies::SweepInfo) as JSON; the body is the PLY.
pub const SWEEP_INFO_HEADER: HeaderName = HeaderName::from_static("x-patrold-sweep");

pub(super) fn respond(reply: ServiceReply) -> Response {
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
            (refusal_status(&refusal), Json(ErrorReply::from(&refusal))).into_response()
        }
    }
}

pub(super) fn refusal_status(refusal: &RefusalReason) -> StatusCode {
    match refusal {
        RefusalReason::UnknownWaypoint(_) => StatusCode::NOT_FOUND,
        RefusalReason::NoReference(_)
        | RefusalReason::Undecided(_)
        | RefusalReason::NearName { .. } => StatusCode::CONFLICT,
        RefusalReason::BadSweep(_) => StatusCode::UNPROCESSABLE_ENTITY,
        RefusalReason::Busy | RefusalReason::Stopping | RefusalReason::NoSweep(_) => {
            StatusCode::SERVICE_UNAVAILABLE
        }
        RefusalReason::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
    }
}

pub(super) fn error(code: StatusCode, error: String) -> Response {
    let nearly = None;
    (code, Json(ErrorReply { error, nearly })).into_response()
}
