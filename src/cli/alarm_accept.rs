//! `patrold alarms accept ID...`: what the last visit saw of these alarms becomes normal. Through the service, which sees who
//! asks; where none runs, in the store.

use super::failure::{CommandResult, DONE, Failure};
use super::{client, config, output};
use crate::config::Settings;
use crate::service::replies::AcceptReply;
use crate::service::{Acceptance, operator, record_time_now};
use crate::store::Store;
use serde_json::json;
use std::path::Path;

/// `settings` say where the service is; without one, the configuration in `file` has to be in force as a whole.
pub(super) fn run(
    settings: &Settings,
    file: Option<&Path>,
    ids: &[i64],
    by: Option<&str>,
    as_json: bool,
) -> CommandResult {
    let mut accepted = Vec::new();
    for id in ids {
        let body = json!({"id": id, "by": by});
        let reply = match client::request_accept(&settings.api.socket, *id, body)? {
            Some(reply) => reply,
            None => accept_in_store(&config::load_settings(file)?, *id, by)?,
        };
        if !as_json {
            output::line(format!(
                "alarm {id}: normal from reference {}/{} on",
                reply.waypoint, reply.version
            ))?;
        }
        accepted.push(reply);
    }
    if as_json {
        output::json(&json!({"accepted": accepted}))?;
    }
    Ok(DONE)
}

fn accept_in_store(settings: &Settings, id: i64, by: Option<&str>) -> Result<AcceptReply, Failure> {
    let mut store = Store::open_existing(&settings.store.dir)?;
    let by = operator(by, rustix::process::getuid().as_raw());
    let accepted = Acceptance::prepare(&store, settings, id)
        .and_then(|acceptance| acceptance.store(&mut store, &by, &record_time_now()))?;
    Ok(accepted)
}
