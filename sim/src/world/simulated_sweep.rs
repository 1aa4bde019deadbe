//! Whole sweeps with the true object of every point, without devices.

use super::beam_fan::BeamFan;
use super::cast::World;
use super::constants::{FIRST_STEP, FREE_RANGE_M, LAST_STEP, MIN_RANGE_MM};
use super::laser::true_beam;
use super::noise::{NoiseOptions, TrueBeam};
use super::robot::SimulatedRobot;
use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::View;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::time::Duration;

/// The beams of a simulated sweep: one revolution per tilt, the head at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRows {
    /// Pan, radians.
    pub pan_rad: f64,
    /// Tilt of every row, radians.
    pub tilts_rad: Vec<f64>,
    /// Steps of every row.
    pub steps: RangeInclusive<u32>,
    /// Instant of the first row; later sweeps of one seed have other noise.
    pub start: Duration,
}

impl SweepRows {
    /// `rows` rows at even tilts (degrees), all measuring steps, straight ahead.
    pub fn evenly(from_deg: f64, to_deg: f64, rows: usize) -> Self {
        let step = (to_deg - from_deg) / rows.saturating_sub(1).max(1) as f64;
        Self {
            pan_rad: 0.0,
            tilts_rad: (0..rows)
                .map(|i| (from_deg + step * i as f64).to_radians())
                .collect(),
            steps: FIRST_STEP..=LAST_STEP,
            start: Duration::ZERO,
        }
    }

    /// The same rows at another time, hence with other noise.
    pub fn starting_at(self, start: Duration) -> Self {
        Self { start, ..self }
    }
}

/// A simulated sweep and its ground truth.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedSweep {
    /// The view in the base frame; its origin is the mean of the laser's positions.
    pub view: View,
    /// For every point of the view the index in [`World::objects`] of the object that the middle of its beam hit.
    pub objects: Vec<usize>,
}

/// The result of one row, in the order of its steps.
#[derive(Default)]
struct SweepRow {
    points: Vec<Point3<f64>>,
    objects: Vec<usize>,
    no_return: Vec<Unit<Vector3<f64>>>,
}

/// The sweep that `robot` takes in `world`: row by row in the order of `rows`, within a row by rising step. Row k begins
/// 100 ms after row k - 1. Rows are computed on all cores; the result does not depend on their number.
pub fn simulate_sweep(
    world: &World,
    robot: &SimulatedRobot,
    rows: &SweepRows,
    noise: &NoiseOptions,
) -> SimulatedSweep {
    let simulated: Vec<SweepRow> = rows
        .tilts_rad
        .par_iter()
        .enumerate()
        .map(|(k, tilt)| {
            let start =
                rows.start + Duration::from_millis(100) * u32::try_from(k).unwrap_or(u32::MAX);
            simulate_row(world, robot, rows, *tilt, noise, start)
        })
        .collect();
    let mut origin = Vector3::zeros();
    for tilt in &rows.tilts_rad {
        origin += robot
            .mount
            .base_from_laser(rows.pan_rad, *tilt)
            .translation
            .vector;
    }
    let mut view = View::from_points(
        Vec::new(),
        Point3::from(origin / rows.tilts_rad.len().max(1) as f64),
    );
    view.free_range_m = FREE_RANGE_M;
    view.noise = Some(noise.law());
    view.tilt_axis = Some(robot.mount.tilt_axis(rows.pan_rad));
    let mut objects = Vec::new();
    for row in simulated {
        view.points.extend(row.points);
        view.no_return.extend(row.no_return);
        objects.extend(row.objects);
    }
    SimulatedSweep { view, objects }
}

fn simulate_row(
    world: &World,
    robot: &SimulatedRobot,
    rows: &SweepRows,
    tilt_rad: f64,
    noise: &NoiseOptions,
    start: Duration,
) -> SweepRow {
    let fan = BeamFan::default();
    let base_from_laser = robot.mount.base_from_laser(rows.pan_rad, tilt_rad);
    let map_from_laser = robot.map_from_base * base_from_laser;
    let truth: Vec<Option<(TrueBeam, usize)>> = rows
        .steps
        .clone()
        .map(|step| true_beam(world, &fan.beam(step, &map_from_laser), noise.reach_mm[1]))
        .collect();
    let beams: Vec<Option<TrueBeam>> = truth.iter().map(|t| t.map(|(beam, _)| beam)).collect();
    let mut row = SweepRow::default();
    let values = noise.measure(&beams, start);
    for ((value, truth), step) in values.into_iter().zip(truth).zip(rows.steps.clone()) {
        let direction = fan.direction(step);
        if value == 0 {
            row.no_return.push(base_from_laser.rotation * direction);
        } else if let (true, Some((_, object))) = (f64::from(value) >= MIN_RANGE_MM, truth) {
            let in_laser = Point3::from(direction.into_inner() * (f64::from(value) / 1000.0));
            row.points.push(base_from_laser * in_laser);
            row.objects.push(object);
        }
    }
    row
}

#[cfg(test)]
mod tests;
