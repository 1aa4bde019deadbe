//! scip2 section 12, byte for byte.

use super::*;

/// `|` stands for a line feed.
fn lines(text: &str) -> String {
    text.replace('|', "\n")
}

const MODEL: &str = "MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N";

#[test]
fn starting_in_scip1() {
    let mut rig = LaserRig::new(exact(LaserStartState::PowerUp));
    assert_eq!(
        rig.ask("V"),
        lines(
            "V|0|VEND:Hokuyo Automatic Co.,Ltd.|PROD:SOKUIKI Sensor URG-04LX|\
             FIRM:3.1.04,07/08/02(20-4095[mm],240[deg],44-725[step],600[rpm])|PROT:00003,(SCIP 1.0)|SERI:H0706400|\
             STAT:FW Normal[FinalDist with shadow  ]||"
        )
    );
    assert_eq!(rig.ask("QT"), "QT\nE\n\n");
    assert_eq!(rig.ask("VV;x"), "VV;x\nE\n\n");
    assert_eq!(rig.ask("SCIP2.0"), "SCIP2.0\n0\n\n");
    assert_eq!(rig.ask("SCIP2.0"), "SCIP2.0\n0Ee\n\n");
    assert_eq!(rig.ask("QT"), "QT\n00P\n\n");
}

#[test]
fn identity_of_firmware_3_1_04() {
    let mut rig = LaserRig::idle();
    assert_eq!(
        rig.ask("VV"),
        lines(
            "VV|00P|VEND:Hokuyo Automatic Co.,Ltd.;[|PROD:SOKUIKI Sensor URG-04LX;[|FIRM:3.1.04(02/Aug./2007);a|\
             PROT:SCIP 2.0;N|SERI:H0706400;F||"
        )
    );
    assert_eq!(
        rig.ask("PP"),
        lines(&format!(
            "PP|00P|{MODEL}|DMIN:20;4|DMAX:5600;_|ARES:1024;\\|AMIN:44;7|AMAX:725;o|AFRT:384;6|SCAN:600;e||"
        ))
    );
    assert_eq!(rig.ask("CR00"), "CR00\n03S\n\n");
    assert_eq!(rig.ask("HS0"), "HS0\n0Cc\n\n");
}

#[test]
fn identity_of_a_ug01() {
    let mut rig = LaserRig::ug01();
    assert_eq!(rig.ask("SCIP2.0"), "SCIP2.0\n0Ee\n\n");
    assert_eq!(
        rig.ask("VV"),
        lines(
            "VV|00P|VEND:Hokuyo Automatic Co.,Ltd.;[|PROD:SOKUIKI Sensor URG-04LX-UG01(Simple-URG);[|\
             FIRM:3.4.03(17/Dec./2012);T|PROT:SCIP 2.0;N|SERI:H1510998;V||"
        )
    );
}

/// The tick comes 94 ms after power-up.
fn with_timer_at_first_tick(timer: u32, start_state: LaserStartState) -> LaserRig {
    LaserRig::new(LaserOptions {
        timer_start_ms: timer - 94,
        ..exact(start_state)
    })
}

#[test]
fn conditions() {
    let tail = "SCSP:Initial(600[rpm])<-Default setting by user;A";
    let rate = "SBPS:19200[bps]<-Default setting by user;A";
    let mut off = with_timer_at_first_tick(0x1957, LaserStartState::Idle);
    assert_eq!(
        off.ask("II"),
        lines(&format!(
            "II|00P|{MODEL}|LASR:OFF;7|{tail}|MESM:IDLE;:|{rate}|TIME:001957;O|STAT:Sensor works well.;8||"
        ))
    );
    let mut on = with_timer_at_first_tick(0x1E12, LaserStartState::LaserOn);
    assert_eq!(
        on.ask("II"),
        lines(&format!(
            "II|00P|{MODEL}|LASR:ON;9|{tail}|MESM:CLASSIC;^|{rate}|TIME:001E12;R|STAT:Sensor works well.;8||"
        ))
    );
}

#[test]
fn laser() {
    let mut rig = LaserRig::idle();
    assert_eq!(rig.ask("BM"), "BM\n00P\n\n");
    assert_eq!(rig.ask("BM"), "BM\n02R\n\n");
    assert!(rig.laser.laser_on());
    assert_eq!(rig.ask("QT;bye"), "QT;bye\n00P\n\n");
    assert!(!rig.laser.laser_on());
}

#[test]
fn one_scan() {
    let options = LaserOptions {
        timer_start_ms: 6_968_830,
        ..exact(LaserStartState::LaserOn)
    };
    let mut rig = LaserRig::new(options);
    let reply = rig.ask("GD0044072501");
    assert_eq!(reply.len(), 2134);
    // 1234 is 0CB. 64 characters are 21 values and one character, so three kinds of full line take turns.
    let values = "0CB".repeat(682);
    let mut expected = "GD0044072501\n00P\nJUGnD\n".to_owned();
    for line in values.as_bytes().chunks(64) {
        let total: u32 = line.iter().map(|byte| u32::from(*byte)).sum();
        expected.push_str(std::str::from_utf8(line).expect("printable"));
        expected.push((b'0' + (total % 64) as u8) as char);
        expected.push('\n');
    }
    expected.push('\n');
    assert_eq!(reply, expected);
    let lengths: Vec<usize> = reply.lines().map(str::len).collect();
    assert_eq!(lengths[..3], [12, 3, 5]);
    assert!(lengths[3..34].iter().all(|length| *length == 65));
    assert_eq!(lengths[34..], [63, 0]);
}

#[test]
fn time_adjustment() {
    // <Sfk is 13 511 611; the exchange takes the time 0.5 ms after the command.
    let mut rig = LaserRig::new(LaserOptions {
        timer_start_ms: super::decode("<Sfk"),
        ..exact(LaserStartState::TimeAdjust)
    });
    assert_eq!(rig.ask("TM1"), "TM1\n00P\n<SfkP\n\n");
    assert_eq!(rig.ask("TM2"), "TM2\n00P\n\n");
    assert_eq!(rig.ask("TM0"), "TM0\n00P\n\n");
}

/// The II of a laser that is on and the scan after it, as log L2 has them: 6A55F8, then JUGn = 6A55FE.
#[test]
fn the_timer_of_ii_and_the_stamp_of_the_scan_after_it() {
    let mut rig = LaserRig::new(LaserOptions {
        timer_start_ms: 0x6A_55F8 - 94,
        ..exact(LaserStartState::LaserOn)
    });
    assert!(rig.ask("II").contains("\nTIME:6A55F8;8\n"));
    assert!(
        rig.ask("GD0044072501")
            .starts_with("GD0044072501\n00P\nJUGnD\n")
    );
}
