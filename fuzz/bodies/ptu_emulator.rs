//! The emulated head alone: any bytes, faults, options and pauses.

use super::choices::{Choices, chunk};
use ptu::emulator::{EmulatedHead, HeadFaultKind, HeadFaultSpec, HeadOptions, LineEnd};
use std::time::Duration;

/// Bytes that may wait for a host that does not read: the size of the emulator's output buffer.
const MAX_WAITING: usize = 65_536;
/// Virtual time of a run, so that no input is slow.
const MAX_TIME: Duration = Duration::from_secs(300);

pub(crate) fn run(data: &[u8]) {
    let mut choices = Choices(data);
    let flags = choices.byte();
    let flag = |bit: u8| flags & (1 << bit) != 0;
    let mut options = HeadOptions {
        seed: u64::from(choices.byte()),
        power_up: flag(0),
        e_series: flag(1),
        axis_reset_at_once: flag(1),
        byte_pacing: flag(2),
        option_board: flag(3),
        line_end: if flag(4) { LineEnd::Cr } else { LineEnd::CrLf },
        ..HeadOptions::default()
    };
    options.start.velocity_mode = flag(5);
    options.start.slaved = flag(6);
    options.start.monitor = flag(7);
    let mut head = EmulatedHead::new(options, Duration::ZERO);
    let kinds: Vec<&str> = HeadFaultKind::kinds().collect();
    let mut now = Duration::ZERO;
    while !choices.is_over() && now < MAX_TIME {
        match choices.byte() % 8 {
            0 => {
                let kind = choices.one_of(&kinds);
                let duration = f64::from(choices.byte()) / 10.0;
                let spec = format!("{kind}:at={},for={duration}", now.as_secs_f64());
                head.inject(spec.parse::<HeadFaultSpec>().expect("a fault"));
            }
            1 => head.power_cycle(now),
            2 => head.set_host_baud((choices.byte() & 1 == 1).then_some(u32::from(choices.u16()))),
            3 | 4 => now += choices.duration().min(Duration::from_secs(10)),
            _ => head.handle_bytes(choices.chunk(), now),
        }
        head.advance(now);
        assert!(head.next_event().is_none_or(|at| at >= now));
        // The stops lie 12 counts beyond the limits; a count of rounding, and of full steps.
        let (pan, tilt) = head.true_position_at(now);
        assert!(
            pan.abs() <= 3104.0 && (-921.0..=618.0).contains(&tilt),
            "{pan} {tilt}"
        );
        if choices.byte() % 4 > 0 {
            let mut waiting = 0;
            while let Some(output) = head.poll_output() {
                assert!(output.at <= now);
                waiting += output.bytes.len();
            }
            assert!(waiting <= MAX_WAITING, "{waiting} bytes waited");
        }
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let requests = [
        "ED FT CI I LE E F C L V O U ",
        "PP100 TP-50 A PP TP PO-7 TD PS97 PD500 H ",
        "PR TR PN PX PU PL PA3000 TB500 PU1500 PHL TMR ",
        "CV PS-300 TS0 LD CI S PP1 TP2 A I M-10,10 ",
        "R RT RE DS DF WPE WTF R @(19200,3,F) _5 U3 _0 XS1 XG1 XC1 ",
        "B1,2,300,400 BT LU PNU-100 IQ MQ ME ? JE @A ",
    ];
    let mut all = Vec::new();
    for (index, text) in requests.iter().enumerate() {
        for flags in [0, 2, 0x25, 0xC4] {
            let mut seed = vec![flags, index as u8];
            for _ in 0..2 {
                seed.push(7);
                seed.extend(chunk(text.as_bytes()));
                seed.extend([1, 3, 0x41, 0x1F, 1]);
            }
            all.push(seed);
        }
    }
    all
}
