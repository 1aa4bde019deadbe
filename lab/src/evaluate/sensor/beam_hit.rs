//! What beams truly hit.

use super::beam_pattern::BeamPattern;
use nalgebra::Point3;
use patrold_engine::geometry::Pose;
use patrold_sim::world::{Ray, World};
use rayon::prelude::*;

/// What a beam hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamHit {
    /// Metres.
    pub range_m: f64,
    /// 1 square, 0 grazing.
    pub cos_incidence: f64,
    /// Share of light returned, 0 to 1.
    pub reflectance: f64,
    /// Index of the object in the world.
    pub object: usize,
    /// The point hit, map frame, metres.
    pub at: Point3<f64>,
}

/// What a ray hits within reach.
pub(crate) fn cast_ray(world: &World, ray: &Ray, reach_m: f64) -> Option<BeamHit> {
    let hit = world.cast(ray, reach_m)?;
    Some(BeamHit {
        range_m: hit.range_m,
        cos_incidence: hit.cos_incidence,
        reflectance: world.reflectance_of(hit.object),
        object: hit.object,
        at: ray.origin + ray.direction.into_inner() * hit.range_m,
    })
}

/// What every beam of the pattern hits within reach from a base at `map_from_base`, line by line.
pub(crate) fn cast_pattern(
    world: &World,
    map_from_base: &Pose,
    pattern: &BeamPattern,
    reach_m: f64,
) -> Vec<Vec<Option<BeamHit>>> {
    pattern
        .lines
        .par_iter()
        .map(|line| {
            let map_from_sensor = map_from_base * line.base_from_sensor;
            let origin = map_from_sensor * Point3::origin();
            line.directions
                .iter()
                .map(|d| {
                    let direction = map_from_sensor.rotation * *d;
                    cast_ray(world, &Ray { origin, direction }, reach_m)
                })
                .collect()
        })
        .collect()
}
