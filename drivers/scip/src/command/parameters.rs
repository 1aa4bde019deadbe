//! `PP`: the seven numbers that turn steps into angles and values into ranges. Protocol sections 1 and 6.

use std::f64::consts::TAU;
use std::time::Duration;

use super::{Request, keyed};
use crate::error::ReplyError;
use crate::frame::Message;
use crate::status::Command;

/// The request `PP`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadParameters;

/// What `PP` tells: the model's name and its numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterReply {
    /// `MODL`.
    pub model: String,
    /// The seven numbers.
    pub parameters: Parameters,
}

/// The sensor's numbers. From a device: `ares`, `scan_rpm` > 0, `dmin_mm <= dmax_mm`, `amin <= amax`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// `DMIN`: least distance, mm; values below are codes.
    pub dmin_mm: u32,
    /// `DMAX`: greatest distance, mm.
    pub dmax_mm: u32,
    /// `ARES`: steps in a full turn.
    pub ares: u32,
    /// `AMIN`: first step that measures.
    pub amin: u32,
    /// `AMAX`: last step that measures.
    pub amax: u32,
    /// `AFRT`: the step straight ahead.
    pub afrt: u32,
    /// `SCAN`: nominal speed, turns per minute.
    pub scan_rpm: u32,
}

impl Parameters {
    /// The numbers of a URG-04LX (protocol section 12), as a real one sent them.
    pub const URG_04LX: Self = Self {
        dmin_mm: 20,
        dmax_mm: 5600,
        ares: 1024,
        amin: 44,
        amax: 725,
        afrt: 384,
        scan_rpm: 600,
    };

    /// Time of one turn; nominal, a real sensor's clock is off by some 0.1 % (protocol section 8).
    #[must_use]
    pub fn scan_period(&self) -> Duration {
        Duration::from_secs(60) / self.scan_rpm.max(1)
    }

    /// Angle of a step, rad, positive to the left, zero ahead (protocol section 1). Fractions of a step are allowed.
    #[must_use]
    pub fn angle_rad(&self, step: f64) -> f64 {
        (step - f64::from(self.afrt)) * TAU / f64::from(self.ares.max(1))
    }

    /// Time from the stamp, which is step 0, to `step` (protocol section 8).
    #[must_use]
    pub fn step_delay(&self, step: f64) -> Duration {
        let turns = (step / f64::from(self.ares.max(1))).max(0.0);
        Duration::try_from_secs_f64(self.scan_period().as_secs_f64() * turns).unwrap_or_default()
    }
}

fn number(message: &Message, key: &'static str) -> Result<u32, ReplyError> {
    let line = keyed::find(message, key).ok_or(ReplyError::MissingKey {
        key,
        command: Command::Parameters,
    })?;
    line.sum.clone()?;
    line.text().parse().map_err(|_| ReplyError::Value {
        key,
        expected: "a number",
        got: line.value.into(),
    })
}

impl Request for ReadParameters {
    type Reply = ParameterReply;
    const COMMAND: Command = Command::Parameters;

    fn line(&self) -> Vec<u8> {
        b"PP".to_vec()
    }

    fn parse(&self, message: &Message) -> Result<ParameterReply, ReplyError> {
        self.expect_done(message)?;
        let model = keyed::find(message, "MODL").ok_or(ReplyError::MissingKey {
            key: "MODL",
            command: Self::COMMAND,
        })?;
        model.sum.clone()?;
        let parameters = Parameters {
            dmin_mm: number(message, "DMIN")?,
            dmax_mm: number(message, "DMAX")?,
            ares: number(message, "ARES")?,
            amin: number(message, "AMIN")?,
            amax: number(message, "AMAX")?,
            afrt: number(message, "AFRT")?,
            scan_rpm: number(message, "SCAN")?,
        };
        let value = |key, expected, got: u32| {
            Err(ReplyError::Value {
                key,
                expected,
                got: got.to_string().as_bytes().into(),
            })
        };
        match parameters {
            Parameters { ares: 0, .. } => value("ARES", "more than 0", 0),
            Parameters { scan_rpm: 0, .. } => value("SCAN", "more than 0", 0),
            Parameters {
                dmin_mm, dmax_mm, ..
            } if dmin_mm > dmax_mm => value("DMAX", "at least DMIN", dmax_mm),
            Parameters { amin, amax, .. } if amin > amax => value("AMAX", "at least AMIN", amax),
            parameters => Ok(ParameterReply {
                model: model.text(),
                parameters,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Instant;
    use crate::encoding::sum;

    const URG_04LX: &str = "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\n\
        AMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";

    fn parse(text: &str) -> Result<ParameterReply, ReplyError> {
        ReadParameters.parse(&Message::first_in(text.as_bytes(), Instant::ZERO).expect("complete"))
    }

    #[test]
    fn the_real_reply() {
        let reply = parse(URG_04LX).expect("every sum is right");
        assert_eq!(reply.model, "URG-04LX(Hokuyo Automatic Co.,Ltd.)");
        assert_eq!(reply.parameters, Parameters::URG_04LX);
    }

    #[test]
    fn unknown_keys_are_passed_over() {
        let text = URG_04LX.replace("SCAN", "PROT:SCIP 2.2;P\nWHAT\nSCAN");
        assert_eq!(
            parse(&text).expect("the seven are there").parameters,
            Parameters::URG_04LX
        );
    }

    #[test]
    fn each_of_the_seven_is_required_and_its_sum_checked() {
        for key in [
            "MODL", "DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN",
        ] {
            let missing = parse(&URG_04LX.replace(key, "XXXX")).expect_err("the key is gone");
            assert!(matches!(missing, ReplyError::MissingKey { key: named, .. } if named == key));
        }
        assert!(matches!(
            parse(&URG_04LX.replace("600;e", "601;e")),
            Err(ReplyError::Sum { .. })
        ));
    }

    #[test]
    fn numbers_that_make_no_sense_are_refused() {
        for (old, body) in [
            ("ARES:1024;\\", "ARES:0"),
            ("SCAN:600;e", "SCAN:0"),
            ("AMAX:725;o", "AMAX:43"),
        ] {
            let new = format!("{body};{}", char::from(sum(body.as_bytes())));
            assert!(
                matches!(
                    parse(&URG_04LX.replace(old, &new)),
                    Err(ReplyError::Value { .. })
                ),
                "{new}"
            );
        }
        let new = format!("DMIN:2x;{}", char::from(sum(b"DMIN:2x")));
        assert!(matches!(
            parse(&URG_04LX.replace("DMIN:20;4", &new)),
            Err(ReplyError::Value { key: "DMIN", .. })
        ));
    }

    #[test]
    fn angles_and_delays_of_the_protocol() {
        let urg = Parameters::URG_04LX;
        for (step, degrees, delay_ms) in [
            (0.0, -135.0, 0.0),
            (44.0, -119.531, 4.3),
            (384.0, 0.0, 37.5),
            (725.0, 119.883, 70.8),
            (768.0, 135.0, 75.0),
        ] {
            assert!((urg.angle_rad(step).to_degrees() - degrees).abs() < 1e-3);
            assert!((urg.step_delay(step).as_secs_f64() * 1e3 - delay_ms).abs() < 0.05);
        }
        assert_eq!(urg.scan_period(), Duration::from_millis(100));
    }
}
