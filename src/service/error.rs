//! Why the service does not run.

use crate::config::ConfigError;
use crate::store::StoreError;
use std::io;
use std::path::PathBuf;

/// A failure of the service as a whole.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The configuration is wrong.
    #[error("{}", lines(.0))]
    Config(Vec<ConfigError>),
    /// The store cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The lock file of the store's folder cannot be used.
    #[error("{}: {source}; check store.dir and that this user may write there", path.display())]
    LockFile {
        /// The lock file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// Another service uses the store.
    #[error("another patrold (pid {pid}) already uses {}", dir.display())]
    StoreInUse {
        /// Process id, as the lock file has it.
        pid: String,
        /// The store's folder.
        dir: PathBuf,
    },
    /// Another program answers at the socket.
    #[error("{}: another program answers there already; stop it, or set api.socket", path.display())]
    SocketInUse {
        /// The socket.
        path: PathBuf,
    },
    /// The socket cannot be created.
    #[error("{}: {source}; check api.socket and that its folder exists and is writable", path.display())]
    Socket {
        /// The socket.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The system refused a thread, a signal handler or the runtime.
    #[error("cannot start {what}: {source}")]
    System {
        /// What could not be started.
        what: &'static str,
        /// Error of the system.
        source: io::Error,
    },
}

fn lines(errors: &[ConfigError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::ServiceError;
    use crate::config::load;

    #[test]
    fn every_mistake_of_the_configuration_has_its_line() {
        let dir = tempfile::tempdir().expect("temp dir");
        let file = dir.path().join("patrold.toml");
        std::fs::write(&file, "laser.prot = 1\nstore.keep_days = -1").expect("written");
        let errors = load(Some(&file), &[]).expect_err("mistakes");
        let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
        let text = ServiceError::Config(errors).to_string();
        assert!(texts.len() == 2 && text.lines().eq(texts), "{text}");
    }
}
