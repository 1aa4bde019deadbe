//! The bench of the dialogue tests: scripted replies, fed byte by byte, and a clock that is only a number.

use std::time::Duration;

use crate::{Action, Event, Head, HeadOptions, Instant};

pub(crate) const BYTE: Duration = Duration::from_micros(1042);

/// The unit's replies, and what it remembers: the forms of section 3, nothing of its motion.
pub(crate) struct Replies {
    pub(crate) echo: bool,
    pub(crate) verbose: bool,
    pub(crate) line_end: &'static str,
    /// Commands that are answered otherwise than usual, with the whole reply but its end.
    pub(crate) instead: Vec<(&'static str, &'static str)>,
}

impl Default for Replies {
    fn default() -> Self {
        Self {
            echo: true,
            verbose: true,
            line_end: "\r\n",
            instead: Vec::new(),
        }
    }
}

impl Replies {
    pub(crate) fn answer(&mut self, command: &str) -> String {
        if let Some((_, reply)) = self.instead.iter().find(|(c, _)| *c == command) {
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

pub(crate) struct Bench {
    pub(crate) head: Head,
    pub(crate) now: Instant,
    pub(crate) events: Vec<Event>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self {
            head: Head::new(HeadOptions::default()),
            now: Duration::from_secs(100),
            events: Vec::new(),
        }
    }

    /// Takes all actions; gives what was sent.
    pub(crate) fn sends(&mut self) -> Vec<String> {
        let mut sent = Vec::new();
        while let Some(action) = self.head.poll_action() {
            match action {
                Action::Send(bytes) => {
                    sent.push(String::from_utf8(bytes).expect("commands are ASCII"))
                }
                Action::Event(event) => self.events.push(event),
            }
        }
        sent
    }

    pub(crate) fn feed(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.now += BYTE;
            self.head.handle_bytes(&[*byte], self.now);
        }
    }

    pub(crate) fn pass_deadline(&mut self) {
        self.now = self
            .head
            .deadline()
            .expect("something is waited for")
            .max(self.now);
        self.head.handle_deadline(self.now);
    }

    /// Lets time pass until something is sent.
    pub(crate) fn next_send(&mut self) -> String {
        for _ in 0..20 {
            let mut sent = self.sends();
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

    pub(crate) fn connect_with(&mut self, replies: &mut Replies) -> Vec<String> {
        self.head.connect(self.now);
        self.go_on(replies)
    }

    /// Answers everything until the driver is connected and idle; gives the commands seen.
    pub(crate) fn go_on(&mut self, replies: &mut Replies) -> Vec<String> {
        let mut seen = Vec::new();
        for _ in 0..500 {
            let sent = self.sends();
            if sent.is_empty() {
                if self.head.deadline().is_none() {
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

    pub(crate) fn connected() -> (Self, Replies) {
        let (mut bench, mut replies) = (Self::new(), Replies::default());
        bench.connect_with(&mut replies);
        assert!(matches!(bench.events.pop(), Some(Event::Connected(_))));
        (bench, replies)
    }

    pub(crate) fn event(&mut self) -> Event {
        assert!(
            self.sends().is_empty(),
            "an event was expected, not a command"
        );
        assert_eq!(self.events.len(), 1, "{:?}", self.events);
        self.events.remove(0)
    }
}
