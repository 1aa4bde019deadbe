//! From two devices that are plugged in to a configuration that names them.

use crate::hardware::{folder, start_emulator, start_emulator_at};
use crate::harness::program::{command, patrold};
use crate::harness::schema;
use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Stdio;

#[test]
fn both_devices_are_found_named_and_shown() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    // The configuration has them exchanged.
    let config = "laser.port = \"ptu\"\nptu.port = \"laser\"\napi.socket = \"p.sock\"\nstore.dir = \"store\"\n";
    fs::write(at("c.toml"), config).expect("written");
    let _emulator = start_emulator(dir.path(), &["--time-scale", "3"]);
    let asked = [
        "setup",
        "--config",
        "c.toml",
        "--time-scale",
        "3",
        "--pictures",
        "shown",
        "--json",
    ];
    let once = [&asked[..], &["--no-calibration"]].concat();
    let ran = patrold(dir.path(), &once);
    let found = ran.json();
    schema::check("setup", &found);
    assert_eq!(found["laser"]["serial"], "H0706400", "{found}");
    assert!(found["points"].as_u64() > Some(1000), "{found}");
    assert_eq!(found["config"], serde_json::Value::Null);
    let drop_in = fs::read_to_string(at("c.d/10-devices.toml")).expect("written");
    for line in [
        "laser.port = \"laser\"",
        "laser.serial = \"H0706400\"",
        "ptu.port = \"ptu\"",
    ] {
        assert!(drop_in.lines().any(|l| l == line), "{line}: {drop_in}");
    }
    for picture in ["patrold-above.svg", "patrold-side.svg"] {
        let svg = fs::read_to_string(at("shown").join(picture)).expect("drawn");
        assert!(svg.contains("<path d=\"M"), "{picture}");
    }
    // With the drop-in the same configuration is right.
    let ran = patrold(
        dir.path(),
        &["devices", "--config", "c.toml", "--time-scale", "3"],
    );
    assert_eq!(ran.code, 0, "{ran:?}");

    // What a later file overrides is taken back.
    fs::write(at("c.d/20-site.toml"), "laser.port = \"elsewhere\"\n").expect("written");
    fs::remove_file(at("c.d/10-devices.toml")).expect("removed");
    let ran = patrold(dir.path(), &once);
    assert_eq!(ran.code, 1, "nothing answers there: {ran:?}");
    assert!(!at("c.d/10-devices.toml").exists());
}

#[test]
fn a_drop_in_that_is_there_is_kept_aside_and_a_later_one_that_wins_is_reported() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    let _emulator = start_emulator(dir.path(), &["--time-scale", "3"]);
    let once = ["setup", "--config", "c.toml", "--no-calibration", "--json"];
    let once = [&once[..], &["--time-scale", "3"]].concat();
    fs::create_dir(at("c.d")).expect("made");
    let read = |name: &str| fs::read_to_string(at(name)).expect("there");

    // Of a laser that was replaced, with a line that a person wrote.
    let earlier = "laser.serial = \"H9999999\"\nrobot.name = \"max\"\n";
    fs::write(at("c.d/10-devices.toml"), earlier).expect("written");
    let ran = patrold(dir.path(), &once);
    let found = ran.json();
    schema::check("setup", &found);
    assert_eq!(found["laser"]["serial"], "H0706400", "{ran:?}");
    let old = found["replaced"].as_str().expect("a file");
    assert!(old.ends_with("c.d/10-devices.toml.old"), "{old}");
    assert_eq!(read("c.d/10-devices.toml.old"), earlier);
    let own = read("c.d/10-devices.toml");
    assert!(own.contains("H0706400") && !own.contains("max"), "{own}");

    // The same again is nothing to keep.
    let ran = patrold(dir.path(), &once);
    assert_eq!(ran.json()["replaced"], serde_json::Value::Null, "{ran:?}");
    assert_eq!(read("c.d/10-devices.toml.old"), earlier);

    // A file that comes later names the devices: nothing is written, and its ports are reported.
    let exchanged = "laser.port = \"ptu\"\nptu.port = \"laser\"\n";
    fs::write(at("c.d/20-site.toml"), exchanged).expect("written");
    fs::write(at("c.d/10-devices.toml"), earlier).expect("written");
    let ran = patrold(dir.path(), &once);
    assert_eq!(ran.code, 2, "{ran:?}");
    assert!(
        ran.err
            .contains("comes after 10-devices.toml names other ports (ptu, laser): laser.port, set by c.d/20-site.toml:1, which wins over"),
        "{ran:?}"
    );
    assert_eq!(read("c.d/10-devices.toml"), earlier);

    // A person's choice of a laser binds.
    fs::write(at("c.d/20-site.toml"), "laser.serial = \"H9999999\"\n").expect("written");
    let ran = patrold(dir.path(), &once);
    assert_eq!(ran.code, 1, "{ran:?}");
    assert!(ran.err.contains("H9999999"), "{ran:?}");
}

#[test]
fn who_may_not_write_the_configuration_is_asked_to_be_root() {
    let dir = folder();
    let may = std::process::Command::new("setpriv")
        .arg("--version")
        .output();
    if !rustix::process::geteuid().is_root() || may.is_err() {
        eprintln!("skipped: needs root and setpriv, to be another user");
        return;
    }
    fs::set_permissions(dir.path(), fs::Permissions::from_mode(0o755)).expect("set");
    let program = dir.path().join("patrold");
    fs::copy(env!("CARGO_BIN_EXE_patrold"), &program).expect("copied");
    let ran = std::process::Command::new("setpriv")
        .args(["--reuid", "61003", "--regid", "61003", "--clear-groups"])
        .arg(program)
        .args(["setup", "--config"])
        .arg(dir.path().join("c.toml"))
        .output()
        .expect("runs");
    let text = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(1), "{text}");
    assert!(
        text.contains("c.d, which this user may not: run it as root") && !text.contains("group"),
        "{text}"
    );
}

#[test]
fn devices_behind_a_network_are_found_as_configured() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    let free = "127.0.0.1:0";
    let ports = ["--laser-tcp", free, "--ptu-tcp", free];
    let (_emulator, ready) = start_emulator_at(dir.path(), &ports, &["--time-scale", "3"]);
    let config = format!(
        "laser.port = {}\nptu.port = {}\napi.socket = \"p.sock\"\nstore.dir = \"store\"\n",
        ready["laser"], ready["ptu"]
    );
    fs::write(at("c.toml"), config).expect("written");
    let once = ["setup", "--config", "c.toml", "--no-calibration", "--json"];
    let ran = patrold(dir.path(), &[&once[..], &["--time-scale", "3"]].concat());
    let found = ran.json();
    assert_eq!(found["laser"]["serial"], "H0706400", "{ran:?}");
    let drop_in = fs::read_to_string(at("c.d/10-devices.toml")).expect("written");
    assert!(
        drop_in.contains(&format!("ptu.port = {}\n", ready["ptu"])),
        "{drop_in}"
    );
}

#[test]
fn a_device_that_is_nowhere_is_named_and_nothing_is_written() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    let config = fs::read_to_string(at("c.toml")).expect("there");
    // Nothing listens at port 1 of this machine.
    let closed = config.replace("\"ptu\"", "\"tcp:127.0.0.1:1\"");
    for (config, reason) in [
        (&config, "no device at"),
        (&closed, "no device at 127.0.0.1:1:"),
    ] {
        fs::write(at("c.toml"), config).expect("written");
        let ran = patrold(
            dir.path(),
            &["setup", "--config", "c.toml", "--no-calibration"],
        );
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{ran:?}");
        assert!(ran.err.contains(reason), "{ran:?}");
        assert!(!at("c.d").exists());
    }
}

#[test]
fn a_calibration_that_is_interrupted_keeps_the_sweeps_that_it_has() {
    let dir = folder();
    let _emulator = start_emulator(dir.path(), &["--time-scale", "3"]);
    let asked = [
        "calibrate",
        "--config",
        "c.toml",
        "--one-pan",
        "--time-scale",
        "3",
        "--keep",
        "kept",
    ];
    let mut calibration = command(dir.path(), &asked)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("starts");
    let first = dir.path().join("kept/sweep-1.raw");
    while !first.exists() {
        assert!(
            calibration.try_wait().expect("asked").is_none(),
            "ended early"
        );
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let signal = std::process::Command::new("kill")
        .arg(calibration.id().to_string())
        .status();
    assert!(signal.expect("kill runs").success());
    assert_eq!(calibration.wait().expect("ends").code(), Some(1));
    // It is whole: a calibration reads it, whatever it makes of a single sweep.
    let ran = patrold(dir.path(), &["calibrate", "kept/sweep-1.raw"]);
    assert!(!ran.err.contains("sweep-1.raw"), "{ran:?}");
    assert!(!dir.path().join("kept/sweep-6.raw").exists());
}
