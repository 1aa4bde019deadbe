//! A recorded dialogue gives its sweep again, to the last bit: with both motions, several pans, faults that are survived, and
//! what came of a sweep that failed.

use super::links::EmulatedDevices;
use super::rig::{ROOM, TestRig};
use crate::config::{Settings, SweepMode};
use crate::devices::recording::{
    DialogueEnd, DialogueEntryKind as Kind, ReplayError, SweepDialogue, replay_sweep,
};
use crate::devices::{Cancel, Device, DeviceError, PositionTrust, Station, SweepRequest};
use patrold_engine::sweep::RawSweep;
use patrold_sim::emulator::{EmulatedFault, Emulation, EmulationOptions};
use patrold_sim::world::Scene;
use std::sync::{Arc, mpsc};
use std::time::Duration;

struct RecordedStation {
    devices: EmulatedDevices,
    station: Station,
}

impl RecordedStation {
    fn new(seed: u64) -> Self {
        let scene = Scene::parse(ROOM).expect("a scene");
        let world = Arc::new(scene.build(None).expect("no cloud in it"));
        let options = EmulationOptions::seeded(seed);
        let emulation = Emulation::new(options, world, scene.map_from_base, Duration::ZERO);
        let devices = EmulatedDevices::new(emulation);
        let (settings, cancel) = (Settings::defaults(), Cancel::new());
        let (notes, trust) = (mpsc::channel().0, PositionTrust::default());
        let mut station =
            Station::open_with_links(devices.links(), &settings, notes, &trust, &cancel)
                .expect("both answer");
        station.home(&cancel).expect("homes");
        Self { devices, station }
    }

    /// A sweep and its dialogue; `fault` comes 4 s after its start, in the middle of the tilt.
    fn sweep(
        &mut self,
        request: &SweepRequest,
        fault: Option<&str>,
    ) -> (Result<RawSweep, DeviceError>, Vec<u8>) {
        if let Some(fault) = fault {
            let fault: EmulatedFault = fault.parse().expect("a fault");
            let inject = move |emulation: &mut Emulation| emulation.inject(fault);
            self.devices.schedule(Duration::from_secs(4), inject);
        }
        let outcome = self.station.sweep(request, &Cancel::new());
        let dialogue = self.station.take_dialogue().expect("recorded");
        assert_eq!(self.station.take_dialogue(), None, "taken");
        (outcome, dialogue)
    }
}

fn request(mode: SweepMode, pans: &[f64]) -> SweepRequest {
    SweepRequest {
        pans_rad: pans.to_vec(),
        tilt_from_rad: -0.2,
        ..TestRig::request(mode)
    }
}

fn bytes_of(dialogue: &SweepDialogue, device: Device) -> usize {
    let bytes = dialogue
        .entries
        .iter()
        .filter_map(|entry| match &entry.kind {
            Kind::Received(bytes) if entry.device == device => Some(bytes.len()),
            _ => None,
        });
    bytes.sum()
}

#[test]
fn the_bytes_give_the_sweep_to_the_last_bit() {
    let mut recorded = RecordedStation::new(21);
    for (mode, pans) in [
        (SweepMode::Continuous, &[0.0][..]),
        (SweepMode::Continuous, &[-0.4, 0.5]),
        (SweepMode::Step, &[0.2]),
    ] {
        let (outcome, bytes) = recorded.sweep(&request(mode, pans), None);
        let raw = outcome.expect("a sweep");
        let replayed = replay_sweep(&bytes).expect("replayed");
        assert_eq!(replayed.end, DialogueEnd::Complete);
        // Not by the derived equality alone: NaN and the sign of zero count.
        let encode = patrold_engine::sweep::encode_raw_sweep;
        assert_eq!(encode(&replayed.sweep.expect("a sweep")), encode(&raw));
        let dialogue = SweepDialogue::from_bytes(&bytes).expect("read");
        let [laser, head] = [Device::Laser, Device::Head].map(|d| bytes_of(&dialogue, d));
        eprintln!(
            "{mode:?} {pans:?}: {} bytes, laser {laser}, head {head}, {} entries; raw sweep {} bytes",
            bytes.len(),
            dialogue.entries.len(),
            encode(&raw).len()
        );
        // The stamps cost less than the bytes.
        assert!(laser > 20_000 && head > 1000 && bytes.len() < 2 * (laser + head));
        // Both devices speak in turn.
        let mut turns: Vec<Device> = dialogue.entries.iter().map(|e| e.device).collect();
        turns.dedup();
        assert!(turns.len() > 20, "{} turns", turns.len());
    }
}

#[test]
fn a_stream_that_recovered_is_replayed_with_its_time_limits() {
    let mut recorded = RecordedStation::new(22);
    let fault = "laser.silence:for=1";
    let (outcome, bytes) = recorded.sweep(&request(SweepMode::Continuous, &[0.0]), Some(fault));
    let dialogue = SweepDialogue::from_bytes(&bytes).expect("read");
    let deadlines = dialogue.entries.iter();
    assert!(deadlines.clone().any(|e| e.kind == Kind::DriverDeadline));
    assert_eq!(replay_sweep(&bytes).expect("replayed").sweep, outcome);
}

#[test]
fn a_sweep_that_fails_half_way_keeps_what_came() {
    for (fault, in_its_bytes) in [
        ("ptu.stuck:axis=tilt", true),
        ("ptu.event:which=T", true),
        ("laser.silence:for=60", false),
        ("ptu.silence:for=60", false),
        ("laser.unplug:for=30", false),
    ] {
        let mut recorded = RecordedStation::new(23);
        let request = request(SweepMode::Continuous, &[0.0]);
        let (outcome, bytes) = recorded.sweep(&request, Some(fault));
        let error = outcome.map(|_| ()).expect_err(fault);
        let dialogue = SweepDialogue::from_bytes(&bytes).expect("read");
        assert_eq!(dialogue.end, DialogueEnd::Failed(error.to_string()));
        assert!(bytes_of(&dialogue, Device::Laser) > 5000, "{fault}");
        let replayed = replay_sweep(&bytes).expect("replayed").sweep;
        let replayed = replayed.map(|_| ()).expect_err(fault);
        eprintln!("{fault}: {error}; replayed {replayed}");
        // The error of a lost port is not in its bytes.
        let is_lost = replayed.to_string().contains("its port was lost");
        assert!(
            is_lost != in_its_bytes && (is_lost || replayed == error),
            "{fault}"
        );
    }
}

#[test]
fn a_dialogue_of_another_driver_or_without_its_end_gives_no_sweep() {
    let mut recorded = RecordedStation::new(24);
    let (_, bytes) = recorded.sweep(&request(SweepMode::Continuous, &[0.0]), None);
    let whole = SweepDialogue::from_bytes(&bytes).expect("read");
    let replayed = |dialogue: &SweepDialogue| replay_sweep(&dialogue.to_bytes());
    assert_eq!(whole.to_bytes(), bytes);
    let mut half = whole.clone();
    half.entries.truncate(whole.entries.len() / 2);
    half.end = DialogueEnd::TooLong;
    let error = replayed(&half).expect_err("unfinished");
    assert!(matches!(error, ReplayError::Unfinished { .. }), "{error}");
    assert!(error.to_string().contains("largest size"), "{error}");
    for device in [Device::Laser, Device::Head] {
        let mut other = whole.clone();
        let sent = |kind: &Kind| matches!(kind, Kind::Sent(_));
        let of_device = other.entries.iter_mut().filter(|e| e.device == device);
        let entry = of_device.map(|e| &mut e.kind).find(|kind| sent(kind));
        *entry.expect("it sent something") = Kind::Sent(b"??\n".to_vec());
        let error = replayed(&other).expect_err("another driver");
        let named = matches!(error, ReplayError::OtherDriver { device: of, .. } if of == device);
        assert!(named, "{error}");
        let mut silent = whole.clone();
        silent
            .entries
            .retain(|e| e.device != device || !matches!(e.kind, Kind::Received(_)));
        assert!(replayed(&silent).is_err(), "{device}");
    }
    // One byte of a scan is another one: its sum is wrong, and the scan is missing.
    let mut changed = whole.clone();
    let long = |kind: &&mut Kind| matches!(kind, Kind::Received(bytes) if bytes.len() > 40);
    let kinds = changed.entries.iter_mut().map(|e| &mut e.kind);
    let scans: Vec<&mut Kind> = kinds.filter(long).collect();
    let middle = scans.len() / 2;
    let Some(Kind::Received(scan)) = scans.into_iter().nth(middle) else {
        panic!("no scan");
    };
    scan[30] ^= 1;
    let sweeps = [&changed, &whole].map(|d| replayed(d).ok().and_then(|r| r.sweep.ok()));
    assert!(sweeps[1].is_some() && sweeps[0] != sweeps[1]);
}
