//! What scene files may furnish a place with: one struct per table, its keys, its checks, its solids.

use super::person;
use super::solid::{Form, Solid};
use crate::geometry::{Pose, RollPitchYaw};
use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;

/// A mistake in one table: the key, and what is wrong with it.
pub type Mistake = (&'static str, String);

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
    Person(PersonTable),
    Door(DoorTable),
}

/// `[[room]]`: a box seen from inside.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub centre: [f64; 3],
    pub size: [f64; 3],
    #[serde(default)]
    pub yaw_deg: f64,
    /// Whether it has a floor.
    #[serde(default = "yes")]
    pub floor: bool,
    /// Whether it has a ceiling.
    #[serde(default = "yes")]
    pub ceiling: bool,
    #[serde(default)]
    pub openings: Vec<Opening>,
}

/// A hole in a wall of a room.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Opening {
    pub wall: Wall,
    /// Middle of the opening along the wall: y of the room for front and back, x for left and right.
    #[serde(default)]
    pub at_m: f64,
    pub width_m: f64,
    /// Height above the room's floor where it begins.
    #[serde(default)]
    pub from_m: f64,
    /// Height above the room's floor where it ends.
    pub to_m: f64,
}

/// The walls of a room in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wall {
    /// +x.
    Front,
    /// -x.
    Back,
    /// +y.
    Left,
    /// -y.
    Right,
}

/// `[[box]]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub centre: [f64; 3],
    pub size: [f64; 3],
    #[serde(default)]
    pub yaw_deg: f64,
}

/// `[[cylinder]]`: closed at both ends.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CylinderTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub centre: [f64; 3],
    #[serde(default = "up")]
    pub axis: [f64; 3],
    pub radius_m: f64,
    pub length_m: f64,
}

/// `[[sphere]]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub centre: [f64; 3],
    pub radius_m: f64,
}

/// `[[plane]]`: a rectangle. Its width lies level; `spin_deg` turns it about the normal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub centre: [f64; 3],
    pub normal: [f64; 3],
    pub size: [f64; 2],
    #[serde(default)]
    pub spin_deg: f64,
}

/// `[[cone]]`: closed at its base, apex along `axis`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConeTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub base: [f64; 3],
    #[serde(default = "up")]
    pub axis: [f64; 3],
    pub radius_m: f64,
    pub height_m: f64,
}

/// `[[person]]`: stands with the feet at `at`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersonTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub at: [f64; 3],
    #[serde(default = "person_height")]
    pub height_m: f64,
    #[serde(default)]
    pub yaw_deg: f64,
}

/// `[[door]]`: a leaf that hangs at `hinge` (its lower end), points along `yaw_deg` when closed, and is turned by
/// `angle_deg` (counter-clockwise from above) when open.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub hinge: [f64; 3],
    #[serde(default)]
    pub yaw_deg: f64,
    pub width_m: f64,
    pub height_m: f64,
    #[serde(default = "door_thickness")]
    pub thickness_m: f64,
    #[serde(default)]
    pub angle_deg: f64,
}

fn yes() -> bool {
    true
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn person_height() -> f64 {
    1.75
}

fn door_thickness() -> f64 {
    0.04
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
fn pointing(at: [f64; 3], axis: [f64; 3], spin_deg: f64) -> Pose {
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
            Self::Person(t) => ("at", &mut t.at),
            Self::Door(t) => ("hinge", &mut t.hinge),
        }
    }

    /// Its `yaw_deg`, if the table has one.
    pub fn yaw_deg(&mut self) -> Option<&mut f64> {
        match self {
            Self::Room(t) => Some(&mut t.yaw_deg),
            Self::Box(t) => Some(&mut t.yaw_deg),
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
            Self::Room(t) => t.solids(),
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

/// What the numbers of a key must be.
#[derive(Clone, Copy)]
pub enum Rule {
    /// Finite.
    Finite,
    /// Finite and above zero.
    Positive,
    /// Finite and not all zero.
    Direction,
}

impl Rule {
    /// What `values` do wrong, if anything.
    pub fn broken_by(self, values: &[f64]) -> Option<String> {
        let finite = values.iter().all(|v| v.is_finite());
        let (kept, wanted) = match self {
            Self::Finite => (finite, "be finite"),
            Self::Positive => (finite && values.iter().all(|v| *v > 0.0), "be above 0"),
            Self::Direction => {
                let length = values.iter().map(|v| v * v).sum::<f64>().sqrt();
                (finite && length > 1e-6, "be a direction of some length")
            }
        };
        let got: Vec<String> = values.iter().map(f64::to_string).collect();
        (!kept).then(|| format!("must {wanted}, got {}", got.join(", ")))
    }
}

impl Opening {
    fn mistake(&self) -> Option<Mistake> {
        let numbers = [self.at_m, self.width_m, self.from_m, self.to_m];
        let good =
            numbers.iter().all(|v| v.is_finite()) && self.width_m > 0.0 && self.from_m < self.to_m;
        (!good).then(|| {
            (
                "openings",
                format!("must have width_m > 0 and from_m < to_m, got {self:?}"),
            )
        })
    }
}

impl RoomTable {
    fn solids(&self) -> Vec<Solid> {
        let half = Vector3::from(self.size) / 2.0;
        let map_from_room = upright(self.centre, self.yaw_deg);
        let side = |at: Vector3<f64>, half: [f64; 2], holes| {
            // `pointing` keeps x level: on a wall x runs along it and y upwards.
            let pose = map_from_room * pointing(at.into(), at.into(), 0.0);
            Solid::new(pose, Form::Rectangle { half, holes })
        };
        let wall = |wall: Wall| {
            let (at, along) = match wall {
                Wall::Front => (Vector3::x() * half.x, half.y),
                Wall::Back => (Vector3::x() * -half.x, half.y),
                Wall::Left => (Vector3::y() * half.y, half.x),
                Wall::Right => (Vector3::y() * -half.y, half.x),
            };
            // Level x of `pointing` is z cross the outward normal.
            let sign = match wall {
                Wall::Front | Wall::Right => 1.0,
                Wall::Back | Wall::Left => -1.0,
            };
            let holes = self
                .openings
                .iter()
                .filter(|o| o.wall == wall)
                .map(|o| {
                    let (x, reach) = (sign * o.at_m, o.width_m / 2.0);
                    [x - reach, x + reach, o.from_m - half.z, o.to_m - half.z]
                })
                .map(|[x0, x1, y0, y1]| {
                    // An opening down to the floor has no sill of rounding error.
                    [
                        x0,
                        x1,
                        if y0 <= -half.z { f64::NEG_INFINITY } else { y0 },
                        y1,
                    ]
                })
                .collect();
            side(at, [along, half.z], holes)
        };
        let mut solids: Vec<Solid> = [Wall::Front, Wall::Back, Wall::Left, Wall::Right]
            .map(wall)
            .into();
        for (there, z) in [(self.floor, -half.z), (self.ceiling, half.z)] {
            if there {
                solids.push(side(Vector3::z() * z, [half.x, half.y], Vec::new()));
            }
        }
        solids
    }
}
