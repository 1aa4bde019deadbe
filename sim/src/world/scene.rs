//! Scenes: the objects of one file and of those it extends.

use super::body::Body;
use super::cast::{ObjectInfo, World};
use super::constants::DEFAULT_REFLECTANCE;
use super::placement::upright;
use super::scene_error::SceneError;
use super::scene_file::{CloudTable, RobotTable, SceneFile, SceneText};
use super::surfel::Surfels;
use nalgebra::Point3;
use patrold_engine::geometry::Pose;
use std::path::Path;

/// Scenes may extend each other this deep; more is taken for a cycle.
const MAX_DEPTH: usize = 8;

/// One object of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneObject {
    /// Unique: as given, or kind and number (`box 2`).
    pub name: String,
    /// Its shape and position.
    pub body: Body,
}

/// A recorded cloud and its pose in the map.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedCloud {
    /// Unique.
    pub name: String,
    /// File of the points, from where the scene's own name begins.
    pub file: String,
    /// Pose of the cloud in the map.
    pub map_from_cloud: Pose,
    /// Where the sensor was, in the frame of the cloud, metres.
    pub origin: Point3<f64>,
    /// Share of light returned, 0 to 1.
    pub reflectance: f64,
}

/// The objects of a place, and the pose of the robot in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Pose of the pan-tilt's base.
    pub map_from_base: Pose,
    /// In file order.
    pub objects: Vec<SceneObject>,
    /// A recorded cloud as the surroundings.
    pub cloud: Option<PlacedCloud>,
}

/// A difference between two scenes: the truth that a verdict is compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneChange {
    /// Name of the object.
    pub name: String,
    /// Centre of its bounding box in the first scene, map frame, metres; `None` if it is not there.
    pub before: Option<Point3<f64>>,
    /// The same in the second scene.
    pub after: Option<Point3<f64>>,
}

/// The name of a file that the scene `name` calls `file`.
fn beside(name: &str, file: &str) -> String {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    folder.join(file).to_string_lossy().into_owned()
}

impl Scene {
    /// The scene of one file that extends no other.
    ///
    /// # Errors
    /// [`SceneError`] with line and key of the first mistake.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Self::resolve("scene", &|name| match name {
            "scene" => Ok(text.to_owned()),
            _ => Err("a scene given as text cannot extend another".to_owned()),
        })
    }

    /// The scene called `name`; `load` returns the text of a scene by its name, or an error. A name in a scene is that of a
    /// file beside it, in its own folder.
    ///
    /// # Errors
    /// [`SceneError`] with file, line and key of the first mistake.
    pub fn resolve(
        name: &str,
        load: &dyn Fn(&str) -> Result<String, String>,
    ) -> Result<Self, SceneError> {
        let mut scene = Self::resolve_to_depth(name, load, 0)?;
        // Numbered last, so that numbers count within the whole scene.
        let mut counts = std::collections::BTreeMap::new();
        for object in &mut scene.objects {
            let count = counts.entry(object.body.kind()).or_insert(0);
            *count += 1;
            if object.name.is_empty() {
                object.name = format!("{} {count}", object.body.kind());
            }
        }
        Ok(scene)
    }

    fn resolve_to_depth(
        name: &str,
        load: &dyn Fn(&str) -> Result<String, String>,
        depth: usize,
    ) -> Result<Self, SceneError> {
        let text = load(name).map_err(|message| SceneError::Load {
            file: name.to_owned(),
            message,
        })?;
        let source = SceneText { name, text: &text };
        let mut file = source.parse()?;
        let mut scene = match file.extends.take() {
            None => Self {
                map_from_base: pose_of(&RobotTable::default()),
                objects: Vec::new(),
                cloud: None,
            },
            Some(base) if depth + 1 == MAX_DEPTH => {
                let message = format!("leads through {MAX_DEPTH} scenes: a cycle?");
                return Err(source.error(base.span().start, Some("extends"), message));
            }
            Some(base) => Self::resolve_to_depth(&beside(name, base.get_ref()), load, depth + 1)?,
        };
        scene.apply(&source, file)?;
        Ok(scene)
    }

    /// Applies `file`: removes, changes and adds objects.
    fn apply(&mut self, source: &SceneText<'_>, mut file: SceneFile) -> Result<(), SceneError> {
        for name in &file.remove {
            let before = self.objects.len();
            self.objects.retain(|o| o.name != *name.get_ref());
            if self.objects.len() == before {
                let message = self.unknown_name(name.get_ref());
                return Err(source.error(name.span().start, None, format!("`remove` {message}")));
            }
        }
        for (name, table) in &file.set {
            let (at, set) = (table.span().start, table.get_ref());
            let unknown = self.unknown_name(name);
            let Some(object) = self.objects.iter_mut().find(|o| o.name == *name) else {
                return Err(source.error(at, None, format!("`set` {unknown}")));
            };
            let kind = object.body.kind();
            let not_a_key = |key| source.error(at, Some(key), format!("is not a key of a {kind}"));
            if let Some(position) = set.at {
                *object.body.position_mut().1 = position;
            }
            if let Some(yaw_deg) = set.yaw_deg {
                *object
                    .body
                    .yaw_deg_mut()
                    .ok_or_else(|| not_a_key("yaw_deg"))? = yaw_deg;
            }
            if let Some(angle_deg) = set.angle_deg {
                let Body::Door(door) = &mut object.body else {
                    return Err(not_a_key("angle_deg"));
                };
                door.angle_deg = angle_deg;
            }
            if let Some((key, message)) = object.body.first_error() {
                let key = if object.body.position_mut().0 == key {
                    "at"
                } else {
                    key
                };
                return Err(source.table_error(at, (key, message)));
            }
        }
        for (at, body) in file.take_bodies() {
            if let Some(error) = body.first_error() {
                return Err(source.table_error(at, error));
            }
            let name = body.name_and_reflectance().0.unwrap_or_default().to_owned();
            if !name.is_empty() && self.objects.iter().any(|o| o.name == name) {
                return Err(source.error(at, Some("name"), format!("is taken: `{name}`")));
            }
            self.objects.push(SceneObject { name, body });
        }
        if let Some(robot) = file.robot {
            if let Some(error) = robot.get_ref().first_error() {
                return Err(source.table_error(robot.span().start, error));
            }
            self.map_from_base = pose_of(robot.get_ref());
        }
        if let Some(cloud) = file.cloud {
            if let Some(error) = cloud.get_ref().first_error() {
                return Err(source.table_error(cloud.span().start, error));
            }
            let mut cloud = cloud.into_inner();
            cloud.file = beside(source.name, &cloud.file);
            self.cloud = Some(PlacedCloud::from_table(cloud));
        }
        Ok(())
    }

    fn unknown_name(&self, name: &str) -> String {
        let names: Vec<&str> = self
            .objects
            .iter()
            .map(|o| o.name.as_str())
            .filter(|n| !n.is_empty())
            .collect();
        format!("names `{name}`, expected one of: {}", names.join(", "))
    }

    /// The world for ray casting. `cloud` are the points of [`PlacedCloud::file`], in their own frame.
    ///
    /// # Errors
    /// [`SceneError::Cloud`] if the scene has a cloud and `cloud` has no finite point.
    pub fn build(&self, cloud: Option<&[Point3<f64>]>) -> Result<World, SceneError> {
        let mut objects = Vec::new();
        let mut solids = Vec::new();
        for object in &self.objects {
            solids.extend(object.body.solids().into_iter().map(|s| (s, objects.len())));
            objects.push(ObjectInfo {
                name: object.name.clone(),
                reflectance: object
                    .body
                    .name_and_reflectance()
                    .1
                    .unwrap_or(DEFAULT_REFLECTANCE),
            });
        }
        let surfels = match &self.cloud {
            None => None,
            Some(placed) => {
                let missing = |got| SceneError::Cloud {
                    file: placed.file.clone(),
                    got,
                };
                let points: Vec<Point3<f64>> = cloud
                    .ok_or_else(|| missing("none"))?
                    .iter()
                    .filter(|p| p.iter().all(|c| c.is_finite()))
                    .map(|p| placed.map_from_cloud * p)
                    .collect();
                if points.is_empty() {
                    return Err(missing("no finite point"));
                }
                objects.push(ObjectInfo {
                    name: placed.name.clone(),
                    reflectance: placed.reflectance,
                });
                let sensor = placed.map_from_cloud * placed.origin;
                let surfels = Surfels::from_points(&points, &sensor);
                Some((surfels, objects.len() - 1))
            }
        };
        Ok(World::new(objects, solids, surfels))
    }

    /// The differences between `before` and `self`, by name of the object.
    pub fn changes_since(&self, before: &Self) -> Vec<SceneChange> {
        let find = |scene: &Self, name: &str| -> Option<SceneObject> {
            scene.objects.iter().find(|o| o.name == name).cloned()
        };
        let removed = before
            .objects
            .iter()
            .filter(|o| find(self, &o.name).is_none());
        let new_or_changed = self
            .objects
            .iter()
            .filter(|o| find(before, &o.name).as_ref() != Some(o));
        removed
            .chain(new_or_changed)
            .map(|o| SceneChange {
                name: o.name.clone(),
                before: find(before, &o.name).and_then(|o| o.centre()),
                after: find(self, &o.name).and_then(|o| o.centre()),
            })
            .collect()
    }
}

impl SceneObject {
    /// Centre of its bounding box along the map's axes, metres.
    pub fn centre(&self) -> Option<Point3<f64>> {
        let bounds = self
            .body
            .solids()
            .iter()
            .map(|s| s.bounds())
            .collect::<Vec<_>>();
        let low = bounds.iter().map(|b| b.low).reduce(|a, b| a.inf(&b))?;
        let high = bounds.iter().map(|b| b.high).reduce(|a, b| a.sup(&b))?;
        Some(nalgebra::center(&low, &high))
    }
}

impl PlacedCloud {
    fn from_table(table: CloudTable) -> Self {
        Self {
            name: table.name.unwrap_or_else(|| "cloud".to_owned()),
            file: table.file,
            map_from_cloud: upright(table.at, table.yaw_deg),
            origin: Point3::from(table.origin),
            reflectance: table.reflectance.unwrap_or(DEFAULT_REFLECTANCE),
        }
    }
}

fn pose_of(robot: &RobotTable) -> Pose {
    let [x, y] = robot.at;
    upright([x, y, robot.height_m], robot.yaw_deg)
}

#[cfg(test)]
mod tests {
    use super::Scene;
    use crate::world::{Ray, SceneError};
    use nalgebra::{Point3, Unit, Vector3};

    const ROOM: &str = r#"
[robot]
at = [0.5, 0.0]
yaw_deg = 90
height_m = 0.3

[[room]]
name = "hall"
centre = [0, 0, 1.25]
size = [8, 4, 2.5]
openings = [
    { wall = "front", at_m = 1.0, width_m = 0.8, to_m = 2.0 },
    { wall = "left", at_m = 2.0, width_m = 1.0, from_m = 1.0, to_m = 2.0 },
]

[[door]]
name = "door"
hinge = [4.0, 0.6, 0]
yaw_deg = 90
width_m = 0.8
height_m = 2.0

[[sphere]]
centre = [-2, 0, 1]
radius_m = 0.5
reflectance = 0.9
"#;

    fn seen(scene: &Scene, direction: [f64; 3]) -> Option<(String, f64)> {
        let world = scene.build(None).expect("no cloud in it");
        let ray = Ray {
            origin: Point3::new(0.0, 0.0, 1.0),
            direction: Unit::new_normalize(Vector3::from(direction)),
        };
        let hit = world.cast(&ray, 100.0)?;
        Some((
            world.objects()[hit.object].name.clone(),
            (hit.range_m * 1e6).round() / 1e6,
        ))
    }

    fn variant(text: &str) -> Result<Scene, SceneError> {
        Scene::resolve("variant.toml", &|name| match name {
            "variant.toml" => Ok(text.to_owned()),
            "room.toml" => Ok(ROOM.to_owned()),
            _ => Err("no such file".to_owned()),
        })
    }

    #[test]
    fn a_room_is_seen_from_inside_with_its_openings() {
        let scene = Scene::parse(ROOM).expect("a good scene");
        let at = |d| seen(&scene, d);
        assert_eq!(at([1.0, 0.0, 0.0]), Some(("hall".to_owned(), 4.0)));
        assert_eq!(at([0.0, 1.0, 0.0]), Some(("hall".to_owned(), 2.0)));
        assert_eq!(at([0.0, 0.0, 1.0]), Some(("hall".to_owned(), 1.5)));
        assert_eq!(at([0.0, 0.0, -1.0]), Some(("hall".to_owned(), 1.0)));
        assert_eq!(at([-1.0, 0.0, 0.0]), Some(("sphere 1".to_owned(), 1.5)));
        // The doorway is shut by the leaf's near face; the window is open.
        let (name, range) = at([4.0, 1.0, 0.0]).expect("the door");
        assert_eq!(name, "door");
        assert!((range - 17f64.sqrt() * 3.98 / 4.0).abs() < 1e-6);
        assert_eq!(at([2.0, 2.0, 0.5]), None);
        assert_eq!(at([2.0, 2.0, -0.1]).map(|s| s.0), Some("hall".to_owned()));
        // The room's mirror image of the doorway is wall.
        assert_eq!(at([4.0, -1.0, 0.0]), Some(("hall".to_owned(), 4.123106)));
        assert!(
            (scene.map_from_base * Point3::new(1.0, 0.0, 0.0) - Point3::new(0.5, 1.0, 0.3)).norm()
                < 1e-12
        );
    }

    #[test]
    fn a_variant_opens_a_door_removes_and_adds_objects() {
        let text = r#"
extends = "room.toml"
[set.door]
angle_deg = 90
[[person]]
name = "stranger"
at = [-3, 0, 0]
"#;
        let scene = variant(text).expect("a good variant");
        let before = Scene::parse(ROOM).expect("a good scene");
        assert_eq!(seen(&scene, [4.0, 1.0, 0.0]), None);
        // The open leaf points along -x from the hinge.
        assert_eq!(
            seen(&scene, [3.5, 0.58, 0.0]).map(|s| s.0),
            Some("door".to_owned())
        );
        let names: Vec<_> = scene
            .changes_since(&before)
            .into_iter()
            .map(|c| (c.name, c.before.is_some(), c.after.is_some()))
            .collect();
        assert_eq!(
            names,
            [
                ("door".to_owned(), true, true),
                ("stranger".to_owned(), false, true)
            ]
        );

        let scene = variant("extends = 'room.toml'\nremove = ['door']\n").expect("a good variant");
        let changes = scene.changes_since(&before);
        assert_eq!(changes.len(), 1);
        let middle = changes[0].before.expect("it was there");
        assert!(
            (middle - Point3::new(4.0, 1.0, 1.0)).norm() < 1e-9,
            "{middle}"
        );
        assert_eq!(changes[0].after, None);
        assert_eq!(before.changes_since(&before), []);
    }

    #[test]
    fn a_person_has_head_and_legs() {
        let scene = Scene::parse("[[person]]\nat = [2, 0, 0]\nheight_m = 2.0\n").expect("a person");
        assert_eq!(
            seen(&scene, [2.0, 0.0, 0.88]),
            Some((
                "person 1".to_owned(),
                ((2.0f64.hypot(0.88) - 0.12) * 1e6).round() / 1e6
            ))
        );
        // Between the legs.
        assert_eq!(seen(&scene, [2.0, 0.0, -0.5]), None);
        assert!(seen(&scene, [2.0, 0.11, -0.5]).is_some());
    }

    #[test]
    fn a_cloud_must_be_given() {
        let scene = Scene::parse("[cloud]\nfile = \"hall.ply\"\nat = [1, 0, 0]\nyaw_deg = 90\n")
            .expect("a cloud scene");
        assert_eq!(
            scene.build(None).expect_err("no points").to_string(),
            "scene needs the points of `hall.ply`, got none"
        );
        assert!(
            scene
                .build(Some(&[Point3::new(f64::NAN, 0.0, 0.0)]))
                .is_err()
        );
        let wall: Vec<_> = (-50..50)
            .flat_map(|i| {
                (-50..50).map(move |j| Point3::new(f64::from(i) * 0.02, 2.0, f64::from(j) * 0.02))
            })
            .collect();
        let world = scene.build(Some(&wall)).expect("points");
        let ray = Ray {
            origin: Point3::new(1.0, 0.0, 0.0),
            direction: Unit::new_normalize(-Vector3::x()),
        };
        let hit = world.cast(&ray, 10.0).expect("the wall, turned to -x");
        assert!((hit.range_m - 2.0).abs() < 1e-9 && (hit.cos_incidence - 1.0).abs() < 1e-9);
        assert_eq!(world.object_named("cloud"), Some(hit.object));
    }

    #[test]
    fn errors_name_line_and_key() {
        let cases = [
            (
                "[[sphere]]\ncentre = [0, 0, 0]\nradius_m = -1\n",
                "variant.toml:3: `radius_m` must be above 0, got -1",
            ),
            (
                "[[box]]\ncentre = [0, nan, 0]\nsize = [1, 1, 1]\n",
                "variant.toml:2: `centre` must be finite, got 0, NaN, 0",
            ),
            (
                "\n[[box]]\ncentre = [0, 0, 0]\nsize = [1, 1, 1]\ncolour = 3\n",
                "variant.toml:5: unknown field `colour`, expected one of `name`, `reflectance`, `centre`, `size`, `yaw_deg`",
            ),
            (
                "[[box]]\ncentre = [0, 0]\nsize = [1, 1, 1]\n",
                "variant.toml:2: invalid length 2, expected an array of length 3",
            ),
            (
                "[[cylinder]]\ncentre = [0, 0, 0]\nradius_m = 1\nlength_m = 1\naxis = [0, 0, 0]\n",
                "variant.toml:5: `axis` must be a direction of some length, got 0, 0, 0",
            ),
            (
                "[[box]]\ncentre = [0, 0, 0]\nsize = [1, 1, 1]\nname = 'a'\n[[sphere]]\nradius_m = 1\ncentre = [0, 0, 0]\nname = 'a'\n",
                "variant.toml:8: `name` is taken: `a`",
            ),
            (
                "extends = 'room.toml'\nremove = [\n'hall',\n'chair']\n",
                "variant.toml:4: `remove` names `chair`, expected one of: door",
            ),
            (
                "extends = 'room.toml'\n[set.chair]\nat = [0, 0, 0]\n",
                "variant.toml:2: `set` names `chair`, expected one of: hall, door",
            ),
            (
                "extends = 'room.toml'\n[set.hall]\nangle_deg = 1\n",
                "variant.toml:3: `angle_deg` is not a key of a room",
            ),
            (
                "extends = 'room.toml'\n[set.door]\nat = [0, 0, inf]\n",
                "variant.toml:3: `at` must be finite, got 0, 0, inf",
            ),
            ("extends = 'none.toml'\n", "scene `none.toml`: no such file"),
            (
                "extends = 'variant.toml'\n",
                "variant.toml:1: `extends` leads through 8 scenes: a cycle?",
            ),
            (
                "[robot]\nheight_m = nan\n",
                "variant.toml:2: `height_m` must be finite, got NaN",
            ),
            (
                "[[box]]\nreflectance = 2\ncentre = [0, 0, 0]\nsize = [1, 1, 1]\n",
                "variant.toml:2: `reflectance` must lie in 0..=1, got 2",
            ),
        ];
        for (text, message) in cases {
            assert_eq!(variant(text).expect_err(text).to_string(), message);
        }
    }
}
