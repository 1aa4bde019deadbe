//! Test rig of the dialogue tests: scripted replies, fed byte by byte, in virtual time.

use std::time::Duration;

use crate::{PtuAction, PtuDriver, PtuEvent, PtuOptions};

pub(crate) const BYTE_TIME: Duration = Duration::from_micros(1042);

/// Replies in the forms of ptu-d46 section 3, with echo and feedback mode; without motion.
pub(crate) struct ScriptedReplies {
    pub(crate) echo: bool,
    pub(crate) verbose: bool,
    pub(crate) line_end: &'static str,
    /// Commands with another reply than the usual one, given without its line end.
    pub(crate) overrides: Vec<(&'static str, &'static str)>,
}

impl Default for ScriptedReplies {
    fn default() -> Self {
        Self {
            echo: true,
            verbose: true,
            line_end: "\r\n",
            overrides: Vec::new(),
        }
    }
}

impl ScriptedReplies {
    pub(crate) fn answer(&mut self, command: &str) -> String {
        if let Some((_, reply)) = self.overrides.iter().find(|(c, _)| *c == command) {
            return format!("{reply}{}", self.line_end);
        }
        let echo = if self.echo {
            format!("{command} ")
        } else {
            String::new()
        };
        let numeric = |terse: &str, verbose: &str| {
            if self.verbose {
                verbose.to_owned()
            } else {
                format!(" {terse}")
            }
        };
        let body = match command {
            "ED" => {
                self.echo = false;
                String::new()
            }
            "FT" => {
                self.verbose = false;
                String::new()
            }
            "V" => {
                " Pan-Tilt Controller v2.12.1d1(C14/E), (C)2003 Directed Perception, Inc.".into()
            }
            "CI" | "I" | "LE" | "H" | "PHL" | "THL" => String::new(),
            "E" => " Echoing OFF".into(),
            "F" => " ASCII terse mode".into(),
            "C" => " independent (default) speed control mode".into(),
            "L" => " Limit bounds are ENABLED (soft limits enabled)".into(),
            "PR" | "TR" => numeric("185.1428", " 185.1428 seconds arc per Pan position"),
            "PN" => numeric("-3090", " Minimum Pan position is -3090"),
            "PX" => numeric("3091", " Maximum Pan position is 3091"),
            "TN" => " -907".into(),
            "TX" => " 604".into(),
            "PL" | "TL" => " 31".into(),
            "PU" | "TU" => " 2902".into(),
            "PS" | "TS" | "PB" | "TB" => " 1000".into(),
            "PA" | "TA" => " 2000".into(),
            "PH" | "TH" => " LOW".into(),
            "PM" | "TM" => " REG".into(),
            "O" => " Input 30 VDC @ 86 degF".into(),
            "PP" => numeric("22", " Current Pan position is 22"),
            "TP" => numeric("-7", " Current Tilt position is -7"),
            _ => String::new(),
        };
        format!("{echo}*{body}{}", self.line_end)
    }
}

pub(crate) struct PtuTestRig {
    pub(crate) driver: PtuDriver,
    pub(crate) now: Duration,
    pub(crate) events: Vec<PtuEvent>,
}

impl PtuTestRig {
    pub(crate) fn new() -> Self {
        Self {
            driver: PtuDriver::new(PtuOptions::default()),
            now: Duration::from_secs(100),
            events: Vec::new(),
        }
    }

    /// Takes all actions; returns what was sent.
    pub(crate) fn take_sent(&mut self) -> Vec<String> {
        let mut sent = Vec::new();
        while let Some(action) = self.driver.poll_action() {
            match action {
                PtuAction::Send(bytes) => {
                    sent.push(String::from_utf8(bytes).expect("commands are ASCII"))
                }
                PtuAction::Event(event) => self.events.push(event),
            }
        }
        sent
    }

    pub(crate) fn feed(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.now += BYTE_TIME;
            self.driver.handle_bytes(&[*byte], self.now);
        }
    }

    pub(crate) fn pass_deadline(&mut self) {
        self.now = self.driver.deadline().expect("a deadline").max(self.now);
        self.driver.handle_deadline(self.now);
    }

    /// Lets time pass until something is sent.
    pub(crate) fn next_send(&mut self) -> String {
        for _ in 0..20 {
            let mut sent = self.take_sent();
            if let Some(first) = sent.pop() {
                assert!(
                    sent.is_empty(),
                    "more than one command at once: {sent:?} {first:?}"
                );
                return first;
            }
            self.pass_deadline();
        }
        panic!("nothing is sent");
    }

    pub(crate) fn connect_with(&mut self, replies: &mut ScriptedReplies) -> Vec<String> {
        self.driver.connect(self.now);
        self.answer_all(replies)
    }

    /// Answers everything until the driver is connected and idle; returns the commands seen.
    pub(crate) fn answer_all(&mut self, replies: &mut ScriptedReplies) -> Vec<String> {
        let mut seen = Vec::new();
        for _ in 0..500 {
            let sent = self.take_sent();
            if sent.is_empty() {
                if self.driver.deadline().is_none() {
                    return seen;
                }
                self.pass_deadline();
            }
            for command in sent.concat().split(' ').filter(|c| !c.is_empty()) {
                seen.push(command.to_owned());
                let answer = replies.answer(command);
                self.feed(answer.as_bytes());
            }
        }
        panic!("no end after {seen:?}");
    }

    pub(crate) fn connected() -> (Self, ScriptedReplies) {
        let (mut rig, mut replies) = (Self::new(), ScriptedReplies::default());
        rig.connect_with(&mut replies);
        assert!(matches!(rig.events.pop(), Some(PtuEvent::Connected(_))));
        (rig, replies)
    }

    pub(crate) fn only_event(&mut self) -> PtuEvent {
        assert!(
            self.take_sent().is_empty(),
            "an event was expected, not a command"
        );
        assert_eq!(self.events.len(), 1, "{:?}", self.events);
        self.events.remove(0)
    }
}
