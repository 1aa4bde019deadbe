//! True labels of the points of a pair: which lie on changed objects, and what the other visit saw there.

use super::constants::{ON_SURFACE_M, SEEN_THROUGH_M};
use super::place::object_name;
use super::sensor::{BEAMS_PER_PROBE, BeamHit, SensorSetup, cast_pattern, cast_ray};
use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::Pose;
use patrold_sim::world::{Ray, World};

/// The true label of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PointLabel {
    /// On an unchanged object.
    Unchanged,
    /// On an object that appeared, disappeared or moved, where the other visit saw free space.
    FreeSpace,
    /// On such an object, where the other visit got no return, beyond the range up to which this proves free space.
    BeyondFreeRange,
    /// On such an object, where the other visit could not see.
    NotVisible,
    /// On such an object, where its surface also was at the other visit (a door near its hinge): not counted.
    OnSurface,
}

/// One visit: its world, and from where the laser saw it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SimulatedVisit<'a> {
    pub world: &'a World,
    pub map_from_base: Pose,
    /// Mean position of the laser, base frame.
    pub origin: Point3<f64>,
}

impl SimulatedVisit<'_> {
    /// For every object of the world whether it is one of `names`, or a part of one.
    fn belongs_to(&self, names: &[String]) -> Vec<bool> {
        let belongs = |name: &str| names.iter().any(|n| n == object_name(name));
        self.world
            .objects()
            .iter()
            .map(|o| belongs(&o.name))
            .collect()
    }

    /// What this visit saw at a point of the map at which the other hit a changed object.
    fn label(&self, point: &Point3<f64>, changed: &[bool], setup: &SensorSetup) -> PointLabel {
        let origin = self.map_from_base * self.origin;
        let to_point: Vector3<f64> = point - origin;
        let distance_m = to_point.norm();
        let direction = Unit::new_normalize(to_point);
        if !setup
            .field
            .contains(&self.map_from_base.inverse_transform_vector(&to_point))
        {
            return PointLabel::NotVisible;
        }
        match cast_ray(self.world, &Ray { origin, direction }, setup.reach_m) {
            Some(hit) => {
                let on_changed = changed.get(hit.object).copied().unwrap_or(false);
                if on_changed && (hit.range_m - distance_m).abs() < ON_SURFACE_M {
                    PointLabel::OnSurface
                } else if hit.range_m > distance_m + SEEN_THROUGH_M {
                    PointLabel::FreeSpace
                } else {
                    PointLabel::NotVisible
                }
            }
            None if distance_m < setup.free_range_m => PointLabel::FreeSpace,
            None if distance_m < setup.reach_m => PointLabel::BeyondFreeRange,
            None => PointLabel::NotVisible,
        }
    }

    /// Whether this visit saw through a point of the map.
    pub(crate) fn saw_through(&self, point: &Point3<f64>, setup: &SensorSetup) -> bool {
        matches!(
            self.label(point, &[], setup),
            PointLabel::FreeSpace | PointLabel::BeyondFreeRange
        )
    }
}

/// Labels of what the beams of `own` hit, against the other visit; `changed` are the names of the changed objects.
pub(crate) fn point_labels(
    hits: &[BeamHit],
    own: &SimulatedVisit<'_>,
    other: &SimulatedVisit<'_>,
    changed: &[String],
    setup: &SensorSetup,
) -> Vec<PointLabel> {
    let (own_changed, other_changed) = (own.belongs_to(changed), other.belongs_to(changed));
    hits.iter()
        .map(|hit| {
            if own_changed.get(hit.object).copied().unwrap_or(false) {
                other.label(&hit.at, &other_changed, setup)
            } else {
                PointLabel::Unchanged
            }
        })
        .collect()
}

/// About how many points of a standard sweep lie on changed objects where the other visit looked.
pub(crate) fn visible_points(
    own: &SimulatedVisit<'_>,
    other: &SimulatedVisit<'_>,
    changed: &[String],
    setup: &SensorSetup,
) -> usize {
    let lines = cast_pattern(own.world, &own.map_from_base, &setup.probe, setup.reach_m);
    let hits: Vec<BeamHit> = lines.into_iter().flatten().flatten().collect();
    let labels = point_labels(&hits, own, other, changed, setup);
    let looked = |l: &&PointLabel| matches!(l, PointLabel::FreeSpace | PointLabel::BeyondFreeRange);
    BEAMS_PER_PROBE * labels.iter().filter(looked).count()
}

/// Visible share of the outline of the ball `name`: rays over its disc that lie in the field of view and hit it first.
pub(crate) fn share_in_view(
    own: &SimulatedVisit<'_>,
    centre: Point3<f64>,
    radius_m: f64,
    name: &str,
    setup: &SensorSetup,
) -> f64 {
    const RINGS: usize = 6;
    const RAYS_PER_RING: usize = 24;
    let origin = own.map_from_base * own.origin;
    let to_centre = centre - origin;
    let across = to_centre.cross(&Vector3::z()).normalize();
    let up = across.cross(&to_centre).normalize();
    let is_ball = own.belongs_to(&[name.to_owned()]);
    let (mut visible, mut all) = (0usize, 0usize);
    for ring in 0..RINGS {
        // Rings of equal area, a little within the outline.
        let off = 0.98 * radius_m * ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        for i in 0..RAYS_PER_RING {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / RAYS_PER_RING as f64).sin_cos();
            let aim = to_centre + (across * cos + up * sin) * off;
            let direction = Unit::new_normalize(aim);
            all += 1;
            let in_field = setup
                .field
                .contains(&own.map_from_base.inverse_transform_vector(&aim));
            let hit = cast_ray(own.world, &Ray { origin, direction }, setup.reach_m);
            let first = hit.is_some_and(|h| is_ball.get(h.object).copied().unwrap_or(false));
            visible += usize::from(in_field && first);
        }
    }
    visible as f64 / all as f64
}
