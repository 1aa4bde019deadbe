//! Why the service does not run.

use crate::config::Mistake;
use crate::store::StoreError;
use std::io;
use std::path::PathBuf;

/// A failure of the service as a whole.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The configuration is wrong.
    #[error("{}", lines(.0))]
    Config(Vec<Mistake>),
    /// The store cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A folder cannot be used.
    #[error("{}: {source}; check store.dir and that this user may write there", path.display())]
    Folder {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Another service uses the store.
    #[error("another patrold (pid {pid}) already uses {}", dir.display())]
    Taken {
        /// Its process.
        pid: String,
        /// The store.
        dir: PathBuf,
    },
    /// Another program answers at the socket.
    #[error("{}: another program answers there already; stop it, or set api.socket", path.display())]
    SocketTaken {
        /// The socket.
        path: PathBuf,
    },
    /// The socket cannot be made.
    #[error("{}: {source}; check api.socket and that its folder exists and is writable", path.display())]
    Socket {
        /// The socket.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The system refused something a service needs.
    #[error("{what}: {source}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What the system said.
        source: io::Error,
    },
}

fn lines(mistakes: &[Mistake]) -> String {
    let lines: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
    lines.join("\n")
}
