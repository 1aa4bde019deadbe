//! Puts a place together: walls, then furniture where there is room for it, then the robot.

use super::draw::Draw;
use super::furniture::{Part, Piece};
use super::place::{Block, Place, Support};
use nalgebra::Point3;
use patrold_sim::world::{
    Body, BoxTable, ConeTable, CylinderTable, Object, Opening, RoomTable, SphereTable, Stand, Wall,
};

/// How often a place for a piece is looked for.
const TRIES: usize = 30;
/// Free space about the middle of the robot, metres.
const ROBOT_HALF_M: f64 = 0.45;
/// Height of the laser over the pan-tilt's base with the head level, metres.
pub const LASER_OVER_BASE_M: f64 = 0.1796;

/// Where a piece stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// On what it stands, map.
    pub at: Point3<f64>,
    /// Where it looks, degrees.
    pub yaw_deg: f64,
}

/// A place that grows.
#[derive(Debug)]
pub struct Builder<'d> {
    /// The chance behind everything.
    pub draw: &'d mut Draw,
    /// Everything so far.
    pub objects: Vec<Object>,
    /// Where things can be put.
    pub supports: Vec<Support>,
    /// Things that may go.
    pub removable: Vec<String>,
    /// Doors.
    pub doors: Vec<String>,
    /// Space that stays free: where doors swing, where people walk.
    pub clear: Vec<Block>,
    /// Size of the room: x, y, z.
    pub size: [f64; 3],
    blocks: Vec<Block>,
    pieces: usize,
}

impl<'d> Builder<'d> {
    /// An empty room of this size about the origin, its floor at z = 0. Walls come by [`Self::walls`].
    pub fn new(draw: &'d mut Draw, size: [f64; 3]) -> Self {
        Self {
            draw,
            objects: Vec::new(),
            supports: Vec::new(),
            removable: Vec::new(),
            doors: Vec::new(),
            clear: Vec::new(),
            size,
            blocks: Vec::new(),
            pieces: 0,
        }
    }

    /// Adds a body.
    pub fn add(&mut self, name: String, body: Body) {
        let object = Object { name, body };
        self.blocks
            .extend(Block::all_of(std::slice::from_ref(&object)));
        self.objects.push(object);
    }

    /// Walls with these holes, and floor and ceiling where they are wanted.
    pub fn walls(&mut self, openings: Vec<Opening>, floor: bool, ceiling: bool) {
        let [x, y, z] = self.size;
        let room = room([0.0, 0.0, z / 2.0], [x, y, z], openings, floor, ceiling);
        self.add("room".to_owned(), room);
    }

    /// The whole floor as a support.
    pub fn floor(&mut self) {
        let [x, y, _] = self.size;
        self.supports.push(Support {
            centre: [0.0; 2],
            half: [x / 2.0, y / 2.0],
            yaw_deg: 0.0,
            z_m: 0.0,
            grade: 0.0,
            floor: true,
        });
    }

    /// Whether a piece fits at a stance with this much air around it.
    fn fits(&self, piece: &Piece, stance: &Stance, gap_m: f64) -> bool {
        let (sin, cos) = stance.yaw_deg.to_radians().sin_cos();
        let [x, y] = piece.half;
        let half = [
            (cos * x).abs() + (sin * y).abs(),
            (sin * x).abs() + (cos * y).abs(),
        ];
        let own = Block::standing(stance.at, half, piece.height_m);
        let free = |b: &Block| !b.meets(&own, gap_m);
        self.blocks.iter().all(free) && self.clear.iter().all(|b| !b.meets(&own, 0.0))
    }

    /// Puts a piece at a stance, whatever stands there; gives its name.
    pub fn put(&mut self, piece: &Piece, stance: &Stance) -> String {
        self.pieces += 1;
        let name = format!("{} {}", piece.name, self.pieces);
        let (sin, cos) = stance.yaw_deg.to_radians().sin_cos();
        let at = |p: &[f64; 3]| {
            [
                stance.at.x + cos * p[0] - sin * p[1],
                stance.at.y + sin * p[0] + cos * p[1],
                stance.at.z + p[2],
            ]
        };
        for (i, part) in piece.parts.iter().enumerate() {
            let body = match part {
                Part::Box(centre, size) => cuboid(at(centre), *size, stance.yaw_deg),
                Part::Upright(centre, radius, length) => {
                    cylinder(at(centre), [0.0, 0.0, 1.0], *radius, *length)
                }
                Part::Lying(centre, radius, length) => {
                    cylinder(at(centre), [-sin, cos, 0.0], *radius, *length)
                }
                Part::Ball(centre, radius) => ball(at(centre), *radius),
                Part::Cone(base, radius, height) => Body::Cone(ConeTable {
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
            self.supports.push(Support {
                centre: [x, y],
                half: *half,
                yaw_deg: stance.yaw_deg,
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

    /// Puts a piece somewhere on the floor where there is room, turned anyhow.
    pub fn anywhere(&mut self, piece: &Piece) -> Option<Stance> {
        let floors = self.floors();
        for _ in 0..TRIES {
            let floor = self.draw.pick(&floors)?;
            let at = floor.draw(self.draw, 0.0)?;
            let yaw_deg = self.draw.within(-180.0, 180.0);
            let stance = Stance { at, yaw_deg };
            if self.fits(piece, &stance, 0.05) {
                self.put(piece, &stance);
                return Some(stance);
            }
        }
        None
    }

    /// Puts a piece with its back to a wall.
    pub fn at_wall(&mut self, piece: &Piece) -> Option<Stance> {
        let floors = self.floors();
        for _ in 0..TRIES {
            let quarter = self.draw.count(0, 3);
            let off = piece.half[0] + self.draw.within(0.01, 0.06);
            let [x, y, _] = self.size.map(|s| s / 2.0);
            let along = self.draw.within(-1.0, 1.0);
            let [px, py] = match quarter {
                0 => [off - x, along * y],
                1 => [along * x, off - y],
                2 => [x - off, along * y],
                _ => [along * x, y - off],
            };
            let within = |f: &&Support| {
                (px - f.centre[0]).abs() <= f.half[0] && (py - f.centre[1]).abs() <= f.half[1]
            };
            let Some(floor) = floors.iter().find(within) else {
                continue;
            };
            let stance = Stance {
                at: Point3::new(px, py, floor.height_at([px, py])),
                yaw_deg: 90.0 * quarter as f64 + self.draw.within(-0.5, 0.5),
            };
            if self.fits(piece, &stance, 0.005) {
                self.put(piece, &stance);
                return Some(stance);
            }
        }
        None
    }

    /// Puts a piece on a table, board or bench.
    pub fn on_top(&mut self, piece: &Piece) -> Option<Stance> {
        let tops: Vec<Support> = self.supports.iter().filter(|s| !s.floor).cloned().collect();
        let rim = piece.half[0].max(piece.half[1]);
        for _ in 0..TRIES {
            let top = self.draw.pick(&tops)?;
            let yaw_deg = top.yaw_deg + self.draw.within(-8.0, 8.0);
            let Some(at) = top.draw(self.draw, rim.min(top.half[0]).min(top.half[1])) else {
                continue;
            };
            let stance = Stance { at, yaw_deg };
            if self.fits(piece, &stance, 0.01) {
                self.put(piece, &stance);
                return Some(stance);
            }
        }
        None
    }

    fn floors(&self) -> Vec<Support> {
        self.supports.iter().filter(|s| s.floor).cloned().collect()
    }

    /// Ends with the robot somewhere on the floor within `reach` (x from, x to, y from, y to), looking about at the
    /// room's middle; `None` where there is no room for it.
    pub fn robot_within(self, reach: [f64; 4]) -> Option<Place> {
        let floors = self.floors();
        let laser_m = self.draw.within(0.4, 1.2);
        for _ in 0..10 * TRIES {
            let x = self.draw.within(reach[0], reach[1]);
            let y = self.draw.within(reach[2], reach[3]);
            let turn = self.draw.within(-60.0, 60.0_f64).to_radians();
            let on = |f: &&Support| {
                f.grade == 0.0
                    && (x - f.centre[0]).abs() <= f.half[0]
                    && (y - f.centre[1]).abs() <= f.half[1]
            };
            let Some(floor) = floors.iter().find(on) else {
                continue;
            };
            let at = Point3::new(x, y, floor.z_m);
            let own = Block::standing(at, [ROBOT_HALF_M; 2], laser_m + 0.2);
            if self.blocks.iter().all(|b| !b.meets(&own, 0.0)) {
                let home = (-y).atan2(-x);
                return Some(Place {
                    stand: Stand {
                        x_m: x,
                        y_m: y,
                        yaw_rad: home + turn,
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

    /// Ends with the robot anywhere in the room.
    pub fn robot(self) -> Option<Place> {
        let [x, y, _] = self.size.map(|s| s / 2.0);
        self.robot_within([-x, x, -y, y])
    }
}

/// A room as a body.
pub fn room(
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

/// A hole in a wall.
pub fn opening(wall: Wall, at_m: f64, width_m: f64, from_m: f64, to_m: f64) -> Opening {
    Opening {
        wall,
        at_m,
        width_m,
        from_m,
        to_m,
    }
}

/// A box as a body.
pub fn cuboid(centre: [f64; 3], size: [f64; 3], yaw_deg: f64) -> Body {
    Body::Box(BoxTable {
        name: None,
        reflectance: None,
        centre,
        size,
        yaw_deg,
    })
}

/// A cylinder as a body.
pub fn cylinder(centre: [f64; 3], axis: [f64; 3], radius_m: f64, length_m: f64) -> Body {
    Body::Cylinder(CylinderTable {
        name: None,
        reflectance: None,
        centre,
        axis,
        radius_m,
        length_m,
    })
}

/// A ball as a body.
pub fn ball(centre: [f64; 3], radius_m: f64) -> Body {
    Body::Sphere(SphereTable {
        name: None,
        reflectance: None,
        centre,
        radius_m,
    })
}
