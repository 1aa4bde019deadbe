//! A corridor: long and narrow, doors and niches at its sides, ends often out of reach, little that stands about.

use crate::evaluate::builder::{Builder, Stance, opening, room};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture as f;
use crate::evaluate::place::Place;
use nalgebra::Point3;
use patrold_sim::world::Wall;

/// A corridor of random length and width.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(7.0, 22.0),
        draw.within(1.7, 2.8),
        draw.within(2.2, 3.0),
    ];
    let mut b = Builder::new(draw, size);
    let mut doors: Vec<Doorway> = Vec::new();
    for _ in 0..b.draw.count(2, 5) {
        let wall = [Wall::Left, Wall::Right][b.draw.count(0, 1)];
        let door = Doorway::somewhere(&mut b, wall);
        let apart = |d: &Doorway| d.wall != door.wall || (d.at_m - door.at_m).abs() > 1.6;
        if doors.iter().all(apart) {
            doors.push(door);
        }
    }
    let mut holes: Vec<_> = doors.iter().map(Doorway::hole).collect();
    let crossing = b.draw.chance(0.35).then(|| b.draw.within(-2.0, 2.0));
    let free = |at: f64| {
        doors
            .iter()
            .all(|d| d.wall != Wall::Left || (d.at_m - at).abs() > 1.8)
    };
    if let Some(at) = crossing.filter(|at| free(*at)) {
        holes.push(opening(Wall::Left, at, 1.6, 0.0, 2.1));
        let depth = b.draw.within(1.5, 4.0);
        let centre = [at, size[1] / 2.0 + 0.08 + depth / 2.0, 1.15];
        let side = room(
            centre,
            [1.8, depth, 2.3],
            vec![opening(Wall::Right, 0.0, 1.6, 0.0, 2.1)],
            true,
            true,
        );
        b.add("crossing".to_owned(), side);
    }
    b.walls(holes, true, true);
    b.floor();
    for door in &doors {
        door.furnish(&mut b);
    }
    // Pipes under the ceiling and a duct tell along from across here and there.
    if b.draw.chance(0.4) {
        let y = b.draw.sign() * (size[1] / 2.0 - 0.15);
        let radius = b.draw.within(0.03, 0.08);
        let pipe = f::Piece {
            name: "pipe",
            parts: vec![f::Part::Lying([0.0; 3], radius, size[0] - 0.1)],
            half: [radius, size[0] / 2.0],
            height_m: radius,
            tops: Vec::new(),
            removable: false,
        };
        let at = Point3::new(0.0, y, size[2] - 0.25);
        b.put(&pipe, &Stance { at, yaw_deg: 90.0 });
    }
    for _ in 0..b.draw.count(1, 5) {
        let piece = match b.draw.count(0, 4) {
            0 => f::radiator(b.draw),
            1 => f::bin(b.draw),
            2 => f::can(b.draw, 0.1),
            3 => f::bench(b.draw),
            _ => f::cupboard(b.draw),
        };
        b.at_wall(&piece);
    }
    b.robot()
}
