//! The device's side of a pseudo-terminal, for the emulators.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::{OpenOptionsExt, symlink};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FlockOperation, OFlags, fcntl_getfl, fcntl_setfl, flock};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{
    OptionalActions, QueueSelector, ioctl_tiocnxcl, tcflush, tcgetattr, tcsetattr,
};

use crate::LinkError;

/// How often to check whether a client died while it held the terminal.
const CLIENT_CHECK_EVERY: Duration = Duration::from_millis(500);

/// Line rate of a new terminal, bit/s: one that no client sets, so that a set one is known.
const UNSET_BAUD: u32 = 50;

/// A pseudo-terminal, seen from the device. Clients open [`PseudoTerminal::slave_path`] or the link to it like a serial port.
pub struct PseudoTerminal {
    link_path: Option<PathBuf>,
    slave_path: PathBuf,
    ends: Option<TerminalEnds>,
}

struct TerminalEnds {
    master: OwnedFd,
    /// Kept open: without any client the master would read EIO.
    slave: File,
    last_client_check: Option<Instant>,
}

impl PseudoTerminal {
    /// Opens a raw pseudo-terminal (no echo, no mapping of CR or LF) and, if given, a symbolic link to it at `link_path`. A dangling
    /// symbolic link there is replaced; anything else is an error.
    ///
    /// # Errors
    /// [`LinkError::Io`] if the system gives no terminal, or if `link_path` exists;
    /// [`LinkError::PermissionDenied`] and [`LinkError::NotFound`] for the link's folder.
    pub fn open(link_path: Option<&Path>) -> Result<Self, LinkError> {
        let (slave_path, ends) = open_pair()?;
        let terminal = Self {
            link_path: None,
            slave_path,
            ends: Some(ends),
        };
        terminal.with_link(link_path)
    }

    fn with_link(mut self, link_path: Option<&Path>) -> Result<Self, LinkError> {
        if let Some(path) = link_path {
            create_link(path, &self.slave_path)?;
            self.link_path = Some(path.to_owned());
        }
        Ok(self)
    }

    /// The node that clients open, under `/dev/pts`.
    #[must_use]
    pub fn slave_path(&self) -> &Path {
        &self.slave_path
    }

    /// Whether a client can open it now.
    #[must_use]
    pub fn is_plugged_in(&self) -> bool {
        self.ends.is_some()
    }

    /// The line rate that a client has set, bit/s; `None`: none so far.
    #[must_use]
    pub fn client_baud(&self) -> Option<u32> {
        let settings = tcgetattr(&self.ends.as_ref()?.slave).ok()?;
        Some(settings.output_speed()).filter(|baud| *baud != UNSET_BAUD)
    }

    /// Reads what the client has sent, without waiting. 0 means nothing.
    ///
    /// # Errors
    /// [`LinkError::Io`] for faults of the system.
    pub fn read_available(&mut self, buffer: &mut [u8]) -> Result<usize, LinkError> {
        let Some(ends) = &self.ends else { return Ok(0) };
        loop {
            match rustix::io::read(&ends.master, &mut *buffer) {
                Ok(count) => return Ok(count),
                Err(rustix::io::Errno::INTR) => {}
                Err(rustix::io::Errno::AGAIN) => return Ok(0),
                Err(e) => return Err(self.fault(e)),
            }
        }
    }

    /// Sends to the client without waiting, as much as the terminal's buffer holds. Returns the number of bytes sent.
    ///
    /// # Errors
    /// [`LinkError::Io`] for faults of the system.
    pub fn write(&mut self, bytes: &[u8]) -> Result<usize, LinkError> {
        let mut taken = 0;
        while let (Some(ends), Some(rest)) = (
            &self.ends,
            bytes.get(taken..).filter(|rest| !rest.is_empty()),
        ) {
            match rustix::io::write(&ends.master, rest) {
                Ok(0) | Err(rustix::io::Errno::AGAIN) => break,
                Ok(count) => taken += count,
                Err(rustix::io::Errno::INTR) => {}
                Err(e) => return Err(self.fault(e)),
            }
        }
        Ok(taken)
    }

    /// Waits at most `timeout` for bytes from the client; true if there are some. While unplugged it only waits.
    ///
    /// # Errors
    /// [`LinkError::Io`] for faults of the system.
    pub fn wait_readable(&mut self, timeout: Duration) -> Result<bool, LinkError> {
        self.clear_stale_exclusive_mark();
        let limit = Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(timeout.subsec_nanos()),
        };
        let mut fds: Vec<PollFd<'_>> = self
            .ends
            .iter()
            .map(|e| PollFd::new(&e.master, PollFlags::IN))
            .collect();
        match poll(&mut fds, Some(&limit)) {
            Ok(_) => Ok(fds
                .first()
                .is_some_and(|fd| fd.revents().contains(PollFlags::IN))),
            Err(rustix::io::Errno::INTR) => Ok(false),
            Err(e) => Err(self.fault(e)),
        }
    }

    /// Unplugs the device: an open client loses its port, the link is removed.
    pub fn hang_up(&mut self) {
        self.ends = None;
        if let Some(path) = &self.link_path {
            remove_own_link(path, &self.slave_path);
        }
    }

    /// Plugs the device in again after [`PseudoTerminal::hang_up`], as a new terminal at the same link. Does nothing if plugged in.
    ///
    /// # Errors
    /// As [`PseudoTerminal::open`].
    pub fn plug_in(&mut self) -> Result<(), LinkError> {
        if self.ends.is_none() {
            let (slave_path, ends) = open_pair()?;
            if let Some(path) = &self.link_path {
                create_link(path, &slave_path)?;
            }
            self.slave_path = slave_path;
            self.ends = Some(ends);
        }
        Ok(())
    }

    /// As [`PseudoTerminal::plug_in`], with the link at another path from now on.
    ///
    /// # Errors
    /// As [`PseudoTerminal::open`].
    pub fn plug_in_at(&mut self, link_path: &Path) -> Result<(), LinkError> {
        if self.ends.is_none() {
            self.link_path = Some(link_path.to_owned());
        }
        self.plug_in()
    }

    /// Clears the mark of exclusive use (`TIOCEXCL`) that a killed client leaves behind, since our own end keeps the terminal alive.
    /// If no process holds the lock, the mark is stale.
    fn clear_stale_exclusive_mark(&mut self) {
        let Some(ends) = &mut self.ends else { return };
        let now = Instant::now();
        if ends
            .last_client_check
            .is_some_and(|last| now.saturating_duration_since(last) < CLIENT_CHECK_EVERY)
        {
            return;
        }
        ends.last_client_check = Some(now);
        if flock(&ends.slave, FlockOperation::NonBlockingLockShared).is_ok() {
            // Both can only fail on a closed descriptor, which this one is not.
            let _ = ioctl_tiocnxcl(&ends.slave);
            let _ = flock(&ends.slave, FlockOperation::Unlock);
        }
    }

    fn fault(&self, errno: rustix::io::Errno) -> LinkError {
        LinkError::Io {
            name: self.slave_path.display().to_string(),
            source: errno.into(),
        }
    }
}

impl Drop for PseudoTerminal {
    fn drop(&mut self) {
        self.hang_up();
    }
}

fn open_pair() -> Result<(PathBuf, TerminalEnds), LinkError> {
    let fault = |source: io::Error| LinkError::on_open("/dev/ptmx", source);
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
        .map_err(|e| fault(e.into()))?;
    grantpt(&master).map_err(|e| fault(e.into()))?;
    unlockpt(&master).map_err(|e| fault(e.into()))?;
    let name = ptsname(&master, Vec::new()).map_err(|e| fault(e.into()))?;
    let path = PathBuf::from(name.to_string_lossy().into_owned());
    let slave = OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags(OFlags::NOCTTY.bits().cast_signed())
        .open(&path)
        .map_err(fault)?;
    let mut settings = tcgetattr(&slave).map_err(|e| fault(e.into()))?;
    settings.make_raw();
    settings
        .set_speed(UNSET_BAUD)
        .map_err(|e| fault(e.into()))?;
    tcsetattr(&slave, OptionalActions::Now, &settings).map_err(|e| fault(e.into()))?;
    tcflush(&slave, QueueSelector::IOFlush).map_err(|e| fault(e.into()))?;
    let flags = fcntl_getfl(&master).map_err(|e| fault(e.into()))?;
    fcntl_setfl(&master, flags | OFlags::NONBLOCK).map_err(|e| fault(e.into()))?;
    Ok((
        path,
        TerminalEnds {
            master,
            slave,
            last_client_check: None,
        },
    ))
}

/// Creates a symbolic link to `target` at `path`. Replaces only a dangling symbolic link: one with a target may be the name of a
/// real device or of another emulator's terminal.
fn create_link(path: &Path, target: &Path) -> Result<(), LinkError> {
    let name = path.display().to_string();
    match fs::symlink_metadata(path) {
        Ok(there) if there.file_type().is_symlink() && path.exists() => {
            let detail = "a symbolic link to an existing device or terminal; remove it first";
            return Err(LinkError::Io {
                name,
                source: io::Error::new(io::ErrorKind::AlreadyExists, detail),
            });
        }
        Ok(there) if there.file_type().is_symlink() => {
            fs::remove_file(path).map_err(|e| LinkError::on_open(&name, e))?;
        }
        Ok(_) => {
            let detail = "exists and is not a symbolic link; choose another path";
            return Err(LinkError::Io {
                name,
                source: io::Error::new(io::ErrorKind::AlreadyExists, detail),
            });
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
        Err(e) => return Err(LinkError::on_open(&name, e)),
    }
    symlink(target, path).map_err(|e| LinkError::on_open(&name, e))
}

/// Removes the link if it still points at our terminal.
fn remove_own_link(path: &Path, target: &Path) {
    if fs::read_link(path).is_ok_and(|points_at| points_at == target) {
        // On failure the link dangles and the next opening replaces it.
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Link, SerialLink};

    const LONG: Duration = Duration::from_secs(5);

    fn scratch(name: &str) -> PathBuf {
        let folder =
            std::env::temp_dir().join(format!("patrold-link-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).expect("a scratch folder");
        folder
    }

    #[test]
    fn the_link_leads_to_the_terminal_and_goes_with_it() {
        let folder = scratch("link");
        let path = folder.join("ptu");
        let first = PseudoTerminal::open(Some(&path)).expect("opens");
        assert_eq!(fs::read_link(&path).expect("a link"), first.slave_path());
        let mut host =
            SerialLink::open(&path.to_string_lossy(), 9600).expect("opens through the link");
        host.write_all(b"PP ", LONG).expect("writes");
        drop(first);
        assert!(fs::symlink_metadata(&path).is_err(), "the link is removed");
        fs::remove_dir_all(folder).expect("tidied");
    }

    #[test]
    fn only_a_dangling_symbolic_link_is_replaced() {
        let folder = scratch("refuse");
        let path = folder.join("precious");
        fs::write(&path, "data").expect("a file");
        assert!(PseudoTerminal::open(Some(&path)).is_err());
        assert_eq!(fs::read(&path).expect("still there"), b"data");
        let real = folder.join("real");
        symlink("/dev/null", &real).expect("the name of a device");
        assert!(PseudoTerminal::open(Some(&real)).is_err());
        assert_eq!(
            fs::read_link(&real).expect("still there"),
            Path::new("/dev/null")
        );
        let stale = folder.join("stale");
        symlink("/dev/pts/no-such", &stale).expect("an old link");
        let first = PseudoTerminal::open(Some(&stale)).expect("replaces it");
        assert!(
            PseudoTerminal::open(Some(&stale)).is_err(),
            "served by another"
        );
        assert_eq!(fs::read_link(&stale).expect("a link"), first.slave_path());
        fs::remove_dir_all(folder).expect("tidied");
    }

    #[test]
    fn without_a_client_nothing_blocks_and_nothing_fails() {
        let mut device = PseudoTerminal::open(None).expect("opens");
        assert_eq!(
            device
                .read_available(&mut [0; 16])
                .expect("no client is no fault"),
            0
        );
        assert!(!device.wait_readable(Duration::ZERO).expect("wait"));
        let flood = vec![b'#'; 1 << 18];
        let taken = device.write(&flood).expect("does not block");
        assert!(taken < flood.len());
    }

    #[test]
    fn the_rate_that_a_client_sets_is_known() {
        let device = PseudoTerminal::open(None).expect("opens");
        assert_eq!(device.client_baud(), None);
        let path = device.slave_path().to_string_lossy().into_owned();
        let mut host = SerialLink::open(&path, 19_200).expect("opens");
        assert_eq!(device.client_baud(), Some(19_200));
        host.set_baud(250_000).expect("set");
        assert_eq!(device.client_baud(), Some(250_000));
    }

    #[test]
    fn unplugged_and_plugged_in_again() {
        let folder = scratch("replug");
        let path = folder.join("ptu");
        let mut device = PseudoTerminal::open(Some(&path)).expect("opens");
        let mut host = SerialLink::open(&path.to_string_lossy(), 9600).expect("opens");
        device.hang_up();
        assert!(matches!(
            host.read(&mut [0; 4], LONG),
            Err(LinkError::Disconnected { .. })
        ));
        assert!(matches!(
            SerialLink::open(&path.to_string_lossy(), 9600),
            Err(LinkError::NotFound { .. })
        ));
        assert_eq!(device.write(b"lost").expect("no fault"), 0);
        device.plug_in().expect("plugs in");
        let mut again = SerialLink::open(&path.to_string_lossy(), 9600).expect("opens again");
        again.write_all(b"ED ", LONG).expect("writes");
        assert!(device.wait_readable(LONG).expect("wait"));
        fs::remove_dir_all(folder).expect("tidied");
    }

    #[test]
    fn the_exclusive_mark_of_a_dead_client_is_cleared() {
        let mut device = PseudoTerminal::open(None).expect("opens");
        {
            // What a killed client leaves: the mark, but no lock.
            let ends = device.ends.as_ref().expect("plugged in");
            rustix::termios::ioctl_tiocexcl(&ends.slave).expect("marked");
        }
        device.wait_readable(Duration::ZERO).expect("looks");
        assert!(SerialLink::open(&device.slave_path().to_string_lossy(), 9600).is_ok());
    }
}
