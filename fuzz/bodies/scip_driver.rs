//! The laser's driver alone: any bytes at any time, any request at any time.

use super::choices::{Choices, chunk};
use super::scip_sums::ReceivedBytes;
use scip::{Framer, LaserAction, LaserEvent, ScipDriver, ScipOptions, StreamPlan, ValueCoding};
use std::time::Duration;

/// Outputs of one input: a scan has a handful, a chunk of 255 bytes at most some 60 messages.
const MAX_ACTIONS: usize = 512;

pub(crate) fn run(data: &[u8]) {
    scans(data);
}

/// Returns the number of scans.
pub(crate) fn scans(data: &[u8]) -> usize {
    let mut scans = 0;
    let mut framer = Framer::default();
    let mut rest = data;
    while framer.take(&mut rest, Duration::ZERO).is_some() {}
    assert!(framer.held_bytes() <= scip::constants::MAX_MESSAGE_BYTES);

    let mut choices = Choices(data);
    let mut driver = ScipDriver::new(ScipOptions::default());
    let mut received = ReceivedBytes::default();
    let mut now = Duration::ZERO;
    driver.connect(now);
    scans += drain(&mut driver, &received);
    while !choices.is_over() {
        match choices.byte() % 16 {
            0 => driver.connect(now),
            1 => drop(driver.exchange_time(u32::from(choices.byte()), now)),
            2 => drop(driver.start_streaming(plan(&mut choices), now)),
            3 => driver.stop(now),
            6 | 7 => {
                now += choices.duration();
                driver.handle_deadline(now);
            }
            8 => {
                now = driver.deadline().unwrap_or(now).max(now);
                driver.handle_deadline(now);
            }
            _ => {
                let bytes = choices.chunk();
                received.add(bytes);
                driver.handle_bytes(bytes, now);
            }
        }
        scans += drain(&mut driver, &received);
    }
    scans
}

fn drain(driver: &mut ScipDriver, received: &ReceivedBytes) -> usize {
    let mut scans = 0;
    for _ in 0..MAX_ACTIONS {
        match driver.poll_action() {
            None => return scans,
            Some(LaserAction::Event(LaserEvent::Scan { scan, .. })) => {
                received.assert_contains(&scan);
                scans += 1;
            }
            Some(_) => {}
        }
    }
    panic!("outputs without end");
}

fn plan(choices: &mut Choices<'_>) -> StreamPlan {
    let first_step = choices.u16() % 1100;
    StreamPlan {
        first_step,
        last_step: first_step + u16::from(choices.byte()),
        cluster: choices.byte() % 4,
        coding: choices.one_of(&[
            ValueCoding::ThreeCharacter,
            ValueCoding::TwoCharacter,
            ValueCoding::WithIntensity,
        ]),
        interval: choices.byte() % 11,
        count: choices.byte() % 101,
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let receive = |text: &str| {
        let mut op = vec![15];
        op.extend(chunk(text.as_bytes()));
        op
    };
    let identity = [
        "QT\n00P\n\n",
        "RS\n00P\n\n",
        "VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX;[\n\
         FIRM:3.1.04(02/Aug./2007);a\nPROT:SCIP 2.0;N\nSERI:H0706400;F\n\n",
        "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\n\
         AMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n",
        "II\n00P\nLASR:OFF;7\nMESM:IDLE;:\nTIME:001957;O\nSTAT:Sensor works well.;8\n\n",
    ];
    let connected: Vec<u8> = identity.iter().flat_map(|text| receive(text)).collect();
    // Steps 44 and 45, no cluster, three characters, every revolution, no count.
    let streaming = [&connected[..], &[2, 44, 0, 1, 1, 0, 0, 0]].concat();
    let scan = "MD0044004501000\n99b\nJUGnD\n1Dh06E8\n\n";
    vec![
        receive("QT\nE\n\nSCIP2.0\n0\n\n"),
        connected,
        [
            streaming,
            receive("MD0044004501000\n00P\n\n"),
            receive(scan),
            receive(scan),
        ]
        .concat(),
    ]
}
