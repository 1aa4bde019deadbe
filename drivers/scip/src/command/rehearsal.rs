//! `DB`: the device plays a malfunction, to see what the host makes of it; some units with firmware 3.3.00 and later.
//! Protocol section 6. For trials only: the laser goes off.

use super::Request;
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// The request `DB`. What is played already, or has ended already, is success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rehearse {
    /// A malfunction as SCIP 1.1 tells it.
    OldMalfunction,
    /// A malfunction.
    Malfunction,
    /// In a stream of more than 20 scans: normal, error, normal.
    Recovery,
    /// In such a stream: normal, error, malfunction.
    Failure,
    /// In such a stream: normal, malfunction.
    SuddenFailure,
    /// The end of it.
    End,
}

impl Request for Rehearse {
    type Reply = ();
    const COMMAND: Command = Command::Rehearsal;

    fn line(&self) -> Vec<u8> {
        match self {
            Self::OldMalfunction => b"DB01",
            Self::Malfunction => b"DB02",
            Self::Recovery => b"DB03",
            Self::Failure => b"DB04",
            Self::SuddenFailure => b"DB05",
            Self::End => b"DB10",
        }
        .to_vec()
    }

    fn parse(&self, message: &Message) -> Result<(), ReplyError> {
        self.expect_done_or_already(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;
    use crate::status::Meaning;

    #[test]
    fn its_statuses() {
        let parse = |bytes: &[u8]| {
            Rehearse::Recovery.parse(&Message::first_in(bytes, Instant::ZERO).expect("complete"))
        };
        assert_eq!(parse(b"DB03\n00P\n\n"), Ok(()));
        assert_eq!(parse(b"DB03\n02R\n\n"), Ok(()));
        let refusal = |bytes| parse(bytes).expect_err("refused").refusal();
        assert_eq!(refusal(b"DB03\n04T\n\n"), Some(Meaning::NotSupported));
        assert_eq!(refusal(b"DB03\n05U\n\n"), Some(Meaning::Unstable));
        assert_eq!(refusal(b"DB03\n0Ee\n\n"), Some(Meaning::Undefined));
        assert_eq!(Rehearse::End.to_bytes(), b"DB10\n");
    }
}
