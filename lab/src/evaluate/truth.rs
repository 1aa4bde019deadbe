//! What is true of the points of a pair: which lie on things that changed, and whether the other visit looked there.

use super::constants::{SAME_M, THROUGH_M};
use super::place::thing_of;
use super::sensor::{BEAMS_PER_PROBE, Met, Setting, cast, meet};
use nalgebra::{Point3, Unit, Vector3};
use patrold_engine::geometry::Pose;
use patrold_sim::world::{Ray, World};

/// The truth about one point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Label {
    /// On nothing that changed.
    Other,
    /// On a thing that came, went or moved, where the other visit looked and met it not.
    Seen,
    /// On such a thing, where nothing came back at the other visit, and so far off that this proves nothing.
    Beyond,
    /// On such a thing, where the other visit could not look.
    Hidden,
    /// On such a thing, where it also was at the other visit (a door near its hinge): counts neither way.
    Same,
}

/// One visit: its world, and from where it was seen.
#[derive(Debug, Clone, Copy)]
pub struct Visit<'a> {
    /// What stood around.
    pub world: &'a World,
    /// Where the robot stood.
    pub map_from_base: Pose,
    /// Mean place of the laser, base frame.
    pub origin: Point3<f64>,
}

impl Visit<'_> {
    /// Which objects belong to one of these things.
    fn belonging(&self, things: &[String]) -> Vec<bool> {
        let belongs = |name: &str| things.iter().any(|t| t == thing_of(name));
        self.world
            .objects()
            .iter()
            .map(|o| belongs(&o.name))
            .collect()
    }

    /// What this visit knows about a place of the map where the other met a changed thing.
    fn looked_at(&self, place: &Point3<f64>, changed: &[bool], setting: &Setting) -> Label {
        let origin = self.map_from_base * self.origin;
        let way: Vector3<f64> = place - origin;
        let away_m = way.norm();
        let direction = Unit::new_normalize(way);
        if !setting
            .field
            .holds(&self.map_from_base.inverse_transform_vector(&way))
        {
            return Label::Hidden;
        }
        match meet(self.world, &Ray { origin, direction }, setting.reach_m) {
            Some(met) => {
                let on_thing = changed.get(met.object).copied().unwrap_or(false);
                if on_thing && (met.range_m - away_m).abs() < SAME_M {
                    Label::Same
                } else if met.range_m > away_m + THROUGH_M {
                    Label::Seen
                } else {
                    Label::Hidden
                }
            }
            None if away_m < setting.free_range_m => Label::Seen,
            None if away_m < setting.reach_m => Label::Beyond,
            None => Label::Hidden,
        }
    }
}

/// Labels of what `own` met, against the other visit.
pub fn labels(
    met: &[Met],
    own: &Visit<'_>,
    other: &Visit<'_>,
    things: &[String],
    setting: &Setting,
) -> Vec<Label> {
    let (mine, theirs) = (own.belonging(things), other.belonging(things));
    met.iter()
        .map(|m| {
            if mine.get(m.object).copied().unwrap_or(false) {
                other.looked_at(&m.at, &theirs, setting)
            } else {
                Label::Other
            }
        })
        .collect()
}

/// About how many points of a standard sweep lie on changed things where the other visit looked.
pub fn visible_points(
    own: &Visit<'_>,
    other: &Visit<'_>,
    things: &[String],
    setting: &Setting,
) -> usize {
    let lines = cast(
        own.world,
        &own.map_from_base,
        &setting.probe,
        setting.reach_m,
    );
    let met: Vec<Met> = lines.into_iter().flatten().flatten().collect();
    let labels = labels(&met, own, other, things, setting);
    let passed = |l: &&Label| matches!(l, Label::Seen | Label::Beyond);
    BEAMS_PER_PROBE * labels.iter().filter(passed).count()
}

/// Share of a ball's outline that is in view: rays over its disc that lie in the field and meet it first.
pub fn share_in_view(
    own: &Visit<'_>,
    centre: Point3<f64>,
    radius_m: f64,
    thing: &str,
    setting: &Setting,
) -> f64 {
    const RINGS: usize = 6;
    const AROUND: usize = 24;
    let origin = own.map_from_base * own.origin;
    let way = centre - origin;
    let across = way.cross(&Vector3::z()).normalize();
    let up = across.cross(&way).normalize();
    let mine = own.belonging(&[thing.to_owned()]);
    let (mut seen, mut all) = (0usize, 0usize);
    for ring in 0..RINGS {
        // Rings of equal area, within the outline by a hair.
        let off = 0.98 * radius_m * ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        for i in 0..AROUND {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / AROUND as f64).sin_cos();
            let aim = way + (across * cos + up * sin) * off;
            let direction = Unit::new_normalize(aim);
            all += 1;
            let in_field = setting
                .field
                .holds(&own.map_from_base.inverse_transform_vector(&aim));
            let met = meet(own.world, &Ray { origin, direction }, setting.reach_m);
            let first = met.is_some_and(|m| mine.get(m.object).copied().unwrap_or(false));
            seen += usize::from(in_field && first);
        }
    }
    seen as f64 / all as f64
}

impl Visit<'_> {
    /// Whether this visit looked through a place of the map.
    pub fn looks_through(&self, place: &Point3<f64>, setting: &Setting) -> bool {
        matches!(
            self.looked_at(place, &[], setting),
            Label::Seen | Label::Beyond
        )
    }
}
