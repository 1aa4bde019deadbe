//! `patrold devices` on the units of `cases/devices`, which answer oddly: a unit that can be used is used, of any other one
//! line says what was heard, what it is and what to do.

use crate::harness::program::patrold;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

/// One mode of a unit, and what `devices` must say of it: a part of its identity, or parts of one line of error.
struct OddMode {
    mode: &'static str,
    connects: bool,
    parts: &'static [&'static str],
}

const fn works(mode: &'static str, parts: &'static [&'static str]) -> OddMode {
    OddMode {
        mode,
        connects: true,
        parts,
    }
}

const fn fails(mode: &'static str, parts: &'static [&'static str]) -> OddMode {
    OddMode {
        mode,
        connects: false,
        parts,
    }
}

const LASERS: [OddMode; 30] = [
    works("crlf", &["H0706400"]),
    works("tm0denied", &["H0706400"]),
    fails("baud", &["heard", "line rate", "laser.port"]),
    fails("garbage", &["heard", "noise"]),
    fails("atmodem", &["ERROR", "modem", "port"]),
    fails("echoer", &["QT", "come back", "bridged"]),
    fails("mute", &["silent", "power and cable", "laser.port"]),
    fails("scip11only", &["SCIP2.0\\nE", "SCIP 1.1 only", "firmware"]),
    fails("zero", &["PP", "ARES", "got \"0\"", "power-cycle"]),
    fails("neg", &["PP", "DMIN", "-20", "power-cycle"]),
    fails(
        "nopp",
        &["no AMIN in the reply to PP", "MODL DMIN DMAX ARES"],
    ),
    fails("absurd", &["AMAX", "99999", "power-cycle"]),
    // These must go on doing as they did.
    works("wrap", &["H0706400"]),
    works("dmax", &["65000"]),
    works("wide", &["1081"]),
    works("half", &["342"]),
    works("slowbyte", &["H0706400"]),
    works("split", &["H0706400"]),
    works("scip1ok", &["H0706400"]),
    works("tick", &["H0706400"]),
    fails("errall", &["SCIP 2.0", "power cycle"]),
    works("slowii", &["H0706400"]),
    works("measii", &["H0706400"]),
    fails("trouble", &["Trouble", "power cycle"]),
    works("odd", &["H0706400"]),
    works("laserfail", &["H0706400"]),
    works("staleqt", &["H0706400"]),
    works("tm0late", &["H0706400"]),
    works("mdrefuse", &["H0706400"]),
    works("mdnothing", &["H0706400"]),
];

const HEADS: [OddMode; 26] = [
    fails(
        "dup",
        &["was answered by", "replies come twice", "power-cycle"],
    ),
    works("slow", &["v2.12.1d1", "-3090"]),
    works("banner", &["v2.12.1d1", "-3090"]),
    fails("baud", &["heard", "line rate", "ptu.port"]),
    fails("loopback", &["come back", "bridged"]),
    fails("mute", &["silent", "ptu.port"]),
    fails("flood", &["* 1", "other programs"]),
    fails("bang", &["Illegal command", "other programs"]),
    fails("zero", &["PR", "answered 0", "arc seconds"]),
    fails("swapped", &["TN", "answered 604", "less than 0"]),
    // These must go on doing as they did.
    works("noecho", &["-3090"]),
    works("cr", &["-3090"]),
    works("lf", &["-3090"]),
    works("nul", &["-3090"]),
    works("d70", &["-12360"]),
    works("mixed", &["-3090"]),
    works("fine", &["-3090"]),
    works("e7500", &["-7500"]),
    works("tiny", &["-20"]),
    works("drip", &["-3090"]),
    works("noO", &["-3090"]),
    works("lateecho", &["-3090"]),
    works("late-9-0.45", &["-3090"]),
    fails("stickyecho", &["Echoing ON"]),
    fails("stickyverbose", &["ASCII verbose"]),
    works("floatpos", &["-3090"]),
];

/// A running unit, killed when dropped.
struct OddUnit(Child);

impl Drop for OddUnit {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What `patrold devices` reports of the unit; `None`: its pseudo-terminal did not appear.
fn report(script: &Path, device: &str, mode: &str) -> Option<serde_json::Value> {
    let dir = tempfile::tempdir().expect("temp dir");
    let config = "laser.port = \"laser\"\nptu.port = \"ptu\"\napi.socket = \"p.sock\"\nstore.dir = \"store\"\n";
    fs::write(dir.path().join("c.toml"), config).expect("written");
    let child = Command::new("python3")
        .arg(script)
        .args([mode, device])
        .current_dir(dir.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _unit = OddUnit(child.expect("python3 starts"));
    let link = dir.path().join(device);
    let there = (0..4000).any(|_| {
        thread::sleep(Duration::from_millis(5));
        link.exists()
    });
    let ran = there.then(|| patrold(dir.path(), &["devices", "--config", "c.toml", "--json"]))?;
    Some(ran.json()[device].clone())
}

fn mistake(device: &str, odd: &OddMode, report: &serde_json::Value) -> Option<String> {
    let text = match (report["error"].as_str(), odd.connects) {
        (None, true) => report.to_string(),
        (Some(error), false) => error.to_owned(),
        _ => return Some(format!("{device} {}: {report}", odd.mode)),
    };
    let missing: Vec<_> = odd
        .parts
        .iter()
        .filter(|part| !text.contains(**part))
        .collect();
    let one_line = odd.connects || (!text.contains('\n') && text.len() < 400);
    (!missing.is_empty() || !one_line)
        .then(|| format!("{device} {}: no {missing:?} in {text}", odd.mode))
}

#[test]
fn each_odd_unit_is_used_or_named() {
    let Some(cases) = patrold_test_support::data("cases/devices") else {
        return;
    };
    let lasers = LASERS.iter().map(|odd| ("laser", odd));
    let heads = HEADS.iter().map(|odd| ("ptu", odd));
    let all: Vec<(&str, &OddMode)> = lasers.chain(heads).collect();
    let (next, mistakes) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    // They mostly wait: many at a time.
    thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                while let Some((device, odd)) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let script = cases.join(format!("hostile_{device}.py"));
                    let found = match report(&script, device, odd.mode) {
                        Some(report) => mistake(device, odd, &report),
                        None => Some(format!("{device} {}: no terminal", odd.mode)),
                    };
                    mistakes.lock().expect("no panic").extend(found);
                }
            });
        }
    });
    let mistakes = mistakes.into_inner().expect("no panic");
    assert!(mistakes.is_empty(), "{}", mistakes.join("\n"));
}
