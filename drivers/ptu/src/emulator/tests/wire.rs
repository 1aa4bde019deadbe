//! Framing, echo, timing, and random input.

use std::time::Duration;

use proptest::prelude::*;

use super::{Host, options, seconds};
use crate::emulator::constants::{MAX_INPUT_BYTES, MAX_OUTPUT_BYTES};
use crate::emulator::{EmulatedHead, HeadOptions, LineEnd};

#[test]
fn echo_as_recorded() {
    let mut o = options();
    o.start.echo = true;
    let mut host = Host::new(o.clone());
    assert_eq!(host.ask("PP "), "PP * 0\r\n");
    assert_eq!(host.ask("PP\r"), "PP\r\n* 0\r\n");
    assert_eq!(host.ask("PP TP\r\n"), "PP * 0\r\nTP\r\n* 0\r\n");
    assert_eq!(host.ask("PP\n"), "PP\r\n* 0\r\n");
    assert_eq!(host.ask("   "), "   ", "empty commands have no reply");
    assert_eq!(host.ask("ED FT I CI "), "ED *\r\n*\r\n*\r\n*\r\n");
    assert_eq!(host.ask("  \r\n "), "");
    let mut host = Host::new(HeadOptions {
        line_end: LineEnd::Cr,
        ..o
    });
    assert_eq!(host.ask("PP\r\n"), "PP\r* 0\r");
}

#[test]
fn bytes_take_their_time() {
    let mut host = Host::new(HeadOptions {
        byte_pacing: true,
        latency: [seconds(0.002); 2],
        ..options()
    });
    host.send("PP ");
    let mut times = Vec::new();
    while let Some(at) = host.head.next_event() {
        host.head.advance(at);
        while let Some(output) = host.head.poll_output() {
            assert_eq!(output.bytes.len(), 1);
            times.push(output.at.as_secs_f64());
        }
    }
    // 3 bytes in, 2 ms, 5 bytes out.
    let byte = 10.0 / 9600.0;
    assert_eq!(times.len(), 5);
    assert!(
        (times[0] - (4.0 * byte + 0.002)).abs() < 1e-6
            && (times[4] - (8.0 * byte + 0.002)).abs() < 1e-6,
        "{times:?}"
    );
}

#[test]
fn another_line_speed_than_the_hosts_is_garbage() {
    let mut host = Host::new(HeadOptions {
        byte_pacing: true,
        ..options()
    });
    host.head.set_host_baud(Some(9600));
    assert_eq!(host.ask("@(19200,0,F) "), "*\r\n");
    assert_eq!(host.head.baud(), 19200);
    assert_ne!(host.ask("PP "), "* 0\r\n");
    host.head.set_host_baud(Some(19200));
    host.ask(" ");
    assert_eq!(host.ask("PP "), "* 0\r\n");
    host.head.power_cycle(host.now);
    host.wait(60.0);
    assert_eq!(host.head.baud(), 9600, "not kept with F");
}

/// What was printed and when, and where the head pointed at the end.
type Conversation = (Vec<(Duration, Vec<u8>)>, (f64, f64));

fn conversation(seed: u64, bytes: &[u8], chunk_size: usize) -> Conversation {
    let mut head = EmulatedHead::new(
        HeadOptions {
            seed,
            byte_pacing: true,
            ..HeadOptions::default()
        },
        Duration::ZERO,
    );
    for chunk in bytes.chunks(chunk_size) {
        head.handle_bytes(chunk, Duration::ZERO);
    }
    head.advance(seconds(100.0));
    let outputs = std::iter::from_fn(|| head.poll_output())
        .map(|o| (o.at, o.bytes))
        .collect();
    (outputs, head.true_position_at(seconds(99.0)))
}

#[test]
fn byte_by_byte_equals_whole() {
    let text = b"ED FT PP100 TP-50 A PP TP\r\nXYZ PS97 PP0\rH PP R PN ";
    let whole = conversation(3, text, text.len());
    assert_eq!(whole, conversation(3, text, 1));
    assert_eq!(whole, conversation(3, text, 7));
    assert!(whole.0.len() > 30);
}

#[test]
fn overlong_commands_are_illegal_once() {
    let mut host = Host::new(options());
    assert_eq!(host.ask(&("P".repeat(500) + " ")), "! Illegal command\r\n");
    assert_eq!(host.ask("PP "), "* 0\r\n");
}

#[test]
fn floods_stay_bounded() {
    let mut head = EmulatedHead::new(
        HeadOptions {
            latency: [seconds(0.0); 2],
            ..options()
        },
        Duration::ZERO,
    );
    for i in 0..2000_u64 {
        let now = Duration::from_millis(i);
        head.handle_bytes(b"TP1 V TP0 PP-9 PS97 PS1000 V ED EE H PP9 ? V ", now);
        let (rx, tx, past) = head.queue_lengths();
        assert!(
            rx <= MAX_INPUT_BYTES && tx <= MAX_OUTPUT_BYTES && past <= 2 * 8192,
            "{rx} {tx} {past}"
        );
    }
    head.handle_bytes(&[b'A'; 1_000_000], Duration::from_secs(3));
    assert!(head.queue_lengths().0 <= MAX_INPUT_BYTES);
}

fn fragment() -> impl Strategy<Value = Vec<u8>> {
    let word = prop::sample::select(vec![
        "PP",
        "TP",
        "PO",
        "PS",
        "PD",
        "PA",
        "PB",
        "PU",
        "PL",
        "PR",
        "R",
        "RE",
        "RD",
        "A",
        "S",
        "I",
        "H",
        "M",
        "ME",
        "CV",
        "CI",
        "LD",
        "LE",
        "DS",
        "DR",
        "DF",
        "WPE",
        "WPF",
        "XS",
        "XG",
        "U",
        "_",
        "EE",
        "FV",
        "@(600,9,T)",
        "V",
        "O",
        "B",
        "LU",
        "PNU",
    ]);
    prop_oneof![
        4 => (word, prop::option::of(-40_000..40_000_i32)).prop_map(|(w, n)| {
            format!("{w}{} ", n.map(|n| n.to_string()).unwrap_or_default()).into_bytes()
        }),
        1 => prop::collection::vec(any::<u8>(), 0..20),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]
    #[test]
    fn hostile_input_never_breaks_it(
        fragments in prop::collection::vec((fragment(), 0..2_000_u64), 1..60),
        faults in prop::collection::vec(prop::sample::select(vec![
            "lost-steps:steps=-500,count=3", "stuck:for=1", "stuck:hidden=true,for=2", "slow:at=1,for=3", "silence:at=2,for=1",
            "power-cycle:at=3,for=1", "wrong-baud:at=1,for=1", "reset-fails", "event:which=P,count=5", "lost-byte:count=9",
        ]), 0..4),
        seed in any::<u64>(), e_series in any::<bool>(), power_up in any::<bool>(),
    ) {
        let base = HeadOptions { seed, e_series, axis_reset_at_once: e_series, power_up, ..HeadOptions::default() };
        let mut head = EmulatedHead::new(base, Duration::ZERO);
        for fault in faults {
            head.inject(fault.parse().expect("valid"));
        }
        let mut now = Duration::ZERO;
        let mut last = Duration::ZERO;
        for (bytes, pause) in fragments {
            head.handle_bytes(&bytes, now);
            now += Duration::from_millis(pause);
            head.advance(now);
            while let Some(output) = head.poll_output() {
                prop_assert!(output.at >= last && output.at <= now);
                last = output.at;
            }
            let (pan, tilt) = head.true_position_at(now);
            // Half a count of rounding, and full steps are two half steps.
            prop_assert!(pan.abs() <= 3104.0 && (-921.0..=618.0).contains(&tilt), "{} {}", pan, tilt);
            prop_assert!(head.next_event().is_none_or(|at| at >= now));
        }
    }
}
