//! The emulated laser: any bytes, any faults, at any pace, of any model in any state.

use super::choices::{Choices, chunk};
use scip::emulator::{
    EmulatedLaser, LaserFault, LaserFaultSpec, LaserOptions, LaserProfile, LaserStartState,
    RangeSource,
};
use std::time::Duration;

struct FlatRange;

impl RangeSource for FlatRange {
    fn fill_revolution(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        out.fill(1234);
    }
}

/// Bytes queued for a host that does not read.
const MAX_WAITING: usize = 1 << 20;
/// Virtual time of a run, so that no input is slow.
const MAX_TIME: Duration = Duration::from_secs(120);

pub(crate) fn run(data: &[u8]) {
    let mut choices = Choices(data);
    let mut options = LaserOptions {
        start_state: choices.one_of(&[
            LaserStartState::PowerUp,
            LaserStartState::Idle,
            LaserStartState::LaserOn,
            LaserStartState::Streaming,
            LaserStartState::TimeAdjust,
            LaserStartState::FirmwareUpdate,
        ]),
        seed: u64::from(choices.u16()),
        ..LaserOptions::default()
    };
    let name = choices.one_of(&LaserProfile::NAMES);
    options.set_profile(LaserProfile::by_name(name).expect("of the list"));
    let mut laser = EmulatedLaser::new(options, Duration::ZERO);
    let kinds: Vec<&str> = LaserFault::kinds().collect();
    let mut now = Duration::ZERO;
    while !choices.is_over() && now < MAX_TIME {
        match choices.byte() % 8 {
            0 => {
                let kind = choices.one_of(&kinds);
                let duration = f64::from(choices.byte()) / 10.0;
                let spec = format!("{kind}:at={},for={duration}", now.as_secs_f64());
                laser.inject(spec.parse::<LaserFaultSpec>().expect("a fault"));
            }
            1 => laser.power_cycle(now),
            2 => laser.set_host_baud(u32::from(choices.u16())),
            3 | 4 => {
                now += choices.duration().min(Duration::from_secs(5));
                laser.advance(now, &mut FlatRange);
            }
            _ => laser.handle_bytes(choices.chunk(), now),
        }
        assert!(
            laser
                .next_event()
                .is_none_or(|at| at + Duration::from_secs(60) >= now)
        );
        if choices.byte() % 4 > 0 {
            let mut waiting = 0;
            while let Some(output) = laser.poll_output() {
                assert!(output.at <= now);
                waiting += output.bytes.len();
            }
            assert!(waiting <= MAX_WAITING, "{waiting} bytes waited");
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let requests = [
        "SCIP2.0\nVV\nPP;a b\nII\n",
        "BM\nGD0044072501\nGS0000076805\nME0044072501000\n",
        "MD0044072501005;x\nQT\nTM0\nTM1\nTM2\nRS\nRT\n",
        "SS115200\nCR05\nHS1\nDB04\nMS0100020003199\n",
        "%ST\n%SL\nRB\nRB\nNE0000108002103\nHD0540054101\n",
    ];
    let mut all = Vec::new();
    for (state, text) in requests.iter().enumerate() {
        for profile in 0..4 {
            let mut seed = vec![state as u8, 1, 0, profile];
            for _ in 0..3 {
                seed.push(7);
                seed.extend(chunk(text.as_bytes()));
                seed.extend([1, 3, 0xE9, 3, 1]);
            }
            all.push(seed);
        }
    }
    all
}
