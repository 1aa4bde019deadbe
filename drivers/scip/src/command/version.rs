//! `VV`: identity of the device (scip2 section 6).

use super::keyed_lines;
use super::request::ScipRequest;
use crate::error::ReplyError;
use crate::frame::ScipMessage;
use crate::status::ScipCommand;

/// The request `VV`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadVersion;

/// The reply to `VV`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VersionReply {
    /// `VEND`.
    pub vendor: String,
    /// `PROD`.
    pub product: String,
    /// `FIRM`.
    pub firmware: String,
    /// `PROT`.
    pub protocol: String,
    /// `SERI`.
    pub serial: String,
}

impl ReadVersion {
    /// As [`ScipRequest::parse`], but accepts wrong sums, since some old units always send one, and counts them.
    ///
    /// # Errors
    /// As [`ScipRequest::parse`], but no [`ReplyError::Sum`] for the keyed lines.
    pub(crate) fn parse_leniently(
        &self,
        message: &ScipMessage,
    ) -> Result<(VersionReply, usize), ReplyError> {
        self.expect_done(message)?;
        let mut wrong_sums = 0;
        let mut text = |key| {
            let line = keyed_lines::require(message, key, Self::COMMAND)?;
            wrong_sums += usize::from(line.sum.is_err());
            Ok(line.text())
        };
        let version = VersionReply {
            vendor: text("VEND")?,
            product: text("PROD")?,
            firmware: text("FIRM")?,
            protocol: text("PROT")?,
            serial: text("SERI")?,
        };
        Ok((version, wrong_sums))
    }
}

impl ScipRequest for ReadVersion {
    type Reply = VersionReply;
    const COMMAND: ScipCommand = ScipCommand::Version;

    fn line(&self) -> Vec<u8> {
        b"VV".to_vec()
    }

    fn parse(&self, message: &ScipMessage) -> Result<VersionReply, ReplyError> {
        let (version, _) = self.parse_leniently(message)?;
        for key in ["VEND", "PROD", "FIRM", "PROT", "SERI"] {
            if let Some(line) = keyed_lines::find(message, key) {
                line.sum?;
            }
        }
        Ok(version)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const URG_04LX: &[u8] =
        b"VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX;[\n\
        FIRM:3.1.04(02/Aug./2007);a\nPROT:SCIP 2.0;N\nSERI:H0706400;F\n\n";

    fn message(bytes: &[u8]) -> ScipMessage {
        ScipMessage::first_in(bytes, Duration::ZERO).expect("complete")
    }

    #[test]
    fn parses_the_recorded_reply() {
        let version = ReadVersion
            .parse(&message(URG_04LX))
            .expect("every sum is right");
        assert_eq!(version.vendor, "Hokuyo Automatic Co.,Ltd.");
        assert_eq!(version.product, "SOKUIKI Sensor URG-04LX");
        assert_eq!(version.firmware, "3.1.04(02/Aug./2007)");
        assert_eq!(version.protocol, "SCIP 2.0");
        assert_eq!(version.serial, "H0706400");
        assert_eq!(ReadVersion.to_bytes(), b"VV\n");
    }

    #[test]
    fn parses_the_recorded_lines_of_a_ug01() {
        let reply = b"VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\nPROD:SOKUIKI Sensor URG-04LX-UG01(Simple-URG);[\n\
            FIRM:3.4.03(17/Dec./2012);T\nPROT:SCIP 2.0;N\nSERI:H1510998;V\n\n";
        assert_eq!(
            ReadVersion
                .parse(&message(reply))
                .expect("every sum is right")
                .serial,
            "H1510998"
        );
    }

    #[test]
    fn a_wrong_sum_is_an_error_but_can_be_tolerated() {
        let reply = [b"VV\n00P\nI\n", &URG_04LX[7..URG_04LX.len() - 3], b"E\n\n"].concat();
        let message = message(&reply);
        assert!(matches!(
            ReadVersion.parse(&message),
            Err(ReplyError::Sum { got: b'E', .. })
        ));
        let (version, wrong_sums) = ReadVersion
            .parse_leniently(&message)
            .expect("all keys are there");
        assert_eq!((version.serial.as_str(), wrong_sums), ("H0706400", 1));
    }

    #[test]
    fn a_missing_key_is_named() {
        let error = ReadVersion
            .parse(&message(b"VV\n00P\nPROT:SCIP 2.0;N\n\n"))
            .expect_err("four keys are missing");
        assert_eq!(
            error,
            ReplyError::MissingKey {
                key: "VEND",
                command: ScipCommand::Version,
                got: b"PROT".as_slice().into(),
            }
        );
    }
}
