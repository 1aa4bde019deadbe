//! `II`: the state of the device (scip2 section 6).

use super::keyed_lines;
use super::request::ScipRequest;
use crate::encoding::decode;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// The request `II`. For an idle device only: during streaming it stops the stream (scip2 section 13).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadInfo;

/// The reply to `II`. In an error state the device may leave out all lines but `STAT`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InfoReply {
    /// `MODL`.
    pub model: Option<String>,
    /// `LASR`: whether the laser is on.
    pub laser_on: Option<bool>,
    /// `SCSP`: motor speed, as text.
    pub scan_speed: Option<String>,
    /// `MESM`: measuring mode.
    pub mode: Option<String>,
    /// `SBPS`: bit rate, as text.
    pub bit_rate: Option<String>,
    /// `TIME`: the timer, ms, 24 bits.
    pub time_ms: Option<u32>,
    /// `STAT`: the device's own diagnosis.
    pub status: String,
}

impl InfoReply {
    /// Whether `STAT` reports a fault.
    #[must_use]
    pub fn is_trouble(&self) -> bool {
        self.status.contains("Trouble")
    }
}

/// Six hexadecimal digits, or the four-character code of newer models.
fn parse_time(text: &str) -> Option<u32> {
    match text.len() {
        6 => u32::from_str_radix(text, 16).ok(),
        4 => decode(text.as_bytes()).ok(),
        _ => None,
    }
}

impl ScipRequest for ReadInfo {
    type Reply = InfoReply;
    const COMMAND: ScipCommand = ScipCommand::Info;

    fn line(&self) -> Vec<u8> {
        b"II".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<InfoReply, ReplyError> {
        self.expect_done(message)?;
        let text = |key| match keyed_lines::find(message, key) {
            None => Ok(None),
            Some(line) => line.sum.clone().map(|()| Some(line.text())),
        };
        let time_ms = match text("TIME")? {
            None => None,
            Some(digits) => Some(parse_time(&digits).ok_or_else(|| ReplyError::Value {
                key: "TIME",
                expected: "6 hexadecimal digits or 4 characters",
                got: digits.as_bytes().into(),
            })?),
        };
        Ok(InfoReply {
            model: text("MODL")?,
            laser_on: text("LASR")?.map(|word| word == "ON"),
            scan_speed: text("SCSP")?,
            mode: text("MESM")?,
            bit_rate: text("SBPS")?,
            time_ms,
            status: {
                let line = keyed_lines::require(message, "STAT", Self::COMMAND)?;
                line.sum.clone()?;
                line.text()
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::sum;
    use std::time::Duration;

    const OFF: &str = "II\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nLASR:OFF;7\n\
        SCSP:Initial(600[rpm])<-Default setting by user;A\nMESM:IDLE;:\nSBPS:19200[bps]<-Default setting by user;A\n\
        TIME:001957;O\nSTAT:Sensor works well.;8\n\n";

    fn parse(text: &str) -> Result<InfoReply, ReplyError> {
        ReadInfo.parse(&ScipMessage::first_in(text.as_bytes(), Duration::ZERO).expect("complete"))
    }

    #[test]
    fn parses_the_recorded_reply() {
        let info = parse(OFF).expect("every sum is right");
        assert_eq!(info.laser_on, Some(false));
        assert_eq!(info.mode.as_deref(), Some("IDLE"));
        assert_eq!(info.time_ms, Some(0x1957));
        assert_eq!(info.status, "Sensor works well.");
        assert!(!info.is_trouble());
    }

    #[test]
    fn parses_the_recorded_lines_with_the_laser_on() {
        let on = OFF
            .replace("OFF;7", "ON;9")
            .replace("IDLE;:", "CLASSIC;^")
            .replace("001957;O", "001E12;R");
        let info = parse(&on).expect("every sum is right");
        assert_eq!((info.laser_on, info.time_ms), (Some(true), Some(0x1E12)));
    }

    #[test]
    fn trouble_with_few_lines() {
        let body = "STAT:Trouble!! Error No. =[05]";
        let info = parse(&format!(
            "II\n00P\n{body};{}\n\n",
            char::from(sum(body.as_bytes()))
        ))
        .expect("STAT suffices");
        assert!(info.is_trouble());
        assert_eq!(info.model, None);
    }

    #[test]
    fn the_timer_of_newer_models_has_four_characters() {
        let body = "TIME:JUGn";
        let text = OFF.replace(
            "TIME:001957;O",
            &format!("{body};{}", char::from(sum(body.as_bytes()))),
        );
        assert_eq!(
            parse(&text).expect("every sum is right").time_ms,
            Some(6_968_830)
        );
    }
}
