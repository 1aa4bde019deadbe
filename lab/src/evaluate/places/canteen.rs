//! A canteen or lobby: round tables on columns, many chairs, a counter, pillars, a glass front. Held out.

use crate::evaluate::builder::{Builder, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture::{self as f, Part, Piece};
use crate::evaluate::place::Place;
use patrold_sim::world::Wall;

/// A canteen of random size.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(6.0, 12.0),
        draw.within(5.0, 9.0),
        draw.within(2.6, 4.5),
    ];
    let mut b = Builder::new(draw, size);
    let door = Doorway::somewhere(&mut b, Wall::Back);
    let mut holes = vec![door.hole()];
    if b.draw.chance(0.7) {
        // Glass gives nothing back.
        let width = b.draw.within(2.0, 0.7 * size[0]);
        let sill = b.draw.within(0.05, 0.9);
        holes.push(opening(Wall::Left, 0.0, width, sill, 2.4));
    }
    b.walls(holes, true, true);
    b.floor();
    door.furnish(&mut b);
    if b.draw.chance(0.7) {
        let counter = counter(b.draw);
        b.at_wall(&counter);
    }
    for _ in 0..b.draw.count(0, 3) {
        let pillar = f::pillar(b.draw, size[2]);
        b.anywhere(&pillar);
    }
    for _ in 0..b.draw.count(2, 5) {
        let table = round_table(b.draw);
        b.anywhere(&table);
    }
    for _ in 0..b.draw.count(4, 12) {
        let chair = f::chair(b.draw);
        b.anywhere(&chair);
    }
    if b.draw.chance(0.5) {
        let screen = partition(b.draw);
        b.anywhere(&screen);
    }
    for _ in 0..b.draw.count(1, 5) {
        let piece = match b.draw.count(0, 2) {
            0 => f::plant(b.draw),
            1 => f::bin(b.draw),
            _ => f::bench(b.draw),
        };
        b.anywhere(&piece);
    }
    for _ in 0..b.draw.count(0, 5) {
        let piece = if b.draw.chance(0.5) {
            f::can(b.draw, 0.12)
        } else {
            f::goods(b.draw, 0.3)
        };
        b.on_top(&piece);
    }
    b.robot()
}

/// A round table on a column and a foot.
fn round_table(draw: &mut Draw) -> Piece {
    let (radius, height) = (draw.within(0.35, 0.6), draw.within(0.7, 1.1));
    let inner = radius / std::f64::consts::SQRT_2;
    Piece {
        name: "round table",
        parts: vec![
            Part::Upright([0.0, 0.0, height - 0.015], radius, 0.03),
            Part::Upright([0.0, 0.0, height / 2.0], 0.035, height - 0.04),
            Part::Upright([0.0, 0.0, 0.015], 0.6 * radius, 0.03),
        ],
        half: [radius; 2],
        height_m: height,
        tops: vec![([0.0; 2], [inner; 2], height)],
        removable: false,
    }
}

/// A counter with a board above it.
fn counter(draw: &mut Draw) -> Piece {
    let half = [draw.within(0.3, 0.45), draw.within(0.8, 1.8)];
    let height = draw.within(0.9, 1.1);
    Piece {
        name: "counter",
        parts: vec![
            Part::Box(
                [0.0, 0.0, height / 2.0],
                [1.7 * half[0], 2.0 * half[1], height],
            ),
            Part::Box(
                [0.0, 0.0, height + 0.02],
                [2.0 * half[0], 2.0 * half[1], 0.04],
            ),
        ],
        half,
        height_m: height + 0.04,
        tops: vec![([0.0; 2], half, height + 0.04)],
        removable: false,
    }
}

/// A thin partition on two feet, open below.
fn partition(draw: &mut Draw) -> Piece {
    let (wide, high) = (draw.within(0.8, 1.8), draw.within(1.3, 1.9));
    let foot = |y: f64| Part::Box([0.0, y, 0.08], [0.4, 0.05, 0.16]);
    Piece {
        name: "partition",
        parts: vec![
            Part::Box([0.0, 0.0, (high + 0.16) / 2.0], [0.04, wide, high - 0.16]),
            foot(wide / 2.0 - 0.1),
            foot(0.1 - wide / 2.0),
        ],
        half: [0.2, wide / 2.0],
        height_m: high,
        tops: Vec::new(),
        removable: true,
    }
}
