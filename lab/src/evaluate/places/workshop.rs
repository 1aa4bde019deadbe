//! A workshop: machines, a workbench, boards that lean at the wall, gas bottles, lamps that hang. Held out.

use crate::evaluate::builder::{Builder, Stance};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture::{self as f, Part, Piece};
use crate::evaluate::place::Place;
use nalgebra::Point3;
use patrold_sim::world::{Body, PlaneTable, Wall};

/// A workshop of random size and machines.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(5.0, 10.0),
        draw.within(4.5, 8.0),
        draw.within(2.8, 5.0),
    ];
    let mut b = Builder::new(draw, size);
    let wall = [Wall::Front, Wall::Back, Wall::Left, Wall::Right][b.draw.count(0, 3)];
    let door = Doorway::somewhere(&mut b, wall);
    b.walls(vec![door.hole()], true, true);
    b.floor();
    door.furnish(&mut b);
    for _ in 0..b.draw.count(1, 3) {
        let machine = machine(b.draw);
        b.anywhere(&machine);
    }
    for _ in 0..b.draw.count(1, 3) {
        let bench = f::table(b.draw);
        b.at_wall(&bench);
    }
    if b.draw.chance(0.7) {
        leaning_board(&mut b);
    }
    for _ in 0..b.draw.count(2, 8) {
        let piece = match b.draw.count(0, 2) {
            0 => f::can(b.draw, 0.15),
            1 => hopper(b.draw),
            _ => f::goods(b.draw, 0.4),
        };
        b.on_top(&piece);
    }
    for _ in 0..b.draw.count(2, 5) {
        let piece = match b.draw.count(0, 4) {
            0 => f::stool(b.draw),
            1 => f::can(b.draw, 0.28),
            2 => hopper(b.draw),
            3 => f::bin(b.draw),
            _ => f::goods(b.draw, 0.8),
        };
        b.anywhere(&piece);
    }
    for i in 0..b.draw.count(0, 2) {
        let lamp = Piece {
            name: "lamp",
            parts: vec![
                Part::Cone([0.0; 3], 0.2, 0.2),
                Part::Upright([0.0, 0.0, 0.4], 0.01, 0.5),
            ],
            half: [0.2; 2],
            height_m: 0.65,
            tops: Vec::new(),
            removable: false,
        };
        let at = Point3::new(1.5 * i as f64 - 0.7, 0.3, size[2] - 0.9);
        b.put(&lamp, &Stance { at, yaw_deg: 0.0 });
    }
    b.robot()
}

/// A machine: a bed, a column, a lying spindle.
fn machine(draw: &mut Draw) -> Piece {
    let half = [draw.within(0.35, 0.6), draw.within(0.5, 1.1)];
    let (bed, top) = (draw.within(0.7, 1.0), draw.within(1.3, 1.9));
    let radius = draw.within(0.08, 0.18);
    Piece {
        name: "machine",
        parts: vec![
            Part::Box([0.0, 0.0, bed / 2.0], [2.0 * half[0], 2.0 * half[1], bed]),
            Part::Box(
                [0.2 - half[0], 0.0, (bed + top) / 2.0],
                [0.35, 0.5, top - bed],
            ),
            Part::Lying([0.1, 0.0, bed + radius + 0.1], radius, half[1]),
        ],
        half,
        height_m: top,
        tops: Vec::new(),
        removable: false,
    }
}

/// A cone on its base.
fn hopper(draw: &mut Draw) -> Piece {
    let radius = draw.within(0.14, 0.25);
    let height = radius * draw.within(1.2, 2.5);
    Piece {
        name: "cone",
        parts: vec![Part::Cone([0.0; 3], radius, height)],
        half: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: true,
    }
}

/// A board that leans at the wall of -y, by 8-20 deg.
fn leaning_board(b: &mut Builder<'_>) {
    let lean = b.draw.within(8.0, 20.0_f64).to_radians();
    let (wide, long) = (b.draw.within(0.6, 1.4), b.draw.within(1.4, 2.3));
    let [x, y, _] = b.size.map(|s| s / 2.0);
    let foot = long * lean.sin();
    let body = Body::Plane(PlaneTable {
        name: None,
        reflectance: None,
        centre: [
            b.draw.within(0.8 - x, x - 0.8),
            0.03 - y + foot / 2.0,
            long * lean.cos() / 2.0,
        ],
        normal: [0.0, lean.cos(), lean.sin()],
        size: [wide, long],
        spin_deg: 0.0,
    });
    b.add("board".to_owned(), body);
}
