//! The plan of a sweep as bytes: what the devices were asked for, and how their counts and steps are angles.

use super::error::DialogueError;
use super::{ByteReader, ByteWriter};
use crate::devices::plan::{SweepPlan, TiltPlan};
use crate::devices::sweep_run::PortNames;
use patrold_engine::sweep::{RawSweep, decode_raw_sweep, encode_raw_sweep};
use ptu::{AxisIdentity, AxisLimits, StepSize};
use scip::{StreamPlan, ValueCoding};
use std::time::Duration;

pub(in crate::devices) fn encode_plan(plan: &SweepPlan, ports: &PortNames) -> Vec<u8> {
    let mut out = ByteWriter::default();
    // Geometry, mount, tilts and calibration are those of a raw sweep without a scan.
    out.block(&encode_raw_sweep(&plan.raw_sweep(Vec::new())));
    let stream = &plan.stream;
    out.u16(stream.first_step);
    out.u16(stream.last_step);
    out.u8(stream.cluster);
    out.u8(stream.interval);
    out.u8(match stream.coding {
        ValueCoding::TwoCharacter => 2,
        ValueCoding::ThreeCharacter => 3,
        ValueCoding::WithIntensity => 6,
    });
    out.u8(stream.count);
    out.u64(u64::try_from(plan.line_period.as_nanos()).unwrap_or(u64::MAX));
    out.u32(plan.pans.len() as u32);
    for (steps, radians) in &plan.pans {
        out.i32(*steps);
        out.f64(*radians);
    }
    match &plan.tilt {
        TiltPlan::Continuous {
            start_steps,
            end_steps,
            speed_steps_s,
            ramp_steps,
        } => {
            out.u8(0);
            for number in [start_steps, end_steps, speed_steps_s, ramp_steps] {
                out.i32(*number);
            }
        }
        TiltPlan::Steps(targets) => {
            out.u8(1);
            out.u32(targets.len() as u32);
            for steps in targets {
                out.i32(*steps);
            }
        }
    }
    for axis in [&plan.pan_axis, &plan.tilt_axis] {
        out.f64(axis.step.radians());
        for number in [
            axis.limits.min_steps,
            axis.limits.max_steps,
            axis.speed_min,
            axis.speed_max,
            axis.speed,
            axis.base_speed,
            axis.acceleration,
        ] {
            out.i32(number);
        }
    }
    out.i32(plan.approach_steps_s.0);
    out.i32(plan.approach_steps_s.1);
    out.block(ports.laser.as_bytes());
    out.block(ports.head.as_bytes());
    out.0
}

pub(super) fn decode_plan(bytes: &[u8]) -> Result<(SweepPlan, PortNames), DialogueError> {
    let mut input = ByteReader::new(bytes);
    let damaged = input.damaged("the geometry of a raw sweep");
    let geometry: RawSweep = decode_raw_sweep(input.block("a geometry")?).map_err(|_| damaged)?;
    let stream = StreamPlan {
        first_step: input.u16("a step")?,
        last_step: input.u16("a step")?,
        cluster: input.u8("a cluster")?,
        interval: input.u8("an interval")?,
        coding: match input.u8("a coding")? {
            2 => ValueCoding::TwoCharacter,
            3 => ValueCoding::ThreeCharacter,
            6 => ValueCoding::WithIntensity,
            _ => return Err(input.damaged("a coding of 2, 3 or 6 characters")),
        },
        count: input.u8("a count")?,
    };
    let line_period = Duration::from_nanos(input.u64("a period")?);
    let mut pans = Vec::new();
    for _ in 0..input.u32("a number of pans")? {
        pans.push((input.i32("a pan")?, input.f64("a pan")?));
    }
    let tilt = match input.u8("a tilt")? {
        0 => TiltPlan::Continuous {
            start_steps: input.i32("a start")?,
            end_steps: input.i32("an end")?,
            speed_steps_s: input.i32("a speed")?,
            ramp_steps: input.i32("a ramp")?,
        },
        1 => {
            let mut targets = Vec::new();
            for _ in 0..input.u32("a number of lines")? {
                targets.push(input.i32("a tilt")?);
            }
            TiltPlan::Steps(targets)
        }
        _ => return Err(input.damaged("a tilt of kind 0 or 1")),
    };
    let plan = SweepPlan {
        stream,
        scan_geometry: geometry.scan_geometry,
        mount: geometry.mount,
        line_period,
        pans,
        tilt,
        pan_axis: read_axis(&mut input)?,
        tilt_axis: read_axis(&mut input)?,
        approach_steps_s: (input.i32("a speed")?, input.i32("a speed")?),
        tilt_rad_per_step: geometry.tilt_rad_per_step,
        tilt_zero_rad: geometry.tilt_zero_rad,
        tilt_range_rad: (geometry.tilt_low_rad, geometry.tilt_high_rad),
        line_pitch_rad: geometry.line_pitch_rad,
        time_offset_s: geometry.time_offset_s,
        tilt_backlash_rad: geometry.tilt_backlash_rad,
        notes: Vec::new(),
    };
    let ports = PortNames {
        laser: input.text("a port")?,
        head: input.text("a port")?,
    };
    if !input.is_at_end() {
        return Err(input.damaged("the end of the plan"));
    }
    Ok((plan, ports))
}

fn read_axis(input: &mut ByteReader<'_>) -> Result<AxisIdentity, DialogueError> {
    let step = StepSize::from_radians(input.f64("an angle")?);
    let step = step.ok_or_else(|| input.damaged("a positive angle"))?;
    let mut number = || input.i32("a number of an axis");
    Ok(AxisIdentity {
        step,
        limits: AxisLimits {
            min_steps: number()?,
            max_steps: number()?,
        },
        speed_min: number()?,
        speed_max: number()?,
        speed: number()?,
        base_speed: number()?,
        acceleration: number()?,
        // No sweep depends on these.
        hold_power: None,
        move_power: None,
    })
}

#[cfg(test)]
mod tests {
    use super::{decode_plan, encode_plan};
    use crate::config::{Settings, SweepMode};
    use crate::devices::lockstep::rig::TestRig;
    use crate::devices::sweep_run::PortNames;
    use patrold_sim::emulator::EmulationOptions;

    #[test]
    fn a_plan_is_read_back_but_for_what_no_sweep_depends_on() {
        let rig = TestRig::ready(EmulationOptions::seeded(1));
        let mut ptu = Settings::defaults().ptu;
        (ptu.pan_sign, ptu.pan_zero_rad) = (-1.0, 0.2);
        (ptu.tilt_sign, ptu.tilt_zero_rad, ptu.tilt_backlash_rad) = (-1.0, -0.05, 0.003);
        let ports = PortNames {
            laser: "/dev/a".to_owned(),
            head: "/dev/b".to_owned(),
        };
        for mode in [SweepMode::Continuous, SweepMode::Step] {
            let mut request = TestRig::request(mode);
            request.time_offset_s = 0.0125;
            request.pans_rad = vec![-0.5, 0.7];
            let plan = rig.plan(&request, &ptu).expect("within reach");
            let bytes = encode_plan(&plan, &ports);
            let (got, got_ports) = decode_plan(&bytes).expect("readable");
            let mut kept = plan;
            kept.notes.clear();
            for axis in [&mut kept.pan_axis, &mut kept.tilt_axis] {
                (axis.hold_power, axis.move_power) = (None, None);
            }
            assert_eq!((got, &got_ports), (kept, &ports));
            for length in 0..bytes.len() {
                assert!(decode_plan(&bytes[..length]).is_err(), "cut at {length}");
            }
        }
    }
}
