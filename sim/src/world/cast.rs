//! The world for ray casting.

use super::bvh::{Aabb, Bvh};
use super::solid::Solid;
use super::surfel::Surfels;
use nalgebra::{Point3, Unit, Vector3};

/// A half-line in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, map frame, metres.
    pub origin: Point3<f64>,
    /// Its direction, map frame.
    pub direction: Unit<Vector3<f64>>,
}

/// What a ray hits first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray, metres.
    pub range_m: f64,
    /// Cosine of the angle between the ray and the surface's normal: 1 square, 0 grazing.
    pub cos_incidence: f64,
    /// Index into [`World::objects`].
    pub object: usize,
}

/// One named object of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectInfo {
    /// Name in the scene file, or kind and number.
    pub name: String,
    /// Share of light returned, 0 (never seen) to 1.
    pub reflectance: f64,
}

/// Everything that stops rays; immutable.
#[derive(Debug, Clone, Default)]
pub struct World {
    objects: Vec<ObjectInfo>,
    /// With the index of the object.
    solids: Vec<(Solid, usize)>,
    tree: Bvh,
    cloud: Option<(Surfels, usize)>,
}

impl World {
    /// A world of `objects`; solids and the cloud give the index of theirs.
    pub(super) fn new(
        objects: Vec<ObjectInfo>,
        solids: Vec<(Solid, usize)>,
        cloud: Option<(Surfels, usize)>,
    ) -> Self {
        let bounds: Vec<Aabb> = solids.iter().map(|(solid, _)| solid.bounds()).collect();
        Self {
            objects,
            solids,
            tree: Bvh::build(&bounds),
            cloud,
        }
    }

    /// The objects of the world; [`Hit::object`] is an index into it.
    pub fn objects(&self) -> &[ObjectInfo] {
        &self.objects
    }

    /// Share of light that the object returns; 1 where there is no such object.
    pub fn reflectance_of(&self, object: usize) -> f64 {
        self.objects.get(object).map_or(1.0, |o| o.reflectance)
    }

    /// The index of the object called `name`.
    pub fn object_named(&self, name: &str) -> Option<usize> {
        self.objects.iter().position(|o| o.name == name)
    }

    /// What `ray` hits first within `max_range_m` metres.
    pub fn cast(&self, ray: &Ray, max_range_m: f64) -> Option<Hit> {
        let (mut limit, mut best) = (max_range_m, None);
        let direction = ray.direction.into_inner();
        self.tree
            .visit_along_ray(&ray.origin, &direction, &mut limit, |i, limit| {
                if let Some((solid, object)) = self.solids.get(i)
                    && let Some((range_m, cos_incidence)) = solid.hit(&ray.origin, &direction)
                    && range_m < *limit
                {
                    *limit = range_m;
                    best = Some(Hit {
                        range_m,
                        cos_incidence,
                        object: *object,
                    });
                }
            });
        if let Some((surfels, object)) = &self.cloud
            && let Some((range_m, cos_incidence)) = surfels.hit(&ray.origin, &direction, limit)
        {
            best = Some(Hit {
                range_m,
                cos_incidence,
                object: *object,
            });
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::{Hit, ObjectInfo, Ray, World};
    use crate::world::solid::{Solid, SolidShape};
    use nalgebra::{Point3, Unit, Vector3};
    use patrold_engine::geometry::Pose;

    fn sphere(x: f64, object: usize) -> (Solid, usize) {
        let pose = Pose::translation(x, 0.0, 0.0);
        (Solid::new(pose, SolidShape::Sphere { radius: 0.5 }), object)
    }

    #[test]
    fn the_nearest_object_hides_the_others() {
        let objects = ["near", "far"].map(|name| ObjectInfo {
            name: name.to_owned(),
            reflectance: 0.5,
        });
        let solids = (0..20)
            .map(|i| sphere(f64::from(20 - i), usize::from(i != 17)))
            .collect();
        let world = World::new(objects.into(), solids, None);
        let ray = Ray {
            origin: Point3::new(1.9, 0.0, 0.0),
            direction: Unit::new_normalize(Vector3::x()),
        };
        let hit = world.cast(&ray, 10.0).expect("a sphere");
        assert!((hit.range_m - 0.6).abs() < 1e-9, "{hit:?}");
        assert_eq!(world.objects()[hit.object].name, "far");
        let from_between = Ray {
            origin: Point3::new(2.5 + 1e-6, 0.0, 0.0),
            ..ray
        };
        let Some(Hit { object, .. }) = world.cast(&from_between, 10.0) else {
            panic!("a sphere")
        };
        assert_eq!(Some(object), world.object_named("near"));
        assert_eq!(world.cast(&ray, 0.5), None);
        assert_eq!(World::default().cast(&ray, 10.0), None);
    }
}
