//! A store room: open shelves full of goods, boxes and cans on the floor.

use crate::evaluate::builder::PlaceBuilder;
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture;
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use patrold_sim::world::Wall;

/// A store room of random size and goods.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(3.6, 8.0),
        rng.uniform(3.2, 6.0),
        rng.uniform(2.3, 3.8),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let door = Doorway::random(&mut builder, Wall::Back);
    builder.add_walls(vec![door.opening()], true, true);
    builder.add_floor();
    door.furnish(&mut builder);
    for _ in 0..builder.rng.integer(2, 5) {
        let shelf = furniture::shelf(builder.rng);
        builder.put_at_wall(&shelf);
    }
    if builder.rng.chance(0.5) {
        let shelf = furniture::shelf(builder.rng);
        builder.put_anywhere(&shelf);
    }
    for _ in 0..builder.rng.integer(8, 35) {
        let piece = if builder.rng.chance(0.75) {
            furniture::small_box(builder.rng, 0.45)
        } else {
            furniture::can(builder.rng, 0.16)
        };
        builder.put_on_top(&piece);
    }
    for _ in 0..builder.rng.integer(1, 5) {
        let piece = match builder.rng.integer(0, 3) {
            0 => furniture::bin(builder.rng),
            1 => furniture::can(builder.rng, 0.3),
            _ => furniture::small_box(builder.rng, 0.7),
        };
        builder.put_anywhere(&piece);
    }
    builder.build_with_robot()
}
