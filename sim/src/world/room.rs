//! Solids of a room.

use super::placement::{pointing, upright};
use super::solid::{Solid, SolidShape};
use super::tables::{RoomTable, Wall};
use nalgebra::Vector3;

/// Walls, floor and ceiling as rectangles, the walls with their holes.
pub(crate) fn solids(room: &RoomTable) -> Vec<Solid> {
    let half = Vector3::from(room.size) / 2.0;
    let map_from_room = upright(room.centre, room.yaw_deg);
    let side = |at: Vector3<f64>, half: [f64; 2], holes| {
        // `pointing` keeps x level: on a wall x runs along it and y upwards.
        let pose = map_from_room * pointing(at.into(), at.into(), 0.0);
        Solid::new(pose, SolidShape::Rectangle { half, holes })
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
        let holes = room
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
    for (present, z) in [(room.floor, -half.z), (room.ceiling, half.z)] {
        if present {
            solids.push(side(Vector3::z() * z, [half.x, half.y], Vec::new()));
        }
    }
    solids
}
