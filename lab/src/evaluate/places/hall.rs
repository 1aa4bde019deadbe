//! A hall: large, mostly empty, its ceiling and most walls out of reach.

use crate::evaluate::builder::{Builder, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture as f;
use crate::evaluate::place::Place;
use patrold_sim::world::Wall;

/// A hall of random size; the robot stands within some metres of a corner.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(9.0, 18.0),
        draw.within(7.0, 14.0),
        draw.within(3.5, 8.0),
    ];
    let mut b = Builder::new(draw, size);
    let [x, y, _] = size.map(|s| s / 2.0);
    let door = Doorway {
        wall: Wall::Left,
        at_m: b.draw.within(x - 4.5, x - 1.0),
        width_m: b.draw.within(0.85, 1.2),
        height_m: b.draw.within(2.0, 2.3),
    };
    let mut holes = vec![door.hole()];
    if b.draw.chance(0.4) {
        let sill = b.draw.within(0.0, 1.2);
        holes.push(opening(
            Wall::Front,
            b.draw.within(0.0, y - 1.5),
            2.5,
            sill,
            2.6,
        ));
    }
    b.walls(holes, true, true);
    b.floor();
    door.furnish(&mut b);
    for _ in 0..b.draw.count(1, 6) {
        let height = b.draw.within(2.5, size[2]);
        let pillar = f::pillar(b.draw, height);
        b.anywhere(&pillar);
    }
    for _ in 0..b.draw.count(1, 6) {
        let piece = match b.draw.count(0, 4) {
            0 => f::bench(b.draw),
            1 => f::plant(b.draw),
            2 => f::bin(b.draw),
            3 => f::cupboard(b.draw),
            _ => f::goods(b.draw, 0.9),
        };
        if b.draw.chance(0.5) {
            b.at_wall(&piece);
        } else {
            b.anywhere(&piece);
        }
    }
    // The corner at +x +y: one wall at least stays within reach.
    let (near, far) = (b.draw.within(0.8, 2.0), b.draw.within(2.5, 5.0));
    b.robot_within([x - far, x - near, y - far, y - near])
}
