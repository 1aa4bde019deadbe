//! What scene files may furnish a place with: checks and solids of every table.

use super::person;
use super::room;
use super::solid::{Form, Solid};
use super::tables::{
    BoxTable, ConeTable, CylinderTable, DoorTable, Mistake, Opening, PersonTable, PlaneTable,
    RoomTable, Rule, SphereTable, SuperquadricTable,
};
use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};
use patrold_engine::geometry::{Pose, RollPitchYaw};

/// One thing of a scene, as its table gives it. Metres; degrees in keys that say so; `centre`, `at`, `base`, `hinge` in
/// the map.
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

/// The pose at `at` turned left by `yaw_deg`.
pub fn upright(at: [f64; 3], yaw_deg: f64) -> Pose {
    RollPitchYaw {
        roll_rad: 0.0,
        pitch_rad: 0.0,
        yaw_rad: yaw_deg.to_radians(),
    }
    .with_translation(at)
}

/// The pose at `at` whose z points along `axis` and whose x is level.
pub fn pointing(at: [f64; 3], axis: [f64; 3], spin_deg: f64) -> Pose {
    let axis = Vector3::from(axis)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::z);
    let level = Vector3::z()
        .cross(&axis)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::x);
    let rotation = Rotation3::from_basis_unchecked(&[level, axis.cross(&level), axis])
        * Rotation3::from_axis_angle(&Vector3::z_axis(), spin_deg.to_radians());
    Pose::from_parts(
        Translation3::from(Vector3::from(at)),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

impl Body {
    /// The table's name in scene files.
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
    pub fn label(&self) -> (Option<&str>, Option<f64>) {
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

    /// The key that says where it stands, and its value.
    pub fn place(&mut self) -> (&'static str, &mut [f64; 3]) {
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
    pub fn yaw_deg(&mut self) -> Option<&mut f64> {
        match self {
            Self::Room(t) => Some(&mut t.yaw_deg),
            Self::Box(t) => Some(&mut t.yaw_deg),
            Self::Superquadric(t) => Some(&mut t.yaw_deg),
            Self::Person(t) => Some(&mut t.yaw_deg),
            Self::Door(t) => Some(&mut t.yaw_deg),
            _ => None,
        }
    }

    /// The first mistake in its numbers, if there is one.
    pub fn mistake(&self) -> Option<Mistake> {
        let (_, reflectance) = self.label();
        if let Some(r) = reflectance.filter(|r| !(0.0..=1.0).contains(r)) {
            return Some(("reflectance", format!("must lie in 0..=1, got {r}")));
        }
        let place = self.clone().place().1.to_vec();
        let key = self.clone().place().0;
        let checks: Vec<(&'static str, &[f64], Rule)> = match self {
            Self::Room(t) => {
                if let Some(mistake) = t.openings.iter().find_map(Opening::mistake) {
                    return Some(mistake);
                }
                vec![
                    ("size", &t.size, Rule::Positive),
                    ("yaw_deg", std::slice::from_ref(&t.yaw_deg), Rule::Finite),
                ]
            }
            Self::Box(t) => vec![
                ("size", &t.size, Rule::Positive),
                ("yaw_deg", std::slice::from_ref(&t.yaw_deg), Rule::Finite),
            ],
            Self::Cylinder(t) => vec![
                ("axis", &t.axis, Rule::Direction),
                (
                    "radius_m",
                    std::slice::from_ref(&t.radius_m),
                    Rule::Positive,
                ),
                (
                    "length_m",
                    std::slice::from_ref(&t.length_m),
                    Rule::Positive,
                ),
            ],
            Self::Sphere(t) => vec![(
                "radius_m",
                std::slice::from_ref(&t.radius_m),
                Rule::Positive,
            )],
            Self::Plane(t) => vec![
                ("normal", &t.normal, Rule::Direction),
                ("size", &t.size, Rule::Positive),
                ("spin_deg", std::slice::from_ref(&t.spin_deg), Rule::Finite),
            ],
            Self::Cone(t) => vec![
                ("axis", &t.axis, Rule::Direction),
                (
                    "radius_m",
                    std::slice::from_ref(&t.radius_m),
                    Rule::Positive,
                ),
                (
                    "height_m",
                    std::slice::from_ref(&t.height_m),
                    Rule::Positive,
                ),
            ],
            Self::Superquadric(t) => vec![
                ("size", &t.size, Rule::Positive),
                ("exponents", &t.exponents, Rule::Exponents),
                ("yaw_deg", std::slice::from_ref(&t.yaw_deg), Rule::Finite),
            ],
            Self::Person(t) => vec![
                (
                    "height_m",
                    std::slice::from_ref(&t.height_m),
                    Rule::Positive,
                ),
                ("yaw_deg", std::slice::from_ref(&t.yaw_deg), Rule::Finite),
            ],
            Self::Door(t) => vec![
                ("width_m", std::slice::from_ref(&t.width_m), Rule::Positive),
                (
                    "height_m",
                    std::slice::from_ref(&t.height_m),
                    Rule::Positive,
                ),
                (
                    "thickness_m",
                    std::slice::from_ref(&t.thickness_m),
                    Rule::Positive,
                ),
                ("yaw_deg", std::slice::from_ref(&t.yaw_deg), Rule::Finite),
                (
                    "angle_deg",
                    std::slice::from_ref(&t.angle_deg),
                    Rule::Finite,
                ),
            ],
        };
        std::iter::once((key, place.as_slice(), Rule::Finite))
            .chain(checks)
            .find_map(|(key, values, rule)| Some((key, rule.broken_by(values)?)))
    }

    /// What stops rays.
    pub fn solids(&self) -> Vec<Solid> {
        match self {
            Self::Room(t) => room::solids(t),
            Self::Box(t) => vec![Solid::new(
                upright(t.centre, t.yaw_deg),
                Form::Cuboid {
                    half: Vector3::from(t.size) / 2.0,
                },
            )],
            Self::Cylinder(t) => vec![Solid::new(
                pointing(t.centre, t.axis, 0.0),
                Form::Cylinder {
                    radius: t.radius_m,
                    half_length: t.length_m / 2.0,
                },
            )],
            Self::Sphere(t) => vec![Solid::new(
                upright(t.centre, 0.0),
                Form::Sphere { radius: t.radius_m },
            )],
            Self::Plane(t) => vec![Solid::new(
                pointing(t.centre, t.normal, t.spin_deg),
                Form::Rectangle {
                    half: t.size.map(|s| s / 2.0),
                    holes: Vec::new(),
                },
            )],
            Self::Cone(t) => vec![Solid::new(
                pointing(t.base, t.axis, 0.0),
                Form::Cone {
                    radius: t.radius_m,
                    height: t.height_m,
                },
            )],
            Self::Superquadric(t) => vec![Solid::new(
                upright(t.centre, t.yaw_deg),
                Form::Superquadric {
                    half: Vector3::from(t.size) / 2.0,
                    exponents: t.exponents,
                },
            )],
            Self::Person(t) => person::solids(&upright(t.at, t.yaw_deg), t.height_m),
            Self::Door(t) => {
                let half = Vector3::new(t.width_m, t.thickness_m, t.height_m) / 2.0;
                let leaf = Pose::translation(half.x, 0.0, half.z);
                let hinge = upright(t.hinge, t.yaw_deg + t.angle_deg);
                vec![Solid::new(hinge * leaf, Form::Cuboid { half })]
            }
        }
    }
}
