//! The state of an idle laser driver as bytes: the options that differ between ports, and the identity.

use super::error::DialogueError;
use super::{ByteReader, ByteWriter};
use scip::{LaserIdentity, LaserParameters, ScipOptions};
use std::time::Duration;

pub(crate) fn encode_laser(options: &ScipOptions, identity: &LaserIdentity) -> Vec<u8> {
    let mut out = ByteWriter::default();
    out.u64(u64::try_from(options.reply_timeout.as_nanos()).unwrap_or(u64::MAX));
    out.u8(options.attempts);
    out.u8(u8::from(options.reset_on_connect));
    out.u32(options.link_bytes_per_second.unwrap_or(0));
    let LaserParameters {
        dmin_mm,
        dmax_mm,
        ares,
        amin,
        amax,
        afrt,
        scan_rpm,
    } = identity.parameters;
    for number in [dmin_mm, dmax_mm, ares, amin, amax, afrt, scan_rpm] {
        out.u32(number);
    }
    for text in [
        &identity.model,
        &identity.vendor,
        &identity.product,
        &identity.firmware,
        &identity.protocol,
        &identity.serial,
        &identity.status,
    ] {
        out.block(text.as_bytes());
    }
    out.0
}

pub(crate) fn decode_laser(state: &[u8]) -> Result<(ScipOptions, LaserIdentity), DialogueError> {
    let mut input = ByteReader::new(state);
    let options = ScipOptions {
        reply_timeout: Duration::from_nanos(input.u64("a time-out")?),
        attempts: input.u8("a number of attempts")?,
        reset_on_connect: input.u8("whether it is reset")? != 0,
        link_bytes_per_second: Some(input.u32("a line rate")?).filter(|rate| *rate > 0),
        ..ScipOptions::default()
    };
    let mut number = || input.u32("a parameter of the laser");
    let parameters = LaserParameters {
        dmin_mm: number()?,
        dmax_mm: number()?,
        ares: number()?,
        amin: number()?,
        amax: number()?,
        afrt: number()?,
        scan_rpm: number()?,
    };
    let mut text = || input.text("a line of the laser's identity");
    let identity = LaserIdentity {
        model: text()?,
        vendor: text()?,
        product: text()?,
        firmware: text()?,
        protocol: text()?,
        serial: text()?,
        status: text()?,
        parameters,
        line_bytes_s: options.link_bytes_per_second,
    };
    Ok((options, identity))
}
