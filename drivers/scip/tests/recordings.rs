//! Bytes that real sensors sent, in any chunking.

mod common;

use common::{Dice, chunks, recording};
use scip::command::Request;
use scip::command::info::ReadInfo;
use scip::command::laser::LaserOn;
use scip::command::motor_speed::SetMotorSpeed;
use scip::command::parameters::ReadParameters;
use scip::command::single::MeasureOnce;
use scip::command::span::Span;
use scip::command::version::ReadVersion;
use scip::{Coding, Framer, Instant, Message, Parameters, RawScan, Reading};

const FULL: Span = Span {
    first_step: 44,
    last_step: 725,
    cluster: 1,
    coding: Coding::ThreeCharacter,
};

fn messages(chunks: &[Vec<u8>]) -> Vec<Message> {
    let mut framer = Framer::default();
    let mut all = Vec::new();
    for chunk in chunks {
        let mut rest = chunk.as_slice();
        while let Some(message) = framer.take(&mut rest, Instant::ZERO) {
            all.push(message);
        }
    }
    assert_eq!(
        (framer.held_bytes(), framer.overruns()),
        (0, 0),
        "nothing is left over"
    );
    all
}

/// Every message read by the request it answers; the scans among them. Every sum must be right.
fn read_all(messages: &[Message]) -> Vec<RawScan> {
    let mut scans = Vec::new();
    for message in messages {
        match message.echo() {
            b"VV" => assert_eq!(ReadVersion.parse(message).expect("VV").serial, "H0706400"),
            b"PP" => assert_eq!(
                ReadParameters.parse(message).expect("PP").parameters,
                Parameters::URG_04LX
            ),
            b"II" => assert_eq!(ReadInfo.parse(message).expect("II").laser_on, Some(true)),
            b"BM" => LaserOn.parse(message).expect("BM 02 is already on"),
            b"CR00" => SetMotorSpeed::Default
                .parse(message)
                .expect("CR 03 is already so"),
            b"GD0044072501" => scans.push(MeasureOnce(FULL).parse(message).expect("GD")),
            other => panic!("unknown message {}", other.escape_ascii()),
        }
    }
    scans
}

/// Whole, byte by byte, and in random chunks: always the same.
fn in_every_chunking(bytes: &[u8]) -> Vec<Message> {
    let whole = messages(&[bytes.to_vec()]);
    assert_eq!(
        messages(&bytes.iter().map(|byte| vec![*byte]).collect::<Vec<_>>()),
        whole
    );
    for seed in 0..50 {
        let mut dice = Dice(seed);
        assert_eq!(
            messages(&chunks(bytes, 1 + dice.below(200), &mut dice)),
            whole,
            "seed {seed}"
        );
    }
    whole
}

#[test]
fn a_session_of_a_urg_04lx() {
    let Some(bytes) = recording("urg04lx_fw3104_session.rx.bin") else {
        return;
    };
    let messages = in_every_chunking(&bytes);
    let echoes: Vec<_> = messages
        .iter()
        .map(|message| String::from_utf8_lossy(message.echo()))
        .collect();
    assert_eq!(
        echoes,
        [
            "VV",
            "VV",
            "PP",
            "II",
            "BM",
            "CR00",
            "VV",
            "PP",
            "II",
            "GD0044072501"
        ]
    );

    let scans = read_all(&messages);
    assert_eq!(scans.len(), 1);
    assert_eq!((scans[0].ranges.len(), scans[0].stamp_ms), (682, 6_968_830));
    // The data begin 068 068 067 061 05m 05m: 6 * 64 + 8, and so on.
    assert_eq!(scans[0].ranges[..6], [392, 392, 391, 385, 381, 381]);
}

#[test]
fn one_scan_of_a_ug01() {
    let Some(bytes) = recording("urg04lx_ug01_gd.rx.bin") else {
        return;
    };
    assert_eq!(bytes.len(), 2134);
    let messages = in_every_chunking(&bytes);
    assert_eq!(messages.len(), 1);
    let scans = read_all(&messages);
    assert_eq!(scans[0].ranges.len(), 682);
    let readings: Vec<_> = scans[0].readings(&Parameters::URG_04LX).collect();
    let codes: std::collections::BTreeSet<_> = readings
        .iter()
        .filter_map(|reading| match reading {
            Reading::Code(code) => Some(*code),
            Reading::Range(_) | Reading::Beyond => None,
        })
        .collect();
    assert_eq!(codes.into_iter().collect::<Vec<_>>(), [0, 6, 7]);
    let farthest = readings.iter().filter_map(|reading| match reading {
        Reading::Range(range_mm) => Some(*range_mm),
        Reading::Code(_) | Reading::Beyond => None,
    });
    assert_eq!(farthest.max(), Some(5461));
}
