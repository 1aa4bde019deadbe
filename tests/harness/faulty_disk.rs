//! A disk that counts its steps and fails from one of them on.

use patrold::store::{Disk, DiskFile, SystemDisk, TransactionStep};
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard};

/// What a step fails with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    Full,
    Quota,
    Failing,
    TooManyOpen,
    ReadOnly,
    /// Half of it is written, then the disk is full.
    ShortWrite,
    /// Another program holds the database.
    Busy,
}

impl Fault {
    /// errno(3) of Linux; `None`: such a step does not fail so.
    fn errno(self, step: &str) -> Option<i32> {
        let only_reads = ["open to read", "open a folder"].contains(&step);
        match self {
            Self::Full => Some(28).filter(|_| !only_reads),
            Self::Quota => Some(122).filter(|_| !only_reads),
            Self::Failing => Some(5),
            Self::TooManyOpen => Some(24).filter(|_| step.starts_with("open")),
            Self::ReadOnly => Some(30).filter(|_| !only_reads),
            Self::ShortWrite => Some(28).filter(|_| step == "write"),
            Self::Busy => None,
        }
    }

    /// Result codes of SQLite.
    fn sqlite(self) -> Option<i32> {
        match self {
            Self::Full | Self::ShortWrite => Some(13),
            Self::Quota => Some(10 | (3 << 8)),
            Self::Failing => Some(10 | (4 << 8)),
            Self::TooManyOpen => Some(14),
            Self::ReadOnly => Some(8),
            Self::Busy => Some(5),
        }
    }
}

#[derive(Debug, Default)]
pub(crate) struct Steps {
    /// Names of all steps so far.
    pub(crate) done: Vec<String>,
    /// Fails this step, and all after it if `lasting`.
    pub(crate) fail_at: Option<usize>,
    pub(crate) lasting: bool,
    pub(crate) fault: Option<Fault>,
    /// Other steps do not fail.
    pub(crate) only: Option<String>,
    /// What the disk says is free; `None`: what is.
    pub(crate) free_bytes: Option<u64>,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct FaultyDisk(Arc<Mutex<Steps>>);

impl FaultyDisk {
    pub(crate) fn steps(&self) -> MutexGuard<'_, Steps> {
        self.0.lock().expect("no panic while it is locked")
    }

    /// From now on the `at`th step fails, and with `lasting` all after it.
    pub(crate) fn fail(&self, fault: Fault, at: usize, lasting: bool) {
        let mut steps = self.steps();
        steps.done.clear();
        (steps.fail_at, steps.lasting, steps.fault) = (Some(at), lasting, Some(fault));
    }

    pub(crate) fn heal(&self) {
        let mut steps = self.steps();
        (steps.fail_at, steps.fault, steps.only) = (None, None, None);
        steps.done.clear();
    }

    fn strikes(&self, step: &str) -> Option<Fault> {
        let mut steps = self.steps();
        let at = steps.done.len();
        steps.done.push(step.to_owned());
        let from = steps.fail_at?;
        let concerns = steps.only.as_deref().is_none_or(|only| only == step);
        let strikes = concerns && (at == from || steps.lasting && at > from);
        steps.fault.filter(|_| strikes)
    }

    fn step(&self, step: &str) -> io::Result<()> {
        let errno = self.strikes(step).and_then(|fault| fault.errno(step));
        errno.map_or(Ok(()), |errno| Err(io::Error::from_raw_os_error(errno)))
    }
}

impl Disk for FaultyDisk {
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        SystemDisk.create_folder(path)
    }

    fn create(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        self.step("open to create")?;
        let (file, disk) = (SystemDisk.create(path)?, self.clone());
        Ok(Box::new(FaultyFile { file, disk }))
    }

    fn append(&self, path: &Path) -> io::Result<Box<dyn DiskFile>> {
        self.step("open to append")?;
        let (file, disk) = (SystemDisk.append(path)?, self.clone());
        Ok(Box::new(FaultyFile { file, disk }))
    }

    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.step("open to read")?;
        SystemDisk.read(path)
    }

    fn open_at(&self, path: &Path, offset: u64) -> io::Result<Box<dyn io::Read>> {
        self.step("open to read")?;
        SystemDisk.open_at(path, offset)
    }

    fn sync_file(&self, path: &Path) -> io::Result<()> {
        self.step("open to read")?;
        self.step("sync")?;
        SystemDisk.sync_file(path)
    }

    fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.step("link")?;
        SystemDisk.link(from, to)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.step("rename")?;
        SystemDisk.rename(from, to)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        SystemDisk.remove(path)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.step("open a folder")?;
        self.step("sync of a folder")?;
        SystemDisk.sync_folder(path)
    }

    fn free_bytes(&self, path: &Path) -> io::Result<u64> {
        let told = self.steps().free_bytes;
        told.map_or_else(|| SystemDisk.free_bytes(path), Ok)
    }

    fn transaction_step(&self, step: TransactionStep) -> Result<(), i32> {
        let fault = self.strikes(&format!("{step:?}"));
        fault.and_then(Fault::sqlite).map_or(Ok(()), Err)
    }
}

struct FaultyFile {
    file: Box<dyn DiskFile>,
    disk: FaultyDisk,
}

impl DiskFile for FaultyFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        if let Err(error) = self.disk.step("write") {
            let _ = self.file.write(&bytes[..bytes.len() / 2]);
            return Err(error);
        }
        self.file.write(bytes)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.disk.step("sync")?;
        self.file.sync()
    }
}
