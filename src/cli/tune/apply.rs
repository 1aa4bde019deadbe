//! Puts a threshold into force: a file in the folder of the configuration, then a reload. What is refused is taken back.

use crate::cli::failure::Failure;
use crate::cli::{client, drop_in};
use crate::config::{Settings, load, threshold_drop_in};
use serde::Serialize;
use std::path::Path;

/// What was put into force.
#[derive(Debug, Serialize)]
pub(super) struct Applied {
    waypoint: String,
    u_th: f64,
    /// The file that says so.
    file: String,
    /// Whether the running service took it; `None` where none runs.
    reloaded: Option<bool>,
}

impl Applied {
    pub(super) fn text(&self) -> String {
        let then = match self.reloaded {
            Some(_) => "in force",
            None => "in force when the service is started",
        };
        format!(
            "U_th {} at {}: {}, {then}",
            self.u_th, self.waypoint, self.file
        )
    }
}

/// # Errors
/// A file that cannot be written, a configuration that has mistakes with it, another file that sets another value, or a service that
/// does not take it; the configuration is as before then.
pub(super) fn apply(
    config: Option<&Path>,
    settings: &Settings,
    waypoint: &str,
    u_th: f64,
) -> Result<Applied, Failure> {
    let name = format!("90-u_th-{waypoint}.toml");
    let text = threshold_drop_in(settings, waypoint, u_th);
    let (path, reloaded) = drop_in::put(config, &name, &text, || {
        check(config, waypoint, u_th).and_then(|()| reload(settings))
    })?;
    Ok(Applied {
        waypoint: waypoint.to_owned(),
        u_th,
        file: path.display().to_string(),
        reloaded,
    })
}

fn check(config: Option<&Path>, waypoint: &str, u_th: f64) -> Result<(), Failure> {
    let in_force = load(config, &[])?.settings.u_th(Some(waypoint));
    if in_force == u_th {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "a file of the configuration that comes later sets U_th {in_force} at {waypoint}; see patrold config show, and change it there"
    )))
}

fn reload(settings: &Settings) -> Result<Option<bool>, Failure> {
    let socket = &settings.api.socket;
    if client::request_status(socket)?.is_err() {
        return Ok(None);
    }
    let reply = client::request_reload(socket)?;
    if reply.taken {
        return Ok(Some(true));
    }
    Err(Failure::Usage(reply.mistakes.join("\n")))
}
