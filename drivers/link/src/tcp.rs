//! A TCP connection, for sensors on Ethernet and for serial servers.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use crate::{Link, LinkError};

/// Shortest timeout of a socket; the system takes zero as no timeout.
const MIN_TIMEOUT: Duration = Duration::from_micros(1);

/// An open TCP connection with `TCP_NODELAY`.
pub struct TcpLink {
    name: String,
    stream: TcpStream,
}

impl TcpLink {
    /// Connects to `address` (`host:port`), with `timeout` for each address that it resolves to.
    ///
    /// # Errors
    /// [`LinkError::NotFound`] if nothing answers there, [`LinkError::NoNetwork`] in a sandbox, [`LinkError::Io`] if the name does not resolve or the system refuses.
    pub fn connect(address: &str, timeout: Duration) -> Result<Self, LinkError> {
        let resolved = address
            .to_socket_addrs()
            .map_err(|e| LinkError::on_open(address, e))?;
        let mut last = io::Error::new(io::ErrorKind::NotFound, "the name has no address");
        for candidate in resolved {
            match TcpStream::connect_timeout(&candidate, timeout.max(MIN_TIMEOUT)) {
                Ok(stream) => {
                    stream
                        .set_nodelay(true)
                        .map_err(|e| LinkError::on_open(address, e))?;
                    return Ok(Self {
                        name: address.to_owned(),
                        stream,
                    });
                }
                Err(e) if e.kind() == io::ErrorKind::TimedOut => {
                    last = io::Error::new(io::ErrorKind::NotFound, e)
                }
                Err(e) => last = e,
            }
        }
        Err(LinkError::on_connect(address, last))
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
    )
}

impl Link for TcpLink {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.stream
            .set_read_timeout(Some(timeout.max(MIN_TIMEOUT)))
            .map_err(|e| LinkError::on_transfer(&self.name, e))?;
        match self.stream.read(buffer) {
            Ok(0) => Err(LinkError::disconnected(&self.name, "end of stream")),
            Ok(count) => Ok(count),
            Err(e) if is_timeout(&e) || e.kind() == io::ErrorKind::Interrupted => Ok(0),
            Err(e) => Err(LinkError::on_transfer(&self.name, e)),
        }
    }

    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError> {
        let until = Instant::now() + timeout;
        let mut written = 0;
        while let Some(rest) = bytes.get(written..).filter(|rest| !rest.is_empty()) {
            let left = until
                .saturating_duration_since(Instant::now())
                .max(MIN_TIMEOUT);
            self.stream
                .set_write_timeout(Some(left))
                .map_err(|e| LinkError::on_transfer(&self.name, e))?;
            match self.stream.write(rest) {
                Ok(0) => {
                    return Err(LinkError::disconnected(
                        &self.name,
                        "the peer accepts no more bytes",
                    ));
                }
                Ok(count) => written += count,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) if is_timeout(&e) => {
                    return Err(LinkError::TimedOut {
                        name: self.name.clone(),
                        written,
                        wanted: bytes.len(),
                    });
                }
                Err(e) => return Err(LinkError::on_transfer(&self.name, e)),
            }
        }
        Ok(())
    }

    fn name(&self) -> &str {
        &self.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    const LONG: Duration = Duration::from_secs(5);

    #[test]
    fn bytes_go_both_ways_and_closing_is_a_disconnection() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("its address").to_string();
        let mut link = TcpLink::connect(&address, LONG).expect("connected");
        let (mut peer, _) = listener.accept().expect("accepted");

        link.write_all(b"VV\n", LONG).expect("sent");
        let mut got = [0; 3];
        peer.read_exact(&mut got).expect("came");
        assert_eq!(&got, b"VV\n");
        assert_eq!(
            link.read(&mut [0; 8], Duration::ZERO).expect("nothing yet"),
            0
        );
        peer.write_all(b"00P\n").expect("answered");
        let mut buffer = [0; 8];
        assert_eq!(link.read(&mut buffer, LONG).expect("read"), 4);
        drop(peer);
        assert!(matches!(
            link.read(&mut buffer, LONG),
            Err(LinkError::Disconnected { .. })
        ));
    }

    #[test]
    fn a_port_without_listener_is_not_found() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("its address").to_string();
        drop(listener);
        assert!(matches!(
            TcpLink::connect(&address, LONG),
            Err(LinkError::NotFound { .. })
        ));
    }

    #[test]
    fn what_a_sandbox_refuses_names_the_drop_in() {
        // EPERM, EAFNOSUPPORT; ETIMEDOUT.
        let text = |errno| {
            let source = std::io::Error::from_raw_os_error(errno);
            LinkError::on_connect("192.168.0.10:10940", source).to_string()
        };
        for errno in [1, 97] {
            let text = text(errno);
            let named = text.contains("192.168.0.10:10940") && text.contains("laser-tcp.conf");
            assert!(named, "{text}");
        }
        assert!(!text(110).contains("laser-tcp.conf"));
    }
}
