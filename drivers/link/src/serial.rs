//! A serial port: 8N1, raw, no handshake, held exclusively.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::io::Errno;
use serialport::{ClearBuffer, DataBits, FlowControl, Parity, SerialPort, StopBits, TTYPort};

use crate::{Link, LinkError};

/// Attempts to lock a port before it counts as busy, and the pause between them. A dying process, or a pseudo-terminal that checks
/// its client, may hold the lock for a moment.
const LOCK_TRIES: u32 = 3;
const LOCK_PAUSE: Duration = Duration::from_millis(20);

/// An open serial port (or the client's side of a pseudo-terminal, where the baud rate means nothing).
pub struct SerialLink {
    name: String,
    /// Holds the lock and the settings.
    port: TTYPort,
    /// The same port, opened non-blocking: a blocking write has no time limit if the device takes no bytes.
    node: File,
}

impl SerialLink {
    /// Opens `path` at `baud` with 8 data bits, no parity, one stop bit and no handshake, for exclusive use (`TIOCEXCL` and an
    /// advisory lock, as the first does not stop root), and discards buffered bytes in both directions.
    ///
    /// # Errors
    /// [`LinkError::NotFound`], [`LinkError::Busy`], [`LinkError::PermissionDenied`], or [`LinkError::Io`], for example if the node
    /// is not a terminal.
    pub fn open(path: &str, baud: u32) -> Result<Self, LinkError> {
        let node = lock(path)?;
        // `TTYPort` takes its own lock, for which this one must be free.
        flock(&node, FlockOperation::Unlock).map_err(|e| LinkError::on_open(path, e.into()))?;
        let builder = serialport::new(path, baud)
            .data_bits(DataBits::Eight)
            .parity(Parity::None)
            .stop_bits(StopBits::One)
            .flow_control(FlowControl::None)
            .exclusive(true);
        let port = TTYPort::open(&builder).map_err(|e| match e.kind() {
            // The node existed a moment ago: with this kind `serialport` reports a port in use.
            serialport::ErrorKind::NoDevice => LinkError::busy(path),
            _ => LinkError::on_open(path, e.into()),
        })?;
        port.clear(ClearBuffer::All)
            .map_err(|e| LinkError::on_open(path, e.into()))?;
        Ok(Self {
            name: path.to_owned(),
            port,
            node,
        })
    }

    /// Waits until the port is ready for `flags`, or has a fault that the next transfer will report; false on timeout.
    fn wait(&self, flags: PollFlags, timeout: Duration) -> Result<bool, LinkError> {
        let mut fds = [PollFd::new(&self.node, flags)];
        let limit = Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(timeout.subsec_nanos()),
        };
        match poll(&mut fds, Some(&limit)) {
            Ok(count) => Ok(count > 0),
            Err(Errno::INTR) => Ok(false),
            Err(e) => Err(LinkError::on_transfer(&self.name, e.into())),
        }
    }
}

/// Opens the node without waiting for a carrier, and locks it.
fn lock(path: &str) -> Result<File, LinkError> {
    let mut tries_left = LOCK_TRIES;
    loop {
        let flags = OFlags::NOCTTY | OFlags::NONBLOCK;
        let result = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags.bits().cast_signed())
            .open(path)
            .and_then(|file| {
                flock(&file, FlockOperation::NonBlockingLockExclusive)
                    .map(|()| file)
                    .map_err(io::Error::from)
            });
        match result.map_err(|e| LinkError::on_open(path, e)) {
            Err(LinkError::Busy { .. }) if tries_left > 1 => {
                tries_left -= 1;
                thread::sleep(LOCK_PAUSE);
            }
            other => return other,
        }
    }
}

impl Link for SerialLink {
    fn set_baud(&mut self, baud: u32) -> Result<(), LinkError> {
        self.port
            .set_baud_rate(baud)
            .map_err(|e| LinkError::on_transfer(&self.name, e.into()))
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if buffer.is_empty() || !self.wait(PollFlags::IN, timeout)? {
            return Ok(0);
        }
        match rustix::io::read(&self.node, buffer) {
            // The poll reported data: 0 bytes now mean the end of the file.
            Ok(0) => Err(LinkError::disconnected(&self.name, "end of file")),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(e) => Err(LinkError::on_transfer(&self.name, e.into())),
        }
    }

    fn write_all(&mut self, bytes: &[u8], timeout: Duration) -> Result<(), LinkError> {
        let until = Instant::now() + timeout;
        let mut written = 0;
        while let Some(rest) = bytes.get(written..).filter(|rest| !rest.is_empty()) {
            match rustix::io::write(&self.node, rest) {
                Ok(count) if count > 0 => written += count,
                Ok(_) | Err(Errno::AGAIN) => {
                    let left = until.saturating_duration_since(Instant::now());
                    if !self.wait(PollFlags::OUT, left)? && Instant::now() >= until {
                        return Err(LinkError::TimedOut {
                            name: self.name.clone(),
                            written,
                            wanted: bytes.len(),
                        });
                    }
                }
                Err(Errno::INTR) => {}
                Err(e) => return Err(LinkError::on_transfer(&self.name, e.into())),
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
    use crate::PseudoTerminal;

    const LONG: Duration = Duration::from_secs(5);

    fn open(device: &PseudoTerminal) -> Result<SerialLink, LinkError> {
        SerialLink::open(&device.slave_path().to_string_lossy(), 9600)
    }

    #[test]
    fn every_byte_value_goes_both_ways_unchanged() {
        let mut device = PseudoTerminal::open(None).expect("a pseudo-terminal");
        let mut host = open(&device).expect("the slave opens");
        let all: Vec<u8> = (0..=255).collect();

        host.write_all(&all, LONG).expect("the host writes");
        let mut got = Vec::new();
        while got.len() < all.len() {
            assert!(
                device.wait_readable(LONG).expect("wait"),
                "only {} bytes came",
                got.len()
            );
            let mut buffer = [0; 64];
            let count = device.read_available(&mut buffer).expect("device reads");
            got.extend_from_slice(&buffer[..count]);
        }
        assert_eq!(got, all);

        assert_eq!(device.write(&all).expect("the device writes"), all.len());
        let mut got = Vec::new();
        while got.len() < all.len() {
            let mut buffer = [0; 64];
            let count = host.read(&mut buffer, LONG).expect("host reads");
            assert!(count > 0, "only {} bytes came", got.len());
            got.extend_from_slice(&buffer[..count]);
        }
        assert_eq!(got, all);
        assert_eq!(
            host.read(&mut [0; 8], Duration::ZERO)
                .expect("an empty line is no fault"),
            0
        );
    }

    #[test]
    fn a_second_opening_is_busy_and_the_first_lives_on() {
        let mut device = PseudoTerminal::open(None).expect("a pseudo-terminal");
        let mut host = open(&device).expect("the slave opens");
        let Err(error @ LinkError::Busy { .. }) = open(&device) else {
            panic!("taken twice");
        };
        let text = error.to_string();
        let this = format!("(pid {})", std::process::id());
        assert!(text.contains(&this), "{text}");
        host.write_all(b"x", LONG).expect("the first still writes");
        assert!(device.wait_readable(LONG).expect("wait"));
        drop(host);
        assert!(open(&device).is_ok(), "closing frees the port");
    }

    #[test]
    fn unplugging_is_a_disconnection() {
        let device = PseudoTerminal::open(None).expect("a pseudo-terminal");
        let mut host = open(&device).expect("the slave opens");
        drop(device);
        assert!(matches!(
            host.read(&mut [0; 8], LONG),
            Err(LinkError::Disconnected { .. })
        ));
        assert!(matches!(
            host.write_all(b"PP ", LONG),
            Err(LinkError::Disconnected { .. })
        ));
    }

    #[test]
    fn a_missing_path_is_named() {
        let error = SerialLink::open("/dev/there-is-no-such-port", 9600)
            .err()
            .expect("an error");
        assert!(matches!(error, LinkError::NotFound { .. }));
        assert!(error.to_string().contains("/dev/there-is-no-such-port"));
    }

    #[test]
    fn a_node_that_is_no_terminal_is_refused() {
        assert!(SerialLink::open("/dev/null", 9600).is_err());
    }

    #[test]
    fn a_device_that_does_not_read_makes_a_write_time_out() {
        let device = PseudoTerminal::open(None).expect("a pseudo-terminal");
        let mut host = open(&device).expect("the slave opens");
        let flood = vec![b'x'; 1 << 20];
        let error = host
            .write_all(&flood, Duration::from_millis(50))
            .expect_err("nobody reads");
        assert!(
            matches!(error, LinkError::TimedOut { written, wanted, .. } if written < wanted),
            "{error}"
        );
    }
}
