//! Builds a place: walls, then furniture where there is room for it, then the robot.

use super::constants::{FURNITURE_TRIES, LASER_OVER_BASE_M, ROBOT_CLEARANCE_M, ROBOT_TRIES};
use super::furniture::{Furniture, FurniturePart};
use super::place::{OccupiedBox, SimulatedPlace, SupportSurface};
use super::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_sim::world::{
    Body, BoxTable, ConeTable, CylinderTable, Opening, Pose2d, RoomTable, SceneObject, SphereTable,
    Wall,
};

/// Pose of a piece of furniture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FurniturePose {
    /// The middle of its footprint, map frame, metres.
    pub at: Point3<f64>,
    /// Direction of its front, degrees.
    pub yaw_deg: f64,
}

/// A place under construction.
#[derive(Debug)]
pub(crate) struct PlaceBuilder<'d> {
    pub rng: &'d mut SeededRng,
    /// So far.
    pub objects: Vec<SceneObject>,
    /// Where objects can be put.
    pub supports: Vec<SupportSurface>,
    /// Objects that may be taken away.
    pub removable: Vec<String>,
    /// Names of doors.
    pub doors: Vec<String>,
    /// Space that stays free: where doors swing.
    pub clear: Vec<OccupiedBox>,
    /// Size of the room: x, y, z.
    pub size: [f64; 3],
    occupied: Vec<OccupiedBox>,
    pieces: usize,
}

impl<'d> PlaceBuilder<'d> {
    /// An empty space of this size about the origin, its floor at z = 0; [`Self::add_walls`] adds the walls.
    pub(crate) fn new(rng: &'d mut SeededRng, size: [f64; 3]) -> Self {
        Self {
            rng,
            objects: Vec::new(),
            supports: Vec::new(),
            removable: Vec::new(),
            doors: Vec::new(),
            clear: Vec::new(),
            size,
            occupied: Vec::new(),
            pieces: 0,
        }
    }

    pub(crate) fn add(&mut self, name: String, body: Body) {
        let object = SceneObject { name, body };
        self.occupied
            .extend(OccupiedBox::of_objects(std::slice::from_ref(&object)));
        self.objects.push(object);
    }

    /// Adds walls with these openings, a floor and a ceiling if wanted.
    pub(crate) fn add_walls(&mut self, openings: Vec<Opening>, floor: bool, ceiling: bool) {
        let [x, y, z] = self.size;
        let room = room([0.0, 0.0, z / 2.0], [x, y, z], openings, floor, ceiling);
        self.add("room".to_owned(), room);
    }

    /// Adds the whole floor as a support.
    pub(crate) fn add_floor(&mut self) {
        let [x, y, _] = self.size;
        self.supports.push(SupportSurface {
            centre: [0.0; 2],
            half: [x / 2.0, y / 2.0],
            yaw_deg: 0.0,
            z_m: 0.0,
            grade: 0.0,
            floor: true,
        });
    }

    /// Whether a piece fits at a pose with a gap around it.
    fn fits(&self, piece: &Furniture, pose: &FurniturePose, gap_m: f64) -> bool {
        let (sin, cos) = pose.yaw_deg.to_radians().sin_cos();
        let [x, y] = piece.half_footprint_m;
        let half = [
            (cos * x).abs() + (sin * y).abs(),
            (sin * x).abs() + (cos * y).abs(),
        ];
        let own = OccupiedBox::standing(pose.at, half, piece.height_m);
        let free = |b: &OccupiedBox| !b.collides(&own, gap_m);
        self.occupied.iter().all(free) && self.clear.iter().all(|b| !b.collides(&own, 0.0))
    }

    /// Puts a piece at a pose, whatever is there, and returns its name.
    pub(crate) fn put(&mut self, piece: &Furniture, pose: &FurniturePose) -> String {
        self.pieces += 1;
        let name = format!("{} {}", piece.name, self.pieces);
        let (sin, cos) = pose.yaw_deg.to_radians().sin_cos();
        let at = |p: &[f64; 3]| {
            [
                pose.at.x + cos * p[0] - sin * p[1],
                pose.at.y + sin * p[0] + cos * p[1],
                pose.at.z + p[2],
            ]
        };
        for (i, part) in piece.parts.iter().enumerate() {
            let body = match part {
                FurniturePart::Box(centre, size) => cuboid(at(centre), *size, pose.yaw_deg),
                FurniturePart::Upright(centre, radius, length) => {
                    cylinder(at(centre), [0.0, 0.0, 1.0], *radius, *length)
                }
                FurniturePart::Lying(centre, radius, length) => {
                    cylinder(at(centre), [-sin, cos, 0.0], *radius, *length)
                }
                FurniturePart::Sphere(centre, radius) => sphere(at(centre), *radius),
                FurniturePart::Cone(base, radius, height) => Body::Cone(ConeTable {
                    name: None,
                    reflectance: None,
                    base: at(base),
                    axis: [0.0, 0.0, 1.0],
                    radius_m: *radius,
                    height_m: *height,
                }),
            };
            self.add(format!("{name}/{i}"), body);
        }
        for (centre, half, height) in &piece.tops {
            let [x, y, z_m] = at(&[centre[0], centre[1], *height]);
            self.supports.push(SupportSurface {
                centre: [x, y],
                half: *half,
                yaw_deg: pose.yaw_deg,
                z_m,
                grade: 0.0,
                floor: false,
            });
        }
        if piece.removable {
            self.removable.push(name.clone());
        }
        name
    }

    /// Puts a piece somewhere on the floor where there is room, at a random yaw.
    pub(crate) fn put_anywhere(&mut self, piece: &Furniture) -> Option<FurniturePose> {
        let floors = self.floors();
        for _ in 0..FURNITURE_TRIES {
            let floor = self.rng.choose(&floors)?;
            let at = floor.random_point(self.rng, 0.0)?;
            let yaw_deg = self.rng.uniform(-180.0, 180.0);
            let pose = FurniturePose { at, yaw_deg };
            if self.fits(piece, &pose, 0.05) {
                self.put(piece, &pose);
                return Some(pose);
            }
        }
        None
    }

    /// Puts a piece with its back to a wall.
    pub(crate) fn put_at_wall(&mut self, piece: &Furniture) -> Option<FurniturePose> {
        let floors = self.floors();
        for _ in 0..FURNITURE_TRIES {
            let quarter = self.rng.integer(0, 3);
            let from_wall = piece.half_footprint_m[0] + self.rng.uniform(0.01, 0.06);
            let [x, y, _] = self.size.map(|s| s / 2.0);
            let along = self.rng.uniform(-1.0, 1.0);
            let [px, py] = match quarter {
                0 => [from_wall - x, along * y],
                1 => [along * x, from_wall - y],
                2 => [x - from_wall, along * y],
                _ => [along * x, y - from_wall],
            };
            let within = |f: &&SupportSurface| {
                (px - f.centre[0]).abs() <= f.half[0] && (py - f.centre[1]).abs() <= f.half[1]
            };
            let Some(floor) = floors.iter().find(within) else {
                continue;
            };
            let pose = FurniturePose {
                at: Point3::new(px, py, floor.height_at([px, py])),
                yaw_deg: 90.0 * quarter as f64 + self.rng.uniform(-0.5, 0.5),
            };
            if self.fits(piece, &pose, 0.005) {
                self.put(piece, &pose);
                return Some(pose);
            }
        }
        None
    }

    /// Puts a piece on a table, board or bench.
    pub(crate) fn put_on_top(&mut self, piece: &Furniture) -> Option<FurniturePose> {
        let tops: Vec<SupportSurface> =
            self.supports.iter().filter(|s| !s.floor).cloned().collect();
        let margin = piece.half_footprint_m[0].max(piece.half_footprint_m[1]);
        for _ in 0..FURNITURE_TRIES {
            let top = self.rng.choose(&tops)?;
            let yaw_deg = top.yaw_deg + self.rng.uniform(-8.0, 8.0);
            let Some(at) = top.random_point(self.rng, margin.min(top.half[0]).min(top.half[1]))
            else {
                continue;
            };
            let pose = FurniturePose { at, yaw_deg };
            if self.fits(piece, &pose, 0.01) {
                self.put(piece, &pose);
                return Some(pose);
            }
        }
        None
    }

    fn floors(&self) -> Vec<SupportSurface> {
        self.supports.iter().filter(|s| s.floor).cloned().collect()
    }

    /// Finishes with the robot on the floor within `area` (x from, x to, y from, y to), facing the middle of the room to
    /// within 60 degrees; `None` where there is no room for it.
    pub(crate) fn build_with_robot_in(self, area: [f64; 4]) -> Option<SimulatedPlace> {
        let floors = self.floors();
        let laser_m = self.rng.uniform(0.4, 1.2);
        for _ in 0..ROBOT_TRIES {
            let x = self.rng.uniform(area[0], area[1]);
            let y = self.rng.uniform(area[2], area[3]);
            let turn = self.rng.uniform(-60.0, 60.0_f64).to_radians();
            let on = |f: &&SupportSurface| {
                f.grade == 0.0
                    && (x - f.centre[0]).abs() <= f.half[0]
                    && (y - f.centre[1]).abs() <= f.half[1]
            };
            let Some(floor) = floors.iter().find(on) else {
                continue;
            };
            let at = Point3::new(x, y, floor.z_m);
            let own = OccupiedBox::standing(at, [ROBOT_CLEARANCE_M; 2], laser_m + 0.2);
            if self.occupied.iter().all(|b| !b.collides(&own, 0.0)) {
                let to_middle = (-y).atan2(-x);
                return Some(SimulatedPlace {
                    robot_pose: Pose2d {
                        x_m: x,
                        y_m: y,
                        yaw_rad: to_middle + turn,
                    },
                    base_height_m: floor.z_m + laser_m - LASER_OVER_BASE_M,
                    objects: self.objects,
                    supports: self.supports,
                    removable: self.removable,
                    doors: self.doors,
                });
            }
        }
        None
    }

    /// Finishes with the robot anywhere in the room.
    pub(crate) fn build_with_robot(self) -> Option<SimulatedPlace> {
        let [x, y, _] = self.size.map(|s| s / 2.0);
        self.build_with_robot_in([-x, x, -y, y])
    }
}

/// A room of the given openings, at yaw 0.
pub(crate) fn room(
    centre: [f64; 3],
    size: [f64; 3],
    openings: Vec<Opening>,
    floor: bool,
    ceiling: bool,
) -> Body {
    Body::Room(RoomTable {
        name: None,
        reflectance: None,
        centre,
        size,
        yaw_deg: 0.0,
        floor,
        ceiling,
        openings,
    })
}

pub(crate) fn opening(wall: Wall, at_m: f64, width_m: f64, from_m: f64, to_m: f64) -> Opening {
    Opening {
        wall,
        at_m,
        width_m,
        from_m,
        to_m,
    }
}

pub(crate) fn cuboid(centre: [f64; 3], size: [f64; 3], yaw_deg: f64) -> Body {
    Body::Box(BoxTable {
        name: None,
        reflectance: None,
        centre,
        size,
        yaw_deg,
    })
}

pub(crate) fn cylinder(centre: [f64; 3], axis: [f64; 3], radius_m: f64, length_m: f64) -> Body {
    Body::Cylinder(CylinderTable {
        name: None,
        reflectance: None,
        centre,
        axis,
        radius_m,
        length_m,
    })
}

pub(crate) fn sphere(centre: [f64; 3], radius_m: f64) -> Body {
    Body::Sphere(SphereTable {
        name: None,
        reflectance: None,
        centre,
        radius_m,
    })
}
