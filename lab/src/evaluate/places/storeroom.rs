//! A store room: rows of open shelves full of goods, boxes and cans about.

use crate::evaluate::builder::Builder;
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture as f;
use crate::evaluate::place::Place;
use patrold_sim::world::Wall;

/// A store room of random size and filling.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(3.6, 8.0),
        draw.within(3.2, 6.0),
        draw.within(2.3, 3.8),
    ];
    let mut b = Builder::new(draw, size);
    let door = Doorway::somewhere(&mut b, Wall::Back);
    b.walls(vec![door.hole()], true, true);
    b.floor();
    door.furnish(&mut b);
    for _ in 0..b.draw.count(2, 5) {
        let shelf = f::shelf(b.draw);
        b.at_wall(&shelf);
    }
    if b.draw.chance(0.5) {
        let shelf = f::shelf(b.draw);
        b.anywhere(&shelf);
    }
    for _ in 0..b.draw.count(8, 35) {
        let piece = if b.draw.chance(0.75) {
            f::goods(b.draw, 0.45)
        } else {
            f::can(b.draw, 0.16)
        };
        b.on_top(&piece);
    }
    for _ in 0..b.draw.count(1, 5) {
        let piece = match b.draw.count(0, 3) {
            0 => f::bin(b.draw),
            1 => f::can(b.draw, 0.3),
            _ => f::goods(b.draw, 0.7),
        };
        b.anywhere(&piece);
    }
    b.robot()
}
