//! Set-up shared by this crate's integration tests.
#![allow(dead_code, reason = "each test file uses its part")]

pub(crate) mod driver_and_emulator;
pub(crate) mod streaming;

use scip::encoding::{encode, sum};
use scip::{LaserAction, LaserEvent, ScipDriver};
use std::time::Duration;

/// A recording's bytes; `None`, with the reason printed, where the data is absent and not required.
pub(crate) fn recording(name: &str) -> Option<Vec<u8>> {
    let path = patrold_test_support::data(&format!("recordings/{name}"))?;
    Some(std::fs::read(path).expect("readable"))
}

/// Seeded numbers, the same on every machine.
pub(crate) struct SplitMix64(pub u64);

impl SplitMix64 {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }
}

/// Cuts `bytes` in chunks of 1 to `longest`.
pub(crate) fn chunks(bytes: &[u8], longest: usize, rng: &mut SplitMix64) -> Vec<Vec<u8>> {
    let mut rest = bytes;
    let mut all = Vec::new();
    while !rest.is_empty() {
        let (chunk, after) = rest.split_at((1 + rng.below(longest)).min(rest.len()));
        all.push(chunk.to_vec());
        rest = after;
    }
    all
}

/// A line with its sum and LF.
pub(crate) fn summed(body: &str) -> String {
    format!("{body}{}\n", char::from(sum(body.as_bytes())))
}

/// A scan message as a device sends it.
pub(crate) fn scan_message(echo: &str, status: &str, stamp_ms: u32, ranges: &[u32]) -> Vec<u8> {
    let mut text = format!("{echo}\n{}", summed(status));
    let stamp = encode::<4>(stamp_ms).expect("24 bits");
    text += &summed(std::str::from_utf8(&stamp).expect("ASCII"));
    let characters: Vec<u8> = ranges
        .iter()
        .flat_map(|range| encode::<3>(*range).expect("18 bits"))
        .collect();
    for piece in characters.chunks(64) {
        text += &summed(std::str::from_utf8(piece).expect("ASCII"));
    }
    text.push('\n');
    text.into_bytes()
}

pub(crate) const VV: &str = "VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX;[\n\
    FIRM:3.1.04(02/Aug./2007);a\nPROT:SCIP 2.0;N\nSERI:H0706400;F\n\n";
pub(crate) const PP: &str = "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\n\
    AMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";
pub(crate) const II: &str = "II\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nLASR:OFF;7\n\
    SCSP:Initial(600[rpm])<-Default setting by user;A\nMESM:IDLE;:\nSBPS:19200[bps]<-Default setting by user;A\n\
    TIME:001957;O\nSTAT:Sensor works well.;8\n\n";

/// Drains all actions: what was sent, as text, and the events.
pub(crate) fn drain(driver: &mut ScipDriver) -> (Vec<String>, Vec<LaserEvent>) {
    let (mut sent, mut events) = (Vec::new(), Vec::new());
    while let Some(action) = driver.poll_action() {
        match action {
            LaserAction::Send(bytes) => {
                sent.push(String::from_utf8(bytes).expect("requests are ASCII"))
            }
            LaserAction::SetBitRate(bit_s) => sent.push(format!("rate {bit_s}")),
            LaserAction::Event(event) => events.push(event),
        }
    }
    (sent, events)
}

/// The driver against scripted replies.
pub(crate) struct ScriptedLaser {
    pub driver: ScipDriver,
    pub now: Duration,
    pub events: Vec<LaserEvent>,
}

impl ScriptedLaser {
    pub(crate) fn new(driver: ScipDriver) -> Self {
        Self {
            driver,
            now: Duration::ZERO,
            events: Vec::new(),
        }
    }

    /// The driver must have sent exactly this since the last check.
    pub(crate) fn expect_sent(&mut self, expected: &[&str]) {
        let (sent, events) = drain(&mut self.driver);
        self.events.extend(events);
        assert_eq!(
            sent, expected,
            "at {:?}, events {:?}",
            self.now, self.events
        );
    }

    /// The device answers, byte by byte, a millisecond each tenth byte.
    pub(crate) fn reply(&mut self, bytes: impl AsRef<[u8]>) {
        for (index, byte) in bytes.as_ref().iter().enumerate() {
            if index % 10 == 9 {
                self.now += Duration::from_millis(1);
            }
            self.driver.handle_bytes(&[*byte], self.now);
        }
    }

    /// Request and reply.
    pub(crate) fn exchange(&mut self, expected: &str, reply: impl AsRef<[u8]>) {
        self.expect_sent(&[expected]);
        self.now += Duration::from_millis(95);
        self.reply(reply);
    }

    /// No reply: time advances to the deadline.
    pub(crate) fn time_out(&mut self) {
        self.now = self
            .driver
            .deadline()
            .expect("something is waited for")
            .max(self.now);
        self.driver.handle_deadline(self.now);
    }

    /// The events so far, and clears them.
    pub(crate) fn take_events(&mut self) -> Vec<LaserEvent> {
        self.expect_sent(&[]);
        std::mem::take(&mut self.events)
    }

    /// From `RS` to connected.
    pub(crate) fn identify(&mut self) {
        self.exchange("RS\n", "RS\n00P\n\n");
        self.exchange("VV\n", VV);
        self.exchange("PP\n", PP);
        self.exchange("II\n", II);
        let events = self.take_events();
        assert!(
            matches!(events.last(), Some(LaserEvent::Connected(_))),
            "{events:?}"
        );
    }

    /// A connected driver, by the shortest dialogue.
    pub(crate) fn connected(driver: ScipDriver) -> Self {
        let mut script = Self::new(driver);
        script.driver.connect(script.now);
        script.exchange("QT\n", "QT\n00P\n\n");
        script.identify();
        script
    }
}
