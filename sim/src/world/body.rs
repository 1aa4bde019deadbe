//! Objects of scene files: the checks and the solids of every table.

use super::person;
use super::placement::{pointing, upright};
use super::room;
use super::solid::{Solid, SolidShape};
use super::tables::{
    BoxTable, ConeTable, CylinderTable, DoorTable, NumberRule, Opening, PersonTable, PlaneTable,
    RoomTable, SphereTable, SuperquadricTable, TableError,
};
use nalgebra::Vector3;
use patrold_engine::geometry::Pose;

/// One object of a scene, as its table gives it. Metres; degrees where the key says so; positions in the map.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the tables are documented at their structs")]
pub enum Body {
    Room(RoomTable),
    Box(BoxTable),
    Cylinder(CylinderTable),
    Sphere(SphereTable),
    Plane(PlaneTable),
    Cone(ConeTable),
    Superquadric(SuperquadricTable),
    Person(PersonTable),
    Door(DoorTable),
}

impl Body {
    /// Name of the table in scene files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Room(_) => "room",
            Self::Box(_) => "box",
            Self::Cylinder(_) => "cylinder",
            Self::Sphere(_) => "sphere",
            Self::Plane(_) => "plane",
            Self::Cone(_) => "cone",
            Self::Superquadric(_) => "superquadric",
            Self::Person(_) => "person",
            Self::Door(_) => "door",
        }
    }

    /// `name` and `reflectance` as given.
    pub fn name_and_reflectance(&self) -> (Option<&str>, Option<f64>) {
        let (name, reflectance) = match self {
            Self::Room(t) => (&t.name, t.reflectance),
            Self::Box(t) => (&t.name, t.reflectance),
            Self::Cylinder(t) => (&t.name, t.reflectance),
            Self::Sphere(t) => (&t.name, t.reflectance),
            Self::Plane(t) => (&t.name, t.reflectance),
            Self::Cone(t) => (&t.name, t.reflectance),
            Self::Superquadric(t) => (&t.name, t.reflectance),
            Self::Person(t) => (&t.name, t.reflectance),
            Self::Door(t) => (&t.name, t.reflectance),
        };
        (name.as_deref(), reflectance)
    }

    /// The key of its position, and the value.
    pub fn position_mut(&mut self) -> (&'static str, &mut [f64; 3]) {
        match self {
            Self::Room(t) => ("centre", &mut t.centre),
            Self::Box(t) => ("centre", &mut t.centre),
            Self::Cylinder(t) => ("centre", &mut t.centre),
            Self::Sphere(t) => ("centre", &mut t.centre),
            Self::Plane(t) => ("centre", &mut t.centre),
            Self::Cone(t) => ("base", &mut t.base),
            Self::Superquadric(t) => ("centre", &mut t.centre),
            Self::Person(t) => ("at", &mut t.at),
            Self::Door(t) => ("hinge", &mut t.hinge),
        }
    }

    /// Its `yaw_deg`, if the table has one.
    pub fn yaw_deg_mut(&mut self) -> Option<&mut f64> {
        match self {
            Self::Room(t) => Some(&mut t.yaw_deg),
            Self::Box(t) => Some(&mut t.yaw_deg),
            Self::Superquadric(t) => Some(&mut t.yaw_deg),
            Self::Person(t) => Some(&mut t.yaw_deg),
            Self::Door(t) => Some(&mut t.yaw_deg),
            _ => None,
        }
    }

    /// The first mistake in its numbers.
    pub fn first_error(&self) -> Option<TableError> {
        let (_, reflectance) = self.name_and_reflectance();
        if let Some(r) = reflectance.filter(|r| !(0.0..=1.0).contains(r)) {
            return Some(("reflectance", format!("must lie in 0..=1, got {r}")));
        }
        let position = self.clone().position_mut().1.to_vec();
        let key = self.clone().position_mut().0;
        let checks: Vec<(&'static str, &[f64], NumberRule)> = match self {
            Self::Room(t) => {
                if let Some(error) = t.openings.iter().find_map(Opening::first_error) {
                    return Some(error);
                }
                vec![
                    ("size", &t.size, NumberRule::Positive),
                    (
                        "yaw_deg",
                        std::slice::from_ref(&t.yaw_deg),
                        NumberRule::Finite,
                    ),
                ]
            }
            Self::Box(t) => vec![
                ("size", &t.size, NumberRule::Positive),
                (
                    "yaw_deg",
                    std::slice::from_ref(&t.yaw_deg),
                    NumberRule::Finite,
                ),
            ],
            Self::Cylinder(t) => vec![
                ("axis", &t.axis, NumberRule::Direction),
                (
                    "radius_m",
                    std::slice::from_ref(&t.radius_m),
                    NumberRule::Positive,
                ),
                (
                    "length_m",
                    std::slice::from_ref(&t.length_m),
                    NumberRule::Positive,
                ),
            ],
            Self::Sphere(t) => vec![(
                "radius_m",
                std::slice::from_ref(&t.radius_m),
                NumberRule::Positive,
            )],
            Self::Plane(t) => vec![
                ("normal", &t.normal, NumberRule::Direction),
                ("size", &t.size, NumberRule::Positive),
                (
                    "spin_deg",
                    std::slice::from_ref(&t.spin_deg),
                    NumberRule::Finite,
                ),
            ],
            Self::Cone(t) => vec![
                ("axis", &t.axis, NumberRule::Direction),
                (
                    "radius_m",
                    std::slice::from_ref(&t.radius_m),
                    NumberRule::Positive,
                ),
                (
                    "height_m",
                    std::slice::from_ref(&t.height_m),
                    NumberRule::Positive,
                ),
            ],
            Self::Superquadric(t) => vec![
                ("size", &t.size, NumberRule::Positive),
                ("exponents", &t.exponents, NumberRule::Exponents),
                (
                    "yaw_deg",
                    std::slice::from_ref(&t.yaw_deg),
                    NumberRule::Finite,
                ),
            ],
            Self::Person(t) => vec![
                (
                    "height_m",
                    std::slice::from_ref(&t.height_m),
                    NumberRule::Positive,
                ),
                (
                    "yaw_deg",
                    std::slice::from_ref(&t.yaw_deg),
                    NumberRule::Finite,
                ),
            ],
            Self::Door(t) => vec![
                (
                    "width_m",
                    std::slice::from_ref(&t.width_m),
                    NumberRule::Positive,
                ),
                (
                    "height_m",
                    std::slice::from_ref(&t.height_m),
                    NumberRule::Positive,
                ),
                (
                    "thickness_m",
                    std::slice::from_ref(&t.thickness_m),
                    NumberRule::Positive,
                ),
                (
                    "yaw_deg",
                    std::slice::from_ref(&t.yaw_deg),
                    NumberRule::Finite,
                ),
                (
                    "angle_deg",
                    std::slice::from_ref(&t.angle_deg),
                    NumberRule::Finite,
                ),
            ],
        };
        std::iter::once((key, position.as_slice(), NumberRule::Finite))
            .chain(checks)
            .find_map(|(key, values, rule)| Some((key, rule.violation(values)?)))
    }

    /// The solids that stop rays.
    pub fn solids(&self) -> Vec<Solid> {
        match self {
            Self::Room(t) => room::solids(t),
            Self::Box(t) => vec![Solid::new(
                upright(t.centre, t.yaw_deg),
                SolidShape::Cuboid {
                    half: Vector3::from(t.size) / 2.0,
                },
            )],
            Self::Cylinder(t) => vec![Solid::new(
                pointing(t.centre, t.axis, 0.0),
                SolidShape::Cylinder {
                    radius: t.radius_m,
                    half_length: t.length_m / 2.0,
                },
            )],
            Self::Sphere(t) => vec![Solid::new(
                upright(t.centre, 0.0),
                SolidShape::Sphere { radius: t.radius_m },
            )],
            Self::Plane(t) => vec![Solid::new(
                pointing(t.centre, t.normal, t.spin_deg),
                SolidShape::Rectangle {
                    half: t.size.map(|s| s / 2.0),
                    holes: Vec::new(),
                },
            )],
            Self::Cone(t) => vec![Solid::new(
                pointing(t.base, t.axis, 0.0),
                SolidShape::Cone {
                    radius: t.radius_m,
                    height: t.height_m,
                },
            )],
            Self::Superquadric(t) => vec![Solid::new(
                upright(t.centre, t.yaw_deg),
                SolidShape::Superquadric {
                    half: Vector3::from(t.size) / 2.0,
                    exponents: t.exponents,
                },
            )],
            Self::Person(t) => person::solids(&upright(t.at, t.yaw_deg), t.height_m),
            Self::Door(t) => {
                let half = Vector3::new(t.width_m, t.thickness_m, t.height_m) / 2.0;
                let leaf = Pose::translation(half.x, 0.0, half.z);
                let hinge = upright(t.hinge, t.yaw_deg + t.angle_deg);
                vec![Solid::new(hinge * leaf, SolidShape::Cuboid { half })]
            }
        }
    }
}
