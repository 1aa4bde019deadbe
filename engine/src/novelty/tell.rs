//! Things and their weights become novelties.

use super::quantify::{Balance, Side, split_settings};
use super::rim::rim;
use super::{Kind, Novelty, NoveltyError, Onlooker, SegmentSettings, Thing, moved};
use crate::geometry::Passage;
use crate::mixture::{Gaussian, split_until_flat};
use nalgebra::Point3;

/// Novelties as they are told: disappeared first, then appeared, positions in the current frame.
///
/// # Errors
/// A mixture that cannot be fitted.
pub(super) fn tell(
    things: &[Vec<Thing>; 2],
    sides: &[Side<'_>; 2],
    onlookers: &[Onlooker<'_>; 2],
    balance: &Balance,
    settings: &SegmentSettings,
) -> Result<Vec<Novelty>, NoveltyError> {
    let mut told = Vec::new();
    for (side, kind) in [(0, Kind::Disappeared), (1, Kind::Appeared)] {
        let shares = [&balance.disappeared, &balance.appeared][side];
        let own = sides[side].own;
        let current_from_own = match kind {
            Kind::Disappeared => onlookers[side].from_own,
            Kind::Appeared => Passage::identity(),
        };
        let mut of_things = vec![false; own.view.points.len()];
        for i in things[side].iter().flat_map(|thing| &thing.points) {
            of_things[*i] = true;
        }
        for (thing, (mass, contribution)) in things[side].iter().zip(shares) {
            let places: Vec<Point3<f64>> = thing
                .points
                .iter()
                .map(|i| current_from_own.carry(&own.view.points[*i]))
                .collect();
            let Some(moments) = Gaussian::of_points(&places) else {
                continue;
            };
            told.push(Novelty {
                kind,
                moved_from: None,
                points: thing.points.clone(),
                rim: rim(thing, own, &of_things, &onlookers[side], settings)
                    .carried(&current_from_own),
                moments,
                mixture: split_until_flat(&places, None, &split_settings(own))?,
                extent_m: extent(&places),
                places,
                mass: *mass,
                contribution: *contribution,
                support: thing.support,
            });
        }
    }
    moved::link(&mut told);
    Ok(told)
}

fn extent(places: &[Point3<f64>]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let (low, high) = places
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
                (low.min(p[axis]), high.max(p[axis]))
            });
        high - low
    })
}
