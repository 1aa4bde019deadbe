//! The tables of scene files: one struct each, its keys and their defaults. Metres; degrees where the key says so;
//! positions in the map.
#![allow(
    missing_docs,
    reason = "keys are documented where name and unit are not enough"
)]

use serde::Deserialize;

/// A mistake in a table: the key, and what is wrong with its value.
pub(crate) type TableError = (&'static str, String);

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
    #[serde(default = "present")]
    pub floor: bool,
    #[serde(default = "present")]
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
    /// Height of its lower edge above the floor.
    #[serde(default)]
    pub from_m: f64,
    /// Height of its upper edge above the floor.
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

/// `[[superquadric]]`: upright, its equation's z along the map's.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuperquadricTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    pub centre: [f64; 3],
    pub size: [f64; 3],
    /// e1 (along z) and e2 (across): 0.1 is square, 1 round, 2 a rhombus.
    pub exponents: [f64; 2],
    #[serde(default)]
    pub yaw_deg: f64,
}

/// `[[person]]`: upright, the feet at `at`.
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

fn present() -> bool {
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

/// What the values of a key must be.
#[derive(Clone, Copy)]
pub(crate) enum NumberRule {
    Finite,
    /// Finite and above zero.
    Positive,
    /// From 0.1 to 2.
    Exponents,
    /// Finite and not all zero.
    Direction,
}

impl NumberRule {
    /// How `values` break it.
    pub(crate) fn violation(self, values: &[f64]) -> Option<String> {
        let finite = values.iter().all(|v| v.is_finite());
        let (valid, expected) = match self {
            Self::Finite => (finite, "be finite"),
            Self::Positive => (finite && values.iter().all(|v| *v > 0.0), "be above 0"),
            Self::Exponents => (
                values.iter().all(|v| (0.1..=2.0).contains(v)),
                "lie between 0.1 and 2",
            ),
            Self::Direction => {
                let length = values.iter().map(|v| v * v).sum::<f64>().sqrt();
                (finite && length > 1e-6, "be a direction of some length")
            }
        };
        let got: Vec<String> = values.iter().map(f64::to_string).collect();
        (!valid).then(|| format!("must {expected}, got {}", got.join(", ")))
    }
}

impl Opening {
    /// The first mistake in its numbers.
    pub fn first_error(&self) -> Option<TableError> {
        let numbers = [self.at_m, self.width_m, self.from_m, self.to_m];
        let valid =
            numbers.iter().all(|v| v.is_finite()) && self.width_m > 0.0 && self.from_m < self.to_m;
        (!valid).then(|| {
            (
                "openings",
                format!("must have width_m > 0 and from_m < to_m, got {self:?}"),
            )
        })
    }
}
