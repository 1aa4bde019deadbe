//! An office: desks and chairs, cupboards and shelves at the walls, a window over a radiator, a door.

use crate::evaluate::builder::{Builder, Stance, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture as f;
use crate::evaluate::place::Place;
use nalgebra::Point3;
use patrold_sim::world::Wall;

/// An office of random size and furniture.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(4.0, 7.5),
        draw.within(3.4, 6.0),
        draw.within(2.4, 3.0),
    ];
    let mut b = Builder::new(draw, size);
    let door = Doorway::somewhere(&mut b, Wall::Right);
    let mut holes = vec![door.hole()];
    let windows = b.draw.count(0, 2);
    for i in 0..windows {
        let wall = [Wall::Front, Wall::Left][i];
        let width = b.draw.within(0.8, 1.8);
        let sill = b.draw.within(0.8, 1.1);
        let top = b.draw.within(1.9, 2.3);
        holes.push(opening(wall, b.draw.within(-0.6, 0.6), width, sill, top));
    }
    b.walls(holes, true, true);
    b.floor();
    door.furnish(&mut b);
    if windows > 0 {
        let radiator = f::radiator(b.draw);
        let at = Point3::new(size[0] / 2.0 - radiator.half[0] - 0.04, 0.0, 0.0);
        b.put(&radiator, &Stance { at, yaw_deg: 180.0 });
    }
    if b.draw.chance(0.3) {
        let pillar = f::pillar(b.draw, size[2]);
        b.anywhere(&pillar);
    }
    for _ in 0..b.draw.count(1, 3) {
        let desk = f::desk(b.draw);
        if b.draw.chance(0.7) {
            b.at_wall(&desk);
        } else {
            b.anywhere(&desk);
        }
    }
    for _ in 0..b.draw.count(1, 3) {
        let piece = if b.draw.chance(0.5) {
            f::cupboard(b.draw)
        } else {
            f::shelf(b.draw)
        };
        b.at_wall(&piece);
    }
    for _ in 0..b.draw.count(1, 4) {
        let chair = f::chair(b.draw);
        b.anywhere(&chair);
    }
    for _ in 0..b.draw.count(2, 10) {
        let goods = f::goods(b.draw, 0.35);
        b.on_top(&goods);
    }
    for _ in 0..b.draw.count(0, 2) {
        let piece = if b.draw.chance(0.5) {
            f::bin(b.draw)
        } else {
            f::plant(b.draw)
        };
        b.anywhere(&piece);
    }
    b.robot()
}
