//! Arbitrary input.

use proptest::prelude::*;

use super::*;
use crate::emulator::LaserFault;

/// Bytes that are often nearly a request.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let token = prop_oneof![
        prop::sample::select(vec![
            &b"VV"[..],
            b"PP",
            b"II",
            b"BM",
            b"QT",
            b"RS",
            b"TM0",
            b"TM1",
            b"TM2",
            b"SS115200",
            b"CR05",
            b"HS1",
            b"DB04",
            b"GD0044072501",
            b"GS0000076805",
            b"MD0044072501000",
            b"MS0100020003199",
            b"SCIP2.0",
            b"ME0000108001000",
            b"HE0000108003",
            b"NE0000076807199",
            b"RT",
            b"RB\nRB\n",
            b"%ST",
            b"%SL",
            b"V",
            b";tag",
            b"\n",
            b"\n",
            b"\n",
            b"\r",
        ])
        .prop_map(<[u8]>::to_vec),
        prop::collection::vec(any::<u8>(), 0..80),
    ];
    prop::collection::vec(token, 0..60).prop_map(|tokens| tokens.concat())
}

fn options() -> impl Strategy<Value = LaserOptions> {
    let link = prop_oneof![
        Just(LaserLink::Usb),
        Just(LaserLink::Network),
        Just(LaserLink::Serial { baud: 19_200 })
    ];
    let state = prop::sample::select(vec![
        LaserStartState::PowerUp,
        LaserStartState::Idle,
        LaserStartState::LaserOn,
        LaserStartState::Streaming,
        LaserStartState::TimeAdjust,
        LaserStartState::FirmwareUpdate,
    ]);
    let profile = prop::sample::select(LaserProfile::NAMES.to_vec());
    (link, state, profile, any::<u64>()).prop_map(|(link, start_state, profile, seed)| {
        LaserOptions {
            profile: LaserProfile::by_name(profile).expect("a name of the list"),
            link,
            start_state,
            seed,
            ..LaserOptions::default()
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn byte_by_byte_is_the_same_as_whole(options in options(), bytes in bytes()) {
        let mut whole = LaserRig::new(options.clone());
        whole.laser.handle_bytes(&bytes, Duration::ZERO);
        let mut single = LaserRig::new(options);
        for byte in &bytes {
            single.laser.handle_bytes(&[*byte], Duration::ZERO);
        }
        prop_assert_eq!(whole.run(2000 * MS), single.run(2000 * MS));
    }

    #[test]
    fn one_leap_is_the_same_as_many_steps(options in options(), bytes in bytes()) {
        let mut steps = LaserRig::new(options.clone());
        steps.laser.handle_bytes(&bytes, Duration::ZERO);
        let mut leap = LaserRig::new(options);
        leap.laser.handle_bytes(&bytes, Duration::ZERO);
        leap.now = 3000 * MS;
        leap.laser.advance(leap.now, &mut leap.source);
        let leapt: Vec<LaserOutput> = std::iter::from_fn(|| leap.laser.poll_output()).collect();
        let mut stepped = steps.run(2999 * MS);
        stepped.extend(steps.run(MS));
        prop_assert_eq!(stepped, leapt);
    }

    #[test]
    fn nothing_panics_whatever_comes(options in options(), parts in prop::collection::vec((bytes(), 0u64..400), 0..12)) {
        let mut rig = LaserRig::new(options);
        for (index, kind) in LaserFault::kinds().enumerate() {
            rig.inject(&format!("{kind}:at={}", index as f64 * 0.2));
        }
        for (bytes, wait) in parts {
            rig.laser.handle_bytes(&bytes, rig.now);
            for output in rig.run(wait as u32 * MS) {
                prop_assert!(output.bytes.len() <= 1460);
            }
        }
    }
}

#[test]
fn a_flood_without_end_costs_bounded_memory() {
    let mut rig = LaserRig::new(exact(LaserStartState::Streaming));
    let flood: Vec<u8> = (0..1 << 16)
        .map(|index: u32| (index.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    for _ in 0..200 {
        rig.laser.handle_bytes(&flood, rig.now);
        rig.now += 10 * MS;
        rig.laser.advance(rig.now, &mut rig.source);
    }
    assert!(rig.laser.lost_replies() > 0);
    rig.laser
        .advance(rig.now + Duration::from_secs(3600), &mut rig.source);
    let waiting: usize = std::iter::from_fn(|| rig.laser.poll_output())
        .map(|output| output.bytes.len())
        .sum();
    assert!(waiting <= 1 << 20, "{waiting}");
}
