//! A laboratory: benches on thin legs full of equipment, stools, a fume hood, bottles, pipes under the ceiling.

use crate::evaluate::builder::{Builder, Stance, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture::{self as f, Part, Piece};
use crate::evaluate::place::Place;
use nalgebra::Point3;
use patrold_sim::world::Wall;

/// A laboratory of random size and clutter.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(4.5, 8.5),
        draw.within(4.0, 7.0),
        draw.within(2.6, 3.4),
    ];
    let mut b = Builder::new(draw, size);
    let door = Doorway::somewhere(&mut b, Wall::Back);
    let mut holes = vec![door.hole()];
    if b.draw.chance(0.5) {
        let width = b.draw.within(1.0, 3.0);
        holes.push(opening(
            Wall::Left,
            b.draw.within(-0.5, 0.5),
            width,
            1.0,
            2.2,
        ));
    }
    b.walls(holes, true, true);
    b.floor();
    door.furnish(&mut b);
    if b.draw.chance(0.6) {
        let hood = fume_hood(b.draw);
        b.at_wall(&hood);
    }
    for _ in 0..b.draw.count(2, 4) {
        let bench = f::table(b.draw);
        b.at_wall(&bench);
    }
    for _ in 0..b.draw.count(0, 2) {
        let island = f::table(b.draw);
        b.anywhere(&island);
    }
    for _ in 0..b.draw.count(0, 2) {
        let bottle = bottle(b.draw);
        b.at_wall(&bottle);
    }
    for _ in 0..b.draw.count(8, 24) {
        let piece = if b.draw.chance(0.5) {
            f::goods(b.draw, 0.5)
        } else {
            f::can(b.draw, 0.12)
        };
        b.on_top(&piece);
    }
    for _ in 0..b.draw.count(1, 5) {
        let piece = match b.draw.count(0, 3) {
            0 => f::bin(b.draw),
            1 => f::chair(b.draw),
            _ => f::stool(b.draw),
        };
        b.anywhere(&piece);
    }
    for i in 0..b.draw.count(0, 3) {
        let radius = b.draw.within(0.02, 0.12);
        let pipe = Piece {
            name: "pipe",
            parts: vec![Part::Lying([0.0; 3], radius, size[1] - 0.1)],
            half: [radius, size[1] / 2.0],
            height_m: radius,
            tops: Vec::new(),
            removable: false,
        };
        let at = Point3::new(0.5 * i as f64 - 0.5, 0.0, size[2] - 0.3);
        b.put(&pipe, &Stance { at, yaw_deg: 0.0 });
    }
    b.robot()
}

/// A fume hood: a low cupboard, above it a chamber open to the front.
fn fume_hood(draw: &mut Draw) -> Piece {
    let (deep, wide) = (draw.within(0.6, 0.8), draw.within(1.0, 1.6));
    let (low, high) = (0.9, draw.within(1.9, 2.3));
    let tall = high - low;
    let side = |y: f64| Part::Box([0.0, y, low + tall / 2.0], [deep, 0.04, tall]);
    Piece {
        name: "hood",
        parts: vec![
            Part::Box([0.0, 0.0, low / 2.0], [deep, wide, low]),
            side(wide / 2.0 - 0.02),
            side(0.02 - wide / 2.0),
            Part::Box(
                [0.02 - deep / 2.0, 0.0, low + tall / 2.0],
                [0.04, wide, tall],
            ),
            Part::Box([0.0, 0.0, high - 0.15], [deep, wide, 0.3]),
        ],
        half: [deep / 2.0, wide / 2.0],
        height_m: high,
        tops: vec![([0.0; 2], [deep / 2.0 - 0.1, wide / 2.0 - 0.1], low)],
        removable: false,
    }
}

/// A gas bottle.
fn bottle(draw: &mut Draw) -> Piece {
    let (radius, height) = (draw.within(0.1, 0.14), draw.within(1.1, 1.6));
    Piece {
        name: "bottle",
        parts: vec![
            Part::Upright([0.0, 0.0, height / 2.0], radius, height),
            Part::Ball([0.0, 0.0, height], radius),
        ],
        half: [radius; 2],
        height_m: height + radius,
        tops: Vec::new(),
        removable: true,
    }
}
