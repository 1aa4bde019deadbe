//! The laser's twin: any bytes, any faults, any pace, of any model in any state.

use super::feed::{Feed, piece};
use scip::twin::{Fault, FaultSpec, Profile, StartState, Surroundings, Twin, TwinOptions};
use std::time::Duration;

struct Room;

impl Surroundings for Room {
    fn revolve(&mut self, _: Duration, _: Duration, out: &mut [u32]) {
        out.fill(1234);
    }
}

/// Bytes that may wait for a host that does not read (the twin says 1 MiB).
const MOST_WAITING: usize = 1 << 20;
/// Virtual time of a run, so that no input is slow.
const MOST_TIME: Duration = Duration::from_secs(120);

pub fn run(data: &[u8]) {
    let mut feed = Feed(data);
    let mut options = TwinOptions {
        start_state: feed.one_of(&[
            StartState::PowerUp,
            StartState::Idle,
            StartState::LaserOn,
            StartState::Streaming,
            StartState::TimeAdjust,
            StartState::FirmwareUpdate,
        ]),
        seed: u64::from(feed.word()),
        ..TwinOptions::default()
    };
    let name = feed.one_of(&Profile::NAMES);
    options.set_profile(Profile::by_name(name).expect("of the list"));
    let mut twin = Twin::new(options, Duration::ZERO);
    let kinds: Vec<&str> = Fault::kinds().collect();
    let mut now = Duration::ZERO;
    while !feed.is_over() && now < MOST_TIME {
        match feed.byte() % 8 {
            0 => {
                let kind = feed.one_of(&kinds);
                let lasting = f64::from(feed.byte()) / 10.0;
                let spec = format!("{kind}:at={},for={lasting}", now.as_secs_f64());
                twin.inject(spec.parse::<FaultSpec>().expect("a fault"));
            }
            1 => twin.power_cycle(now),
            2 => twin.set_host_baud(u32::from(feed.word())),
            3 | 4 => {
                now += feed.time().min(Duration::from_secs(5));
                twin.advance(now, &mut Room);
            }
            _ => twin.handle_bytes(feed.piece(), now),
        }
        assert!(
            twin.next_event()
                .is_none_or(|at| at + Duration::from_secs(60) >= now)
        );
        if feed.byte() % 4 > 0 {
            let mut waiting = 0;
            while let Some(output) = twin.poll_output() {
                assert!(output.at <= now);
                waiting += output.bytes.len();
            }
            assert!(waiting <= MOST_WAITING, "{waiting} bytes waited");
        }
    }
}

pub fn seeds() -> Vec<Vec<u8>> {
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
                seed.extend(piece(text.as_bytes()));
                seed.extend([1, 3, 0xE9, 3, 1]);
            }
            all.push(seed);
        }
    }
    all
}
