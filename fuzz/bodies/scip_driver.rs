//! The laser's driver alone: any bytes at any instant, any request at any time.

use super::feed::{Feed, piece};
use super::scip_sums::Heard;
use scip::command::span::Span;
use scip::{Action, Coding, Event, Framer, Sensor, SensorOptions, StreamPlan};
use std::time::Duration;

/// Outputs that one input may cause: a scan has a handful, a piece of 255 bytes some 60 messages at most.
const MOST_ACTIONS: usize = 512;

pub fn run(data: &[u8]) {
    scans(data);
}

/// Runs, and tells how many scans came of it.
pub fn scans(data: &[u8]) -> usize {
    let mut scans = 0;
    let mut framer = Framer::default();
    let mut rest = data;
    while framer.take(&mut rest, Duration::ZERO).is_some() {}
    assert!(framer.held_bytes() <= scip::constants::MAX_MESSAGE_BYTES);

    let mut feed = Feed(data);
    let mut sensor = Sensor::new(SensorOptions::default());
    let mut heard = Heard::default();
    let mut now = Duration::ZERO;
    sensor.connect(now);
    scans += drain(&mut sensor, &heard);
    while !feed.is_over() {
        match feed.byte() % 16 {
            0 => sensor.connect(now),
            1 => drop(sensor.exchange_time(u32::from(feed.byte()), now)),
            2 => drop(sensor.start_streaming(plan(&mut feed), now)),
            3 => sensor.stop(now),
            4 => drop(sensor.query_info(now)),
            5 => drop(sensor.single(span(&mut feed), now)),
            6 | 7 => {
                now += feed.time();
                sensor.handle_deadline(now);
            }
            8 => {
                now = sensor.deadline().unwrap_or(now).max(now);
                sensor.handle_deadline(now);
            }
            _ => {
                let bytes = feed.piece();
                heard.add(bytes);
                sensor.handle_bytes(bytes, now);
            }
        }
        scans += drain(&mut sensor, &heard);
    }
    scans
}

fn drain(sensor: &mut Sensor, heard: &Heard) -> usize {
    let mut scans = 0;
    for _ in 0..MOST_ACTIONS {
        match sensor.poll_action() {
            None => return scans,
            Some(Action::Event(Event::Scan { scan, .. })) => {
                heard.must_hold(&scan);
                scans += 1;
            }
            Some(_) => {}
        }
    }
    panic!("outputs without end");
}

fn span(feed: &mut Feed<'_>) -> Span {
    let first_step = feed.word() % 1100;
    Span {
        first_step,
        last_step: first_step + u16::from(feed.byte()),
        cluster: feed.byte() % 4,
        coding: feed.one_of(&[
            Coding::ThreeCharacter,
            Coding::TwoCharacter,
            Coding::WithIntensity,
        ]),
    }
}

fn plan(feed: &mut Feed<'_>) -> StreamPlan {
    let span = span(feed);
    StreamPlan {
        first_step: span.first_step,
        last_step: span.last_step,
        cluster: span.cluster,
        coding: span.coding,
        interval: feed.byte() % 11,
        count: feed.byte() % 101,
    }
}

pub fn seeds() -> Vec<Vec<u8>> {
    let say = |text: &str| {
        let mut op = vec![15];
        op.extend(piece(text.as_bytes()));
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
    let connected: Vec<u8> = identity.iter().flat_map(|text| say(text)).collect();
    // Steps 44 and 45, no cluster, three characters, every turn, no count.
    let streaming = [&connected[..], &[2, 44, 0, 1, 1, 0, 0, 0]].concat();
    let scan = "MD0044004501000\n99b\nJUGnD\n1Dh06E8\n\n";
    vec![
        say("QT\nE\n\nSCIP2.0\n0\n\n"),
        connected,
        [
            streaming,
            say("MD0044004501000\n00P\n\n"),
            say(scan),
            say(scan),
        ]
        .concat(),
    ]
}
