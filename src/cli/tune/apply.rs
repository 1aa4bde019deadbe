//! Puts a threshold into force: a file in the folder of the configuration, then a reload. What is refused is taken back.

use crate::cli::failure::Failure;
use crate::cli::{client, files};
use crate::config::{Settings, drop_in_folder, load, threshold_drop_in};
use serde::Serialize;
use std::fs;
use std::io;
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
    let folder = drop_in_folder(config);
    let path = folder.join(format!("90-u_th-{waypoint}.toml"));
    let before = match fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(files::file_error(&path, error)),
    };
    fs::create_dir_all(&folder).map_err(|error| files::file_error(&folder, error))?;
    replace(
        &path,
        threshold_drop_in(settings, waypoint, u_th).as_bytes(),
    )?;
    let taken = check(config, waypoint, u_th).and_then(|()| reload(settings));
    if taken.is_err() {
        match &before {
            Some(bytes) => replace(&path, bytes)?,
            None => fs::remove_file(&path).map_err(|error| files::file_error(&path, error))?,
        }
    }
    Ok(Applied {
        waypoint: waypoint.to_owned(),
        u_th,
        file: path.display().to_string(),
        reloaded: taken?,
    })
}

/// Written aside and renamed: a reload never sees half of it.
fn replace(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let aside = path.with_extension("toml.tmp");
    files::write(&aside, bytes)?;
    fs::rename(&aside, path).map_err(|error| files::file_error(path, error))
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
