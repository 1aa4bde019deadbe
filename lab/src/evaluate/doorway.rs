//! Doorways: an opening in a wall, a leaf in it, and the room behind.

use super::builder::{PlaceBuilder, opening, room};
use super::place::OccupiedBox;
use patrold_sim::world::{Body, DoorTable, Opening, Wall};

/// A doorway of a room about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Doorway {
    pub wall: Wall,
    /// Middle of the doorway along the wall, metres (see [`Opening::at_m`]).
    pub at_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Height, metres.
    pub height_m: f64,
}

/// Direction of the outward normal of a wall, degrees.
fn outward_deg(wall: Wall) -> f64 {
    match wall {
        Wall::Front => 0.0,
        Wall::Left => 90.0,
        Wall::Back => 180.0,
        Wall::Right => -90.0,
    }
}

fn opposite(wall: Wall) -> Wall {
    match wall {
        Wall::Front => Wall::Back,
        Wall::Back => Wall::Front,
        Wall::Left => Wall::Right,
        Wall::Right => Wall::Left,
    }
}

impl Doorway {
    /// A doorway of usual size somewhere in `wall`.
    pub(crate) fn random(builder: &mut PlaceBuilder<'_>, wall: Wall) -> Self {
        let width_m = builder.rng.uniform(0.75, 1.1);
        let wall_length = match wall {
            Wall::Front | Wall::Back => builder.size[1],
            Wall::Left | Wall::Right => builder.size[0],
        };
        let reach = (wall_length / 2.0 - width_m / 2.0 - 0.15).max(0.0);
        Self {
            wall,
            at_m: builder.rng.uniform(-reach, reach),
            width_m,
            height_m: builder.rng.uniform(1.95, 2.1),
        }
    }

    /// The opening in the wall.
    pub(crate) fn opening(&self) -> Opening {
        opening(self.wall, self.at_m, self.width_m, 0.0, self.height_m)
    }

    /// Middle of the threshold and the outward normal, map frame.
    fn threshold(&self, size: [f64; 3]) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = outward_deg(self.wall).to_radians().sin_cos();
        let normal = [cos.round(), sin.round()];
        let middle = match self.wall {
            Wall::Front | Wall::Back => [normal[0] * size[0] / 2.0, self.at_m],
            Wall::Left | Wall::Right => [self.at_m, normal[1] * size[1] / 2.0],
        };
        (middle, normal)
    }

    /// Adds a leaf that opens into the room, shut or open, and keeps its swing clear; often also a room behind it, without
    /// which there is no return from there.
    pub(crate) fn furnish(&self, builder: &mut PlaceBuilder<'_>) {
        let (middle, normal) = self.threshold(builder.size);
        let along = [-normal[1], normal[0]];
        let side = builder.rng.sign();
        let hinge =
            [0, 1].map(|i| middle[i] - side * along[i] * self.width_m / 2.0 - normal[i] * 0.03);
        let opened = match builder.rng.integer(0, 2) {
            0 => builder.rng.uniform(15.0, 100.0),
            _ => 0.0,
        };
        let name = format!("door {}", builder.doors.len() + 1);
        let leaf = DoorTable {
            name: None,
            reflectance: None,
            hinge: [hinge[0], hinge[1], 0.0],
            yaw_deg: outward_deg(self.wall) + side * 90.0,
            width_m: self.width_m,
            height_m: self.height_m,
            thickness_m: 0.04,
            angle_deg: side * opened,
        };
        builder.add(name.clone(), Body::Door(leaf));
        builder.doors.push(name);
        let reach = self.width_m + 0.1;
        builder.clear.push(OccupiedBox {
            low: [middle[0] - reach, middle[1] - reach, 0.0],
            high: [middle[0] + reach, middle[1] + reach, 2.2],
        });
        if builder.rng.chance(0.6) {
            self.room_behind(builder, middle, normal);
        }
    }

    fn room_behind(&self, builder: &mut PlaceBuilder<'_>, middle: [f64; 2], normal: [f64; 2]) {
        const WALL_M: f64 = 0.06;
        let depth = builder.rng.uniform(1.2, 3.0);
        let wide = self.width_m + builder.rng.uniform(0.4, 2.0);
        let height = builder.rng.uniform(2.3, 2.8);
        let centre = [0, 1].map(|i| middle[i] + normal[i] * (WALL_M + depth / 2.0));
        let size = [0, 1].map(|i| if normal[i] == 0.0 { wide } else { depth });
        let body = room(
            [centre[0], centre[1], height / 2.0],
            [size[0], size[1], height],
            vec![opening(
                opposite(self.wall),
                0.0,
                self.width_m,
                0.0,
                self.height_m,
            )],
            true,
            true,
        );
        let number = builder.doors.len();
        builder.add(format!("behind {number}"), body);
    }
}
