//! What the package holds: its files, the unit, the maintainer scripts.

use crate::{documents, generate};
use patrold::config::Settings;
use patrold_test_support::workspace_root;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Highest exposure of the unit, of 10 (`systemd-analyze security`).
const MAX_EXPOSURE: f64 = 1.0;

fn read(file: &str) -> String {
    fs::read_to_string(workspace_root().join(file))
        .unwrap_or_else(|error| panic!("{file}: {error}"))
}

fn package() -> toml::Table {
    let manifest: toml::Table = read("Cargo.toml").parse().expect("a manifest");
    manifest["package"]["metadata"]["deb"]
        .as_table()
        .expect("a table")
        .clone()
}

/// Source (perhaps `folder/*.ending`) and destination of each file.
fn assets() -> Vec<(String, String)> {
    let package = package();
    let assets = package["assets"].as_array().expect("a list");
    let text = |value: &toml::Value| value.as_str().expect("a text").to_owned();
    assets
        .iter()
        .map(|asset| (text(&asset[0]), text(&asset[1])))
        .collect()
}

/// Files in `root` that `source` names.
fn matching(root: &Path, source: &str) -> Vec<String> {
    let (folder, name) = source.rsplit_once('/').unwrap_or((".", source));
    let Ok(entries) = fs::read_dir(root.join(folder)) else {
        return Vec::new();
    };
    let fits = |file: &String| match name.strip_prefix('*') {
        Some(ending) => file.ends_with(ending),
        None => file == name,
    };
    let names = entries
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned());
    names
        .filter(fits)
        .map(|file| format!("{folder}/{file}"))
        .collect()
}

#[test]
fn every_file_of_the_package_is_there() {
    let made = tempfile::tempdir().expect("a folder");
    generate::write_all(&workspace_root(), &made.path().join("target/package")).expect("written");
    // cargo-deb finds these by their names in the folder of the unit.
    assert_eq!(
        package()["systemd-units"]["unit-scripts"].as_str(),
        Some("config/")
    );
    let by_name = ["service", "sysusers"].map(|ending| format!("config/patrold.{ending}"));
    let mut packaged = BTreeSet::from(by_name);
    for (source, _) in assets() {
        let files = match source.starts_with("target/package/") {
            true => matching(made.path(), &source),
            false if source == "target/release/patrold" => continue,
            false => matching(&workspace_root(), &source),
        };
        assert!(!files.is_empty(), "{source} names no file");
        packaged.extend(files);
    }
    // All of these, no matter what is added to them.
    for all in ["config/*", "config/scenes/*", "docs/schema/*"] {
        for file in matching(&workspace_root(), all) {
            let is_folder = workspace_root().join(&file).is_dir();
            assert!(
                is_folder || packaged.contains(&file),
                "{file} is not in the package"
            );
        }
    }
    for all in [
        "target/package/man/*",
        "target/package/completions/*",
        "target/package/doc/*",
        "target/package/doc/docs/*",
        "target/package/doc/docs/protocols/*",
    ] {
        for file in matching(made.path(), all) {
            if made.path().join(&file).is_dir() {
                continue;
            }
            assert!(packaged.contains(&file), "{file} is not in the package");
        }
    }
    let shells = generate::SHELLS.len();
    assert_eq!(
        matching(made.path(), "target/package/completions/*").len(),
        shells
    );
}

/// Path of each file in the package, from its root.
fn installed(made: &Path) -> BTreeSet<PathBuf> {
    let mut files = BTreeSet::new();
    for (source, to) in assets() {
        let root = match source.starts_with("target/package/") {
            true => made.to_owned(),
            false => workspace_root(),
        };
        for file in matching(&root, &source) {
            let name = Path::new(&file).file_name().expect("a file");
            let is_folder = to.ends_with('/');
            files.insert(if is_folder {
                Path::new(&to).join(name)
            } else {
                PathBuf::from(&to)
            });
        }
    }
    // cargo-deb compresses it.
    files.insert(Path::new(documents::INSTALLED).join("changelog.gz"));
    files
}

#[test]
fn every_link_of_a_document_leads_into_the_package() {
    let made = tempfile::tempdir().expect("a folder");
    generate::write_all(&workspace_root(), &made.path().join("target/package")).expect("written");
    let installed = installed(made.path());
    let (mut links, mut read) = (0, 0);
    for document in &installed {
        let Ok(path) = document.strip_prefix(documents::INSTALLED) else {
            continue;
        };
        let Ok(text) = fs::read_to_string(made.path().join("target/package/doc").join(path)) else {
            continue;
        };
        read += 1;
        let parts = text.split("](").skip(1);
        let targets = parts
            .filter_map(|part| part.split_once(')'))
            .map(|(target, _)| target);
        for target in targets.filter(|to| !to.starts_with('#') && !to.contains("://")) {
            let file = target.split('#').next().unwrap_or_default();
            // An absolute path replaces the folder.
            let file = Path::new("/").join(document).with_file_name("").join(file);
            let mut steps = PathBuf::new();
            for part in file.components().skip(1) {
                match part.as_os_str().to_str() {
                    Some("..") => drop(steps.pop()),
                    _ => steps.push(part),
                }
            }
            let is_there = installed.iter().any(|there| there.starts_with(&steps));
            assert!(is_there, "{}: {target}", document.display());
            links += 1;
        }
    }
    assert!(read > 5 && links > 20, "{read} documents, {links} links");
}

#[test]
fn the_configuration_is_a_conffile_and_nothing_is_started() {
    // cargo-deb takes every file below /etc as a conffile.
    let in_etc: Vec<_> = assets()
        .into_iter()
        .filter(|(_, to)| to.starts_with("etc/"))
        .collect();
    let expected = ("config/patrold.toml".to_owned(), "etc/patrold/".to_owned());
    assert_eq!(in_etc, [expected]);
    let units = package()["systemd-units"].clone();
    for (key, value) in [
        ("enable", false),
        ("start", false),
        ("restart-after-upgrade", true),
    ] {
        assert_eq!(units[key].as_bool(), Some(value), "{key}");
    }
}

#[test]
fn the_changelog_of_the_package_is_of_this_version() {
    let newest = format!("patrold ({}-1) unstable;", env!("CARGO_PKG_VERSION"));
    assert!(
        read("packaging/debian/changelog").starts_with(&newest),
        "{newest}"
    );
}

/// Values of a setting of the unit, in order.
fn unit(setting: &str) -> Vec<String> {
    let of = |line: &str| Some(line.strip_prefix(setting)?.strip_prefix('=')?.to_owned());
    read("config/patrold.service")
        .lines()
        .filter_map(of)
        .collect()
}

#[test]
fn the_unit_closes_what_the_service_does_not_need() {
    let closed = [
        ("PrivateNetwork", "yes"),
        ("RestrictAddressFamilies", "AF_UNIX"),
        ("IPAddressDeny", "any"),
        ("CapabilityBoundingSet", ""),
        ("AmbientCapabilities", ""),
        ("NoNewPrivileges", "yes"),
        ("ProtectSystem", "strict"),
        ("ProtectHome", "yes"),
        ("PrivateTmp", "yes"),
        ("DevicePolicy", "closed"),
        ("RestrictNamespaces", "yes"),
        ("RestrictSUIDSGID", "yes"),
        ("MemoryDenyWriteExecute", "yes"),
        ("SystemCallArchitectures", "native"),
        ("User", "patrold"),
        ("SupplementaryGroups", "dialout"),
        ("Type", "notify"),
        ("UMask", "0007"),
        ("Restart", "on-failure"),
    ];
    for (setting, value) in closed {
        assert_eq!(unit(setting), [value], "{setting}");
    }
    let calls = ["@system-service", "~@privileged @resources"];
    assert_eq!(unit("SystemCallFilter"), calls);
    // These hide who acknowledges, the identity of the boot, and the devices.
    for absent in ["PrivateUsers", "ProcSubset", "PrivateDevices"] {
        assert!(unit(absent).is_empty(), "{absent}");
    }
    let devices = [
        "char-ttyACM rw",
        "char-ttyUSB rw",
        "char-ttyS rw",
        "char-ttyAMA rw",
    ];
    assert_eq!(unit("DeviceAllow"), devices);
    // The names of both USB drivers are known at start, whatever is plugged in.
    let drivers = "modprobe@cdc_acm.service modprobe@usbserial.service";
    assert!(
        unit("Wants").contains(&drivers.to_owned()) && unit("After").contains(&drivers.to_owned())
    );
}

#[test]
fn the_drop_in_opens_the_network_for_one_address() {
    let drop_in = read("config/laser-tcp.conf");
    for line in [
        "[Service]",
        "PrivateNetwork=no",
        "RestrictAddressFamilies=AF_INET AF_INET6",
    ] {
        assert!(drop_in.lines().any(|l| l == line), "{line}");
    }
    let allowed: Vec<_> = drop_in
        .lines()
        .filter_map(|line| line.strip_prefix("IPAddressAllow="))
        .map(str::parse::<std::net::IpAddr>)
        .collect();
    assert!(matches!(allowed[..], [Ok(_)]), "{allowed:?}");
}

#[test]
fn the_exposure_of_the_unit_is_bounded() {
    let run = Command::new("systemd-analyze")
        .args(["security", "--offline=true", "--no-pager"])
        .arg(workspace_root().join("config/patrold.service"))
        .env("SYSTEMD_COLORS", "0")
        .output();
    let Ok(run) = run else {
        eprintln!("no systemd-analyze on this machine: the exposure of the unit was not measured");
        return;
    };
    let text = String::from_utf8_lossy(&run.stdout);
    let figure = text
        .lines()
        .find_map(|line| line.split_once("exposure level for ")?.1.split(' ').nth(1));
    let Some(exposure) = figure.and_then(|figure| figure.parse::<f64>().ok()) else {
        eprintln!(
            "systemd-analyze gave no figure: {}",
            String::from_utf8_lossy(&run.stderr)
        );
        return;
    };
    eprintln!("exposure {exposure}");
    assert!(exposure <= MAX_EXPOSURE, "{exposure}");
}

#[test]
fn unit_user_and_folders_agree_with_the_configuration() {
    let defaults = Settings::defaults();
    let state = format!("/var/lib/{}", unit("StateDirectory")[0]);
    assert_eq!(Path::new(&state), defaults.store.dir);
    let runtime = format!("/run/{}", unit("RuntimeDirectory")[0]);
    assert_eq!(defaults.api.socket.parent(), Some(Path::new(&runtime)));
    let mode = &unit("StateDirectoryMode")[0];
    let folder = format!("d {state} {mode} patrold patrold -");
    assert!(
        read("config/patrold.tmpfiles")
            .lines()
            .any(|line| line == folder)
    );
    assert!(
        read("config/patrold.sysusers")
            .lines()
            .any(|line| line.starts_with("u patrold - "))
    );
}

/// A root with data, an edited drop-in and a file of somebody else, after `postrm ACTION`.
fn after_postrm(action: &str) -> Vec<bool> {
    let root = tempfile::tempdir().expect("a folder");
    let files = [
        "var/lib/patrold/blobs/a",
        "var/lib/patrold/patrold.db",
        "etc/patrold/patrold.d/90-hall.toml",
        "etc/patrold/patrold.d/10-devices.toml.old",
        "var/lib/other/patrold.db",
        "etc/patrold.conf",
    ];
    for file in files {
        let path = root.path().join(file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, "x").expect("written");
    }
    let script = workspace_root().join("packaging/debian/postrm");
    let run = Command::new("sh")
        .arg(script)
        .arg(action)
        .env("DPKG_ROOT", root.path())
        .status();
    assert!(run.expect("sh").success(), "{action}");
    files
        .iter()
        .map(|file| root.path().join(file).exists())
        .collect()
}

#[test]
fn data_goes_with_a_purge_alone() {
    for action in [
        "remove",
        "upgrade",
        "failed-upgrade",
        "abort-install",
        "disappear",
    ] {
        assert_eq!(after_postrm(action), [true; 6], "{action}");
    }
    assert_eq!(
        after_postrm("purge"),
        [false, false, false, false, true, true]
    );
}

#[test]
fn a_purge_of_nothing_is_fine() {
    let root = tempfile::tempdir().expect("a folder");
    let script = workspace_root().join("packaging/debian/postrm");
    let run = Command::new("sh")
        .arg(script)
        .arg("purge")
        .env("DPKG_ROOT", root.path())
        .status();
    assert!(run.expect("sh").success());
}
