//! The text of a scene file: its tables, and their lines for error messages.

use super::body::Body;
use super::scene_error::SceneError;
use super::tables::{
    BoxTable, ConeTable, CylinderTable, DoorTable, NumberRule, PersonTable, PlaneTable, RoomTable,
    SphereTable, SuperquadricTable, TableError,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// One scene file. Every table may be absent; a variant names what it `extends`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneFile {
    /// For people; not used.
    #[serde(default, rename = "description")]
    _description: Option<String>,
    /// The scene that this one changes.
    pub extends: Option<Spanned<String>>,
    /// Names of objects to remove.
    #[serde(default)]
    pub remove: Vec<Spanned<String>>,
    /// Objects to change, by name.
    #[serde(default)]
    pub set: BTreeMap<String, Spanned<SetTable>>,
    pub robot: Option<Spanned<RobotTable>>,
    pub cloud: Option<Spanned<CloudTable>>,
    #[serde(default, rename = "room")]
    rooms: Vec<Spanned<RoomTable>>,
    #[serde(default, rename = "box")]
    boxes: Vec<Spanned<BoxTable>>,
    #[serde(default, rename = "cylinder")]
    cylinders: Vec<Spanned<CylinderTable>>,
    #[serde(default, rename = "sphere")]
    spheres: Vec<Spanned<SphereTable>>,
    #[serde(default, rename = "plane")]
    planes: Vec<Spanned<PlaneTable>>,
    #[serde(default, rename = "cone")]
    cones: Vec<Spanned<ConeTable>>,
    #[serde(default, rename = "superquadric")]
    superquadrics: Vec<Spanned<SuperquadricTable>>,
    #[serde(default, rename = "person")]
    persons: Vec<Spanned<PersonTable>>,
    #[serde(default, rename = "door")]
    doors: Vec<Spanned<DoorTable>>,
}

/// `[set.NAME]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SetTable {
    /// New position, metres (the object's `centre`, `base`, `at` or `hinge`).
    pub at: Option<[f64; 3]>,
    /// New direction, degrees.
    pub yaw_deg: Option<f64>,
    /// New opening of a door, degrees.
    pub angle_deg: Option<f64>,
}

/// `[robot]`: pose of the robot.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RobotTable {
    /// x, y, metres.
    #[serde(default)]
    pub at: [f64; 2],
    /// Degrees, left positive.
    #[serde(default)]
    pub yaw_deg: f64,
    /// Height of the pan-tilt's base over the floor z = 0, metres.
    #[serde(default = "robot_height")]
    pub height_m: f64,
}

/// `[cloud]`: a recorded cloud as the surroundings.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CloudTable {
    pub name: Option<String>,
    pub reflectance: Option<f64>,
    /// As the caller that loads the scene finds it.
    pub file: String,
    /// Origin of the cloud's frame in the map, metres.
    #[serde(default)]
    pub at: [f64; 3],
    /// Rotation of the cloud in the map, degrees.
    #[serde(default)]
    pub yaw_deg: f64,
    /// Where the sensor was, in the frame of the cloud, metres.
    #[serde(default)]
    pub origin: [f64; 3],
}

fn robot_height() -> f64 {
    0.4
}

impl Default for RobotTable {
    fn default() -> Self {
        Self {
            at: [0.0; 2],
            yaw_deg: 0.0,
            height_m: robot_height(),
        }
    }
}

/// A scene file with its name, for error messages.
pub(crate) struct SceneText<'a> {
    pub name: &'a str,
    pub text: &'a str,
}

impl SceneText<'_> {
    /// The parsed file.
    ///
    /// # Errors
    /// [`SceneError::At`] with the line of the first mistake.
    pub(crate) fn parse(&self) -> Result<SceneFile, SceneError> {
        toml::from_str(self.text).map_err(|error| {
            let at = error.span().map_or(0, |s| s.start);
            self.error(at, None, error.message().replace('\n', "; "))
        })
    }

    /// An error at `key` of the table that begins at byte `at`, or at the first line of the table if the key is absent.
    pub(crate) fn error(
        &self,
        at: usize,
        key: Option<&str>,
        message: impl Into<String>,
    ) -> SceneError {
        let line_at = |at: usize| {
            self.text
                .get(..at)
                .unwrap_or(self.text)
                .matches('\n')
                .count()
        };
        let first = line_at(at);
        let line_of = |key: &str| {
            self.text
                .lines()
                .enumerate()
                .skip(first)
                .take_while(|(i, line)| *i == first || !line.trim_start().starts_with('['))
                .find(|(_, line)| {
                    let rest = line.trim_start().strip_prefix(key).map(str::trim_start);
                    rest.is_some_and(|rest| rest.starts_with('='))
                })
                .map(|(i, _)| i)
        };
        let message = message.into();
        SceneError::At {
            file: self.name.to_owned(),
            line: key.and_then(line_of).unwrap_or(first) + 1,
            message: key.map_or_else(|| message.clone(), |key| format!("`{key}` {message}")),
        }
    }

    /// An error in the table that begins at byte `at`.
    pub(crate) fn table_error(&self, at: usize, (key, message): TableError) -> SceneError {
        self.error(at, Some(key), message)
    }
}

impl SceneFile {
    /// All objects with the bytes where their tables begin, in file order.
    pub(crate) fn take_bodies(&mut self) -> Vec<(usize, Body)> {
        fn append<T>(
            out: &mut Vec<(usize, Body)>,
            tables: &mut Vec<Spanned<T>>,
            body: impl Fn(T) -> Body,
        ) {
            out.extend(
                tables
                    .drain(..)
                    .map(|t| (t.span().start, body(t.into_inner()))),
            );
        }
        let mut out = Vec::new();
        append(&mut out, &mut self.rooms, Body::Room);
        append(&mut out, &mut self.boxes, Body::Box);
        append(&mut out, &mut self.cylinders, Body::Cylinder);
        append(&mut out, &mut self.spheres, Body::Sphere);
        append(&mut out, &mut self.planes, Body::Plane);
        append(&mut out, &mut self.cones, Body::Cone);
        append(&mut out, &mut self.superquadrics, Body::Superquadric);
        append(&mut out, &mut self.persons, Body::Person);
        append(&mut out, &mut self.doors, Body::Door);
        out.sort_by_key(|(at, _)| *at);
        out
    }
}

impl RobotTable {
    /// The first mistake in its numbers.
    pub(crate) fn first_error(&self) -> Option<TableError> {
        [
            ("at", &self.at[..], NumberRule::Finite),
            ("yaw_deg", &[self.yaw_deg], NumberRule::Finite),
            ("height_m", &[self.height_m], NumberRule::Finite),
        ]
        .into_iter()
        .find_map(|(key, values, rule)| Some((key, rule.violation(values)?)))
    }
}

impl CloudTable {
    /// The first mistake in its numbers.
    pub(crate) fn first_error(&self) -> Option<TableError> {
        if let Some(r) = self.reflectance.filter(|r| !(0.0..=1.0).contains(r)) {
            return Some(("reflectance", format!("must lie in 0..=1, got {r}")));
        }
        [
            ("at", &self.at[..]),
            ("yaw_deg", &[self.yaw_deg]),
            ("origin", &self.origin[..]),
        ]
        .into_iter()
        .find_map(|(key, values)| Some((key, NumberRule::Finite.violation(values)?)))
    }
}
