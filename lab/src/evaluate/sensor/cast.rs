//! What beams truly meet.

use super::pattern::Pattern;
use nalgebra::Point3;
use patrold_engine::geometry::Pose;
use patrold_sim::world::{Ray, World};
use rayon::prelude::*;

/// What a beam meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Met {
    /// Metres.
    pub range_m: f64,
    /// Cosine of incidence.
    pub cos_incidence: f64,
    /// Share of light given back.
    pub reflectance: f64,
    /// Index of the object.
    pub object: usize,
    /// Where, map.
    pub at: Point3<f64>,
}

/// What a ray meets within reach.
pub fn meet(world: &World, ray: &Ray, reach_m: f64) -> Option<Met> {
    let hit = world.cast(ray, reach_m)?;
    Some(Met {
        range_m: hit.range_m,
        cos_incidence: hit.cos_incidence,
        reflectance: world.reflectance_of(hit.object),
        object: hit.object,
        at: ray.origin + ray.direction.into_inner() * hit.range_m,
    })
}

/// What every beam of the pattern meets within reach from a base at `map_from_base`, line by line.
pub fn cast(
    world: &World,
    map_from_base: &Pose,
    pattern: &Pattern,
    reach_m: f64,
) -> Vec<Vec<Option<Met>>> {
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
                    meet(world, &Ray { origin, direction }, reach_m)
                })
                .collect()
        })
        .collect()
}
