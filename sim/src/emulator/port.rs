//! Ports on which emulated devices are served: a pseudo-terminal, or a TCP server.

use super::constants::{MIN_SOCKET_TIMEOUT, POLL_INTERVAL};
use super::error::EmulatorError;
use link::{LinkError, PseudoTerminal};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::thread;
use std::time::Duration;

/// The device's end of a line.
pub(super) trait EmulatedPort: Send {
    /// Waits for bytes of the client, at most for `timeout`.
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError>;
    /// Reads the bytes that have arrived; 0 is none.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, LinkError>;
    /// Sends what the client can take now; returns how many bytes.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, LinkError>;
    /// The line rate that the client has set, bit/s; `None`: unknown, or there is none.
    fn client_baud(&self) -> Option<u32> {
        None
    }
    /// Whether clients can open it.
    fn is_plugged_in(&self) -> bool;
    /// Disappears, as an unplugged port does: its client gets a hang-up.
    fn hang_up(&mut self);
    /// Appears again, at `link` if there is one.
    fn plug_in(&mut self, link: Option<&Path>) -> Result<(), EmulatorError>;
}

/// A pseudo-terminal with its link, and the name of the port.
pub(super) fn open_terminal(
    link: Option<&Path>,
) -> Result<(Box<dyn EmulatedPort>, String), EmulatorError> {
    let terminal = PseudoTerminal::open(link)?;
    let port = link.unwrap_or(terminal.slave_path()).display().to_string();
    Ok((Box::new(terminal), port))
}

impl EmulatedPort for PseudoTerminal {
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError> {
        self.wait_readable(timeout).map(|_| ())
    }

    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, LinkError> {
        self.read_available(buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<usize, LinkError> {
        PseudoTerminal::write(self, bytes)
    }

    fn client_baud(&self) -> Option<u32> {
        PseudoTerminal::client_baud(self)
    }

    fn is_plugged_in(&self) -> bool {
        PseudoTerminal::is_plugged_in(self)
    }

    fn hang_up(&mut self) {
        PseudoTerminal::hang_up(self);
    }

    fn plug_in(&mut self, link: Option<&Path>) -> Result<(), EmulatorError> {
        Ok(match link {
            Some(link) => self.plug_in_at(link),
            None => PseudoTerminal::plug_in(self),
        }?)
    }
}

/// A TCP server for one client at a time, as the Ethernet sensors are.
pub(super) struct TcpPort {
    address: SocketAddr,
    /// `None` while it is unplugged.
    listener: Option<TcpListener>,
    client: Option<TcpStream>,
    received: Vec<u8>,
}

impl TcpPort {
    /// Listens at `address`; returns also the name of the port.
    pub(super) fn listen(
        address: SocketAddr,
    ) -> Result<(Box<dyn EmulatedPort>, String), EmulatorError> {
        let (listener, address) = bind(address)?;
        let port = format!("tcp:{address}");
        let socket = Self {
            address,
            listener: Some(listener),
            client: None,
            received: Vec::new(),
        };
        Ok((Box::new(socket), port))
    }

    /// Accepts a client if there is none; others wait.
    fn accept(&mut self) {
        if self.client.is_some() {
            return;
        }
        let Some(listener) = &self.listener else {
            return;
        };
        if let Ok((client, _)) = listener.accept() {
            let ready = client
                .set_nodelay(true)
                .and_then(|()| client.set_nonblocking(false));
            self.client = ready.ok().map(|()| client);
        }
    }
}

/// A listener that does not block, and its address.
fn bind(address: SocketAddr) -> Result<(TcpListener, SocketAddr), EmulatorError> {
    let failed = |source| EmulatorError::Listen { address, source };
    let listener = TcpListener::bind(address).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    Ok((listener, address))
}

impl EmulatedPort for TcpPort {
    fn wait(&mut self, timeout: Duration) -> Result<(), LinkError> {
        self.accept();
        let Some(client) = &mut self.client else {
            thread::sleep(timeout.min(Duration::from_millis(2)));
            return Ok(());
        };
        let mut buffer = [0; 4096];
        let read = client
            .set_read_timeout(Some(timeout.max(MIN_SOCKET_TIMEOUT)))
            .and_then(|()| client.read(&mut buffer));
        match read {
            Ok(0) => self.client = None,
            Ok(count) => self
                .received
                .extend(buffer.get(..count).unwrap_or_default()),
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {}
                _ => self.client = None,
            },
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, LinkError> {
        let count = self.received.len().min(buffer.len());
        for (to, from) in buffer.iter_mut().zip(self.received.drain(..count)) {
            *to = from;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<usize, LinkError> {
        // Without a client nothing is held.
        let Some(client) = &mut self.client else {
            return Ok(bytes.len());
        };
        let written = client
            .set_write_timeout(Some(POLL_INTERVAL))
            .and_then(|()| client.write(bytes));
        match written {
            Ok(count) => Ok(count),
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(0),
                _ => {
                    self.client = None;
                    Ok(bytes.len())
                }
            },
        }
    }

    fn is_plugged_in(&self) -> bool {
        self.listener.is_some()
    }

    fn hang_up(&mut self) {
        self.client = None;
        self.listener = None;
        self.received.clear();
    }

    fn plug_in(&mut self, _: Option<&Path>) -> Result<(), EmulatorError> {
        self.listener = Some(bind(self.address)?.0);
        Ok(())
    }
}
