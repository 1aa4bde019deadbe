//! Both sweep modes and both directions measure the same walls, and no time is lost between first and last line.

use super::rig::TestRig;
use crate::config::SweepMode;
use patrold_engine::sweep::{RawSweep, TimeSample, assemble};
use patrold_sim::emulator::EmulationOptions;

fn raw(seed: u64, mode: SweepMode, reverse: bool) -> RawSweep {
    let mut rig = TestRig::ready(EmulationOptions::seeded(seed));
    let mut request = TestRig::request(mode);
    if reverse {
        std::mem::swap(&mut request.tilt_from_rad, &mut request.tilt_to_rad);
    }
    rig.sweep(&request, |_, _, _| {}).expect("a sweep")
}

/// Mean distance of the points from front, left and right wall and the floor of the room, millimetres; without points near
/// an edge.
fn offsets_mm(raw: &RawSweep) -> [f64; 4] {
    let sweep = assemble(raw).expect("assembles");
    let mut sums = [(0.0, 0_usize); 4];
    for p in &sweep.view.points {
        let off = [p.x - 2.0, p.y - 1.5, -p.y - 1.5, -p.z - 0.4];
        let near: Vec<usize> = (0..4).filter(|i| off[*i].abs() < 0.05).collect();
        if let [wall] = near[..] {
            let (sum, n) = &mut sums[wall];
            *sum += 1e3 * off[wall];
            *n += 1;
        }
    }
    sums.map(|(sum, n)| {
        assert!(n > 500, "{n} points");
        sum / n as f64
    })
}

#[test]
fn up_down_and_step_and_stare_measure_the_same_walls() {
    for seed in [5, 6, 7] {
        let up = offsets_mm(&raw(seed, SweepMode::Continuous, false));
        let down = offsets_mm(&raw(seed, SweepMode::Continuous, true));
        let step = offsets_mm(&raw(seed, SweepMode::Step, false));
        eprintln!(
            "walls in mm, front left right floor: up {up:.2?} down {down:.2?} step {step:.2?}"
        );
        for wall in 0..4 {
            let all = [up[wall], down[wall], step[wall]];
            let apart = all.iter().fold(f64::MIN, |a, b| a.max(*b))
                - all.iter().fold(f64::MAX, |a, b| a.min(*b));
            // The standard deviation of a range is 2.1 to 3.5 mm in this room.
            assert!(apart < 1.0, "wall {wall} is {apart:.2} mm apart");
        }
    }
}

#[test]
fn lines_follow_each_other_as_fast_as_the_mirror_turns() {
    for seed in [5, 6, 7] {
        let raw = raw(seed, SweepMode::Continuous, false);
        let quality = assemble(&raw).expect("assembles").quality;
        let segment = &raw.pan_segments[0];
        let (first, last) = (&segment.scans[0], &segment.scans[segment.scans.len() - 1]);
        let took_s = 1e-3 * (last.stamp_ms - first.stamp_ms) as f64;
        let over = took_s / (0.1 * (segment.scans.len() - 1) as f64);
        let (before, after): (Vec<&TimeSample>, Vec<&TimeSample>) = segment
            .time_samples
            .iter()
            .partition(|s| s.sent_s < first.arrived_s);
        let start_s = first.arrived_s - before[0].sent_s;
        let exchange_s =
            |samples: &[&TimeSample]| samples[samples.len() - 1].received_s - samples[0].sent_s;
        let end_s = after[after.len() - 1].received_s - last.arrived_s;
        eprintln!(
            "{} lines in {took_s:.3} s, {over:.4} of the ideal time; from the first exchange to the first line {start_s:.2} s (exchange {:.2} s), from the last line to the end {end_s:.2} s (exchange {:.2} s)",
            segment.scans.len(),
            exchange_s(&before),
            exchange_s(&after)
        );
        assert!(over <= 1.01, "{over}");
        assert_eq!((quality.gaps, quality.widest_gap_lines), (0, 0));
        assert!(start_s <= 1.2, "{start_s}");
    }
}
