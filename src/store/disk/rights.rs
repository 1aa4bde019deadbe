//! Who may use the files of a store: those who may use its folder, whoever made a file and with which umask.
//!
//! SQLite makes a database for its owner to write and its group to read, and `-wal` and `-shm` with the mode of the database.
//! A member of the folder's group that reads while the service is down would make files that the service cannot write.

use rustix::fs::{Access, access};
use rustix::io::Errno;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// Mode of a new database, before the umask.
const READ_WRITE: u32 = 0o666;
/// What SQLite has beside a database.
const SIDE_FILES: [&str; 3] = ["", "-wal", "-shm"];

/// Gives a file that this process has made, or owns, the rights of its folder. What another user owns, and what a link names, stays
/// as it is.
///
/// # Errors
/// The system refuses it.
pub fn share_with_folder(path: &Path) -> io::Result<()> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::metadata(folder.unwrap_or(Path::new(".")))?.mode();
    let file = fs::symlink_metadata(path)?;
    let wanted = shared_mode(file.mode(), folder & READ_WRITE);
    let is_own = file.uid() == rustix::process::geteuid().as_raw();
    if !file.is_file() || !is_own || file.mode() & 0o7777 == wanted {
        return Ok(());
    }
    fs::set_permissions(path, Permissions::from_mode(wanted))
}

/// Gives a new folder in a store the rights of the store's folder.
pub(in crate::store) fn share_folder_with_parent(path: &Path) -> io::Result<()> {
    let Some(parent) = path.parent() else {
        return Ok(());
    };
    let (of_parent, own) = (fs::metadata(parent)?.mode(), fs::metadata(path)?.mode());
    // The system gives it the parent's group where that has the setgid bit, and the bit.
    let wanted = own & 0o7000 | shared_mode(own, of_parent);
    if own & 0o7777 == wanted {
        return Ok(());
    }
    fs::set_permissions(path, Permissions::from_mode(wanted))
}

/// The group may do what it may in the folder; others no more than the umask and the folder let them.
fn shared_mode(own: u32, of_folder: u32) -> u32 {
    own & 0o700 | of_folder & 0o070 | own & of_folder & 0o007
}

/// Makes an empty database file where there is none, so that SQLite makes no file with other rights; and sets those of the
/// files that are there.
pub(in crate::store) fn share_database(path: &Path) -> io::Result<()> {
    let made = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(READ_WRITE)
        .open(path);
    match made {
        Ok(file) => drop::<File>(file),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        Err(error) => return Err(error),
    }
    for suffix in SIDE_FILES {
        match share_with_folder(&beside(path, suffix)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}

/// What keeps this user from the database at `path`, first its folder; `None` where nothing does.
pub(in crate::store) fn forbidden(path: &Path) -> Option<PathBuf> {
    let is_refused = |path: &Path, access_to| access(path, access_to) == Err(Errno::ACCESS);
    let folder = path.parent()?;
    if is_refused(folder, Access::EXEC_OK) {
        return Some(folder.to_owned());
    }
    let files = SIDE_FILES.map(|suffix| beside(path, suffix));
    let all = Access::READ_OK | Access::WRITE_OK;
    if let Some(file) = files.into_iter().find(|file| is_refused(file, all)) {
        return Some(file);
    }
    is_refused(folder, all).then(|| folder.to_owned())
}

/// What a user does who may not use the file, folder or socket.
pub fn access_remedy(path: &Path) -> String {
    let found = path.ancestors().find_map(|at| fs::metadata(at).ok());
    let Some(gid) = found.map(|file| file.gid()) else {
        return "run this as its owner".to_owned();
    };
    let own = rustix::process::getgroups().unwrap_or_default();
    let is_member = rustix::process::getegid().as_raw() == gid;
    if is_member || own.iter().any(|group| group.as_raw() == gid) {
        return format!(
            "nor may its group, which this user is in: as its owner, chmod g+rw {}",
            path.display()
        );
    }
    let group = group_name(gid);
    format!(
        "join its group (usermod -aG {group} USER, then log in again), or run this as its owner"
    )
}

/// As the system names it.
fn group_name(gid: u32) -> String {
    let groups = fs::read_to_string("/etc/group").unwrap_or_default();
    let name = groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)? == gid.to_string()).then(|| name.to_owned())
    });
    name.unwrap_or_else(|| gid.to_string())
}

fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::{share_database, share_with_folder};
    use crate::store::Store;
    use std::fs::{self, Permissions};
    use std::os::unix::fs::PermissionsExt as _;
    use std::path::Path;

    fn set_mode(path: &Path, mode: u32) {
        fs::set_permissions(path, Permissions::from_mode(mode)).expect("set");
    }

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).expect("there").permissions().mode() & 0o7777
    }

    #[test]
    fn every_file_of_a_store_has_the_rights_of_its_folder() {
        for (of_folder, of_file) in [(0o2770, 0o660), (0o700, 0o600), (0o755, 0o644)] {
            let dir = tempfile::tempdir().expect("temp dir");
            set_mode(dir.path(), of_folder);
            let mut store = Store::open(dir.path()).expect("a new store");
            store.hold_reserve().expect("held");
            store
                .transaction(|change| {
                    let sql = "INSERT INTO waypoint (name, created_at) VALUES ('a', '')";
                    Ok(change.execute(sql, [])?)
                })
                .expect("written");
            for name in [
                "patrold.db",
                "patrold.db-wal",
                "patrold.db-shm",
                "patrold.reserve",
            ] {
                assert_eq!(
                    mode(&dir.path().join(name)),
                    of_file,
                    "{name} in {of_folder:o}"
                );
            }
            let journal = dir.path().join("blobs/journal.txt");
            assert_eq!(mode(&journal) & 0o600, 0o600);
            drop(store);
            // Of an earlier version, or copied from elsewhere.
            set_mode(&dir.path().join("patrold.db"), 0o640);
            drop(Store::open(dir.path()).expect("opens"));
            // Never more for others than there was.
            assert_eq!(mode(&dir.path().join("patrold.db")), of_file & 0o660);
        }
    }

    #[test]
    fn a_link_is_not_followed_and_a_missing_file_is_made_empty() {
        let dir = tempfile::tempdir().expect("temp dir");
        set_mode(dir.path(), 0o2770);
        let victim = dir.path().join("victim");
        fs::write(&victim, b"kept").expect("written");
        set_mode(&victim, 0o600);
        let link = dir.path().join("link");
        std::os::unix::fs::symlink(&victim, &link).expect("a link");
        share_with_folder(&link).expect("left alone");
        assert_eq!(mode(&victim), 0o600);
        share_with_folder(&victim).expect("set");
        assert_eq!(mode(&victim), 0o660);
        let db = dir.path().join("patrold.db");
        share_database(&db).expect("made");
        assert_eq!(
            (fs::read(&db).expect("there"), mode(&db)),
            (Vec::new(), 0o660)
        );
    }
}
