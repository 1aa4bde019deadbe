//! `PP`: the numbers that turn steps into angles and values into ranges (scip2 sections 1 and 6).

use std::f64::consts::TAU;
use std::time::Duration;

use super::keyed_lines;
use super::request::ScipRequest;
use crate::constants::{MAX_RANGE_MM, MAX_STEP, MAX_STEPS_PER_TURN, SCAN_RPM};
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// The request `PP`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadParameters;

/// The reply to `PP`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterReply {
    /// `MODL`.
    pub model: String,
    /// All other lines.
    pub parameters: LaserParameters,
}

/// Geometry and limits of the sensor. Parsed from a reply they are possible: the window is at most one turn and has the
/// front step in it, the steps have four digits, the ranges 18 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaserParameters {
    /// `DMIN`: minimum distance, mm; values below are codes.
    pub dmin_mm: u32,
    /// `DMAX`: maximum distance, mm.
    pub dmax_mm: u32,
    /// `ARES`: steps per revolution.
    pub ares: u32,
    /// `AMIN`: first measured step.
    pub amin: u32,
    /// `AMAX`: last measured step.
    pub amax: u32,
    /// `AFRT`: the step straight ahead.
    pub afrt: u32,
    /// `SCAN`: nominal speed, revolutions per minute.
    pub scan_rpm: u32,
}

impl LaserParameters {
    /// As a real URG-04LX sent them (scip2 section 12).
    pub const URG_04LX: Self = Self {
        dmin_mm: 20,
        dmax_mm: 5600,
        ares: 1024,
        amin: 44,
        amax: 725,
        afrt: 384,
        scan_rpm: 600,
    };

    /// Nominal time of one revolution. A real sensor's clock is off by some 0.1 % (scip2 section 8).
    #[must_use]
    pub fn scan_period(&self) -> Duration {
        Duration::from_secs(60) / self.scan_rpm.max(1)
    }

    /// Angle of a step, rad, positive to the left, zero ahead (scip2 section 1). Fractions of a step are allowed.
    #[must_use]
    pub fn angle_rad(&self, step: f64) -> f64 {
        (step - f64::from(self.afrt)) * TAU / f64::from(self.ares.max(1))
    }
}

fn number(message: &ScipMessage, key: &'static str) -> Result<u32, ReplyError> {
    let line = keyed_lines::require(message, key, ScipCommand::Parameters)?;
    line.sum.clone()?;
    line.text().parse().map_err(|_| ReplyError::Value {
        key,
        expected: "a number",
        got: line.value.into(),
    })
}

impl ScipRequest for ReadParameters {
    type Reply = ParameterReply;
    const COMMAND: ScipCommand = ScipCommand::Parameters;

    fn line(&self) -> Vec<u8> {
        b"PP".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<ParameterReply, ReplyError> {
        self.expect_done(message)?;
        let model = keyed_lines::require(message, "MODL", Self::COMMAND)?;
        model.sum.clone()?;
        let parameters = LaserParameters {
            dmin_mm: number(message, "DMIN")?,
            dmax_mm: number(message, "DMAX")?,
            ares: number(message, "ARES")?,
            amin: number(message, "AMIN")?,
            amax: number(message, "AMAX")?,
            afrt: number(message, "AFRT")?,
            scan_rpm: number(message, "SCAN")?,
        };
        match parameters.impossible() {
            Some((key, expected, got)) => Err(ReplyError::Value {
                key,
                expected,
                got: got.to_string().as_bytes().into(),
            }),
            None => Ok(ParameterReply {
                model: model.text(),
                parameters,
            }),
        }
    }
}

impl LaserParameters {
    /// The first number that cannot be, or that contradicts another: its key, what it must be, what it is.
    fn impossible(&self) -> Option<(&'static str, &'static str, u32)> {
        let Self {
            dmin_mm,
            dmax_mm,
            ares,
            amin,
            amax,
            afrt,
            scan_rpm,
        } = *self;
        let checks = [
            (
                (1..=MAX_STEPS_PER_TURN).contains(&ares),
                ("ARES", "1 to 10000 steps per turn", ares),
            ),
            (
                SCAN_RPM.contains(&scan_rpm),
                ("SCAN", "60 to 24000 revolutions per minute", scan_rpm),
            ),
            (dmin_mm > 0, ("DMIN", "more than 0", dmin_mm)),
            (dmax_mm > dmin_mm, ("DMAX", "more than DMIN", dmax_mm)),
            (
                dmax_mm <= MAX_RANGE_MM,
                ("DMAX", "at most 262143 mm", dmax_mm),
            ),
            (amax >= amin, ("AMAX", "at least AMIN", amax)),
            (
                amax.saturating_sub(amin) < ares,
                ("AMAX", "less than a turn (ARES) beyond AMIN", amax),
            ),
            (amax <= u32::from(MAX_STEP), ("AMAX", "at most 9999", amax)),
            (
                (amin..=amax).contains(&afrt),
                ("AFRT", "between AMIN and AMAX", afrt),
            ),
        ];
        checks
            .into_iter()
            .find_map(|(possible, what)| (!possible).then_some(what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encoding::sum;

    const URG_04LX: &str = "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\nARES:1024;\\\n\
        AMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";

    fn parse(text: &str) -> Result<ParameterReply, ReplyError> {
        ReadParameters
            .parse(&ScipMessage::first_in(text.as_bytes(), Duration::ZERO).expect("complete"))
    }

    #[test]
    fn parses_the_recorded_reply() {
        let reply = parse(URG_04LX).expect("every sum is right");
        assert_eq!(reply.model, "URG-04LX(Hokuyo Automatic Co.,Ltd.)");
        assert_eq!(reply.parameters, LaserParameters::URG_04LX);
    }

    #[test]
    fn unknown_keys_are_passed_over() {
        let text = URG_04LX.replace("SCAN", "PROT:SCIP 2.2;P\nWHAT\nSCAN");
        assert_eq!(
            parse(&text).expect("the seven are there").parameters,
            LaserParameters::URG_04LX
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
        // Each bound from both sides.
        for (old, possible, impossible) in [
            ("ARES:1024;\\", "ARES:682", "ARES:681"),
            ("ARES:1024;\\", "ARES:10000", "ARES:10001"),
            ("ARES:1024;\\", "ARES:1024", "ARES:0"),
            ("SCAN:600;e", "SCAN:60", "SCAN:59"),
            ("SCAN:600;e", "SCAN:24000", "SCAN:24001"),
            ("DMIN:20;4", "DMIN:1", "DMIN:0"),
            ("DMIN:20;4", "DMIN:5599", "DMIN:5600"),
            ("DMAX:5600;_", "DMAX:262143", "DMAX:262144"),
            ("AMAX:725;o", "AMAX:1067", "AMAX:1068"),
            ("AMAX:725;o", "AMAX:384", "AMAX:383"),
            ("AMIN:44;7", "AMIN:384", "AMIN:385"),
            ("AMAX:725;o", "AMAX:725", "AMAX:43"),
            ("AMAX:725;o", "AMAX:725", "AMAX:99999"),
        ] {
            let with = |body: &str| {
                let new = format!("{body};{}", char::from(sum(body.as_bytes())));
                parse(&URG_04LX.replace(old, &new))
            };
            assert!(with(possible).is_ok(), "{possible}");
            let refused = with(impossible).expect_err(impossible);
            assert!(matches!(refused, ReplyError::Value { .. }), "{refused}");
        }
        let far = |amin, afrt, amax| LaserParameters {
            ares: 10_000,
            amin,
            afrt,
            amax,
            ..LaserParameters::URG_04LX
        };
        assert_eq!(far(5000, 6000, 9999).impossible(), None);
        let beyond = Some(("AMAX", "at most 9999", 10_000));
        assert_eq!(far(5000, 6000, 10_000).impossible(), beyond);
        let new = format!("DMIN:2x;{}", char::from(sum(b"DMIN:2x")));
        assert!(matches!(
            parse(&URG_04LX.replace("DMIN:20;4", &new)),
            Err(ReplyError::Value { key: "DMIN", .. })
        ));
    }

    #[test]
    fn angles_and_period_of_the_protocol() {
        let urg = LaserParameters::URG_04LX;
        for (step, degrees) in [
            (0.0, -135.0),
            (44.0, -119.531),
            (384.0, 0.0),
            (725.0, 119.883),
            (768.0, 135.0),
        ] {
            assert!((urg.angle_rad(step).to_degrees() - degrees).abs() < 1e-3);
        }
        assert_eq!(urg.scan_period(), Duration::from_millis(100));
    }
}
