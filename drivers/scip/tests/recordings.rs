//! Bytes that real sensors sent, in any chunking.

mod common;

use common::{SplitMix64, chunks, recording};
use scip::command::ScipRequest;
use scip::command::info::ReadInfo;
use scip::command::parameters::ReadParameters;
use scip::command::span::ScanSpan;
use scip::command::stream::{StreamReply, StreamRequest};
use scip::command::version::ReadVersion;
use scip::{Framer, LaserParameters, LaserScan, ScipMessage, StatusCode, ValueCoding};
use std::time::Duration;

const FULL: StreamRequest = StreamRequest {
    span: ScanSpan {
        first_step: 44,
        last_step: 725,
        cluster: 1,
        coding: ValueCoding::ThreeCharacter,
    },
    interval: 0,
    count: 0,
};

/// The scan of a recorded `GD` reply. The driver asks for scans by `MD` alone, whose replies differ in the echo and the
/// status line only.
fn scan(message: &ScipMessage) -> LaserScan {
    assert_eq!(message.status(), Ok(StatusCode::Code(*b"00")));
    let data: Vec<&[u8]> = message.body().collect();
    let text = [b"MD0044072501000\n99b\n", &*data.join(&b'\n'), b"\n\n"].concat();
    let streamed = messages(&[text]).remove(0);
    match FULL.parse(&streamed).expect("every sum is right") {
        StreamReply::Scan(scan) => scan,
        other => panic!("{other:?}"),
    }
}

fn messages(chunks: &[Vec<u8>]) -> Vec<ScipMessage> {
    let mut framer = Framer::default();
    let mut all = Vec::new();
    for chunk in chunks {
        let mut rest = chunk.as_slice();
        while let Some(message) = framer.take(&mut rest, Duration::ZERO) {
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
fn read_all(messages: &[ScipMessage]) -> Vec<LaserScan> {
    let mut scans = Vec::new();
    for message in messages {
        match message.echo() {
            b"VV" => assert_eq!(ReadVersion.parse(message).expect("VV").serial, "H0706400"),
            b"PP" => assert_eq!(
                ReadParameters.parse(message).expect("PP").parameters,
                LaserParameters::URG_04LX
            ),
            b"II" => assert_eq!(ReadInfo.parse(message).expect("II").laser_on, Some(true)),
            b"BM" => assert_eq!(message.status(), Ok(StatusCode::Code(*b"02"))),
            b"CR00" => assert_eq!(message.status(), Ok(StatusCode::Code(*b"03"))),
            b"GD0044072501" => scans.push(scan(message)),
            other => panic!("unknown message {}", other.escape_ascii()),
        }
    }
    scans
}

/// Whole, byte by byte, and in random chunks: always the same.
fn in_every_chunking(bytes: &[u8]) -> Vec<ScipMessage> {
    let whole = messages(&[bytes.to_vec()]);
    assert_eq!(
        messages(&bytes.iter().map(|byte| vec![*byte]).collect::<Vec<_>>()),
        whole
    );
    for seed in 0..50 {
        let mut rng = SplitMix64(seed);
        assert_eq!(
            messages(&chunks(bytes, 1 + rng.below(200), &mut rng)),
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
    let (codes, distances): (Vec<u32>, Vec<u32>) = scans[0]
        .ranges
        .iter()
        .partition(|value| **value < LaserParameters::URG_04LX.dmin_mm);
    let codes: std::collections::BTreeSet<_> = codes.into_iter().collect();
    assert_eq!(codes.into_iter().collect::<Vec<_>>(), [0, 6, 7]);
    assert_eq!(distances.into_iter().max(), Some(5461));
}
