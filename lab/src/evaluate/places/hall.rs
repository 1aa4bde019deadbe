//! A hall: large, mostly empty, its ceiling and most walls out of reach.

use crate::evaluate::builder::{PlaceBuilder, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture;
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use patrold_sim::world::Wall;

/// A hall of random size; the robot is within some metres of a corner.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(9.0, 18.0),
        rng.uniform(7.0, 14.0),
        rng.uniform(3.5, 8.0),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let [x, y, _] = size.map(|s| s / 2.0);
    let door = Doorway {
        wall: Wall::Left,
        at_m: builder.rng.uniform(x - 4.5, x - 1.0),
        width_m: builder.rng.uniform(0.85, 1.2),
        height_m: builder.rng.uniform(2.0, 2.3),
    };
    let mut openings = vec![door.opening()];
    if builder.rng.chance(0.4) {
        let sill = builder.rng.uniform(0.0, 1.2);
        openings.push(opening(
            Wall::Front,
            builder.rng.uniform(0.0, y - 1.5),
            2.5,
            sill,
            2.6,
        ));
    }
    builder.add_walls(openings, true, true);
    builder.add_floor();
    door.furnish(&mut builder);
    for _ in 0..builder.rng.integer(1, 6) {
        let height = builder.rng.uniform(2.5, size[2]);
        let pillar = furniture::pillar(builder.rng, height);
        builder.put_anywhere(&pillar);
    }
    for _ in 0..builder.rng.integer(1, 6) {
        let piece = match builder.rng.integer(0, 4) {
            0 => furniture::bench(builder.rng),
            1 => furniture::plant(builder.rng),
            2 => furniture::bin(builder.rng),
            3 => furniture::cupboard(builder.rng),
            _ => furniture::small_box(builder.rng, 0.9),
        };
        if builder.rng.chance(0.5) {
            builder.put_at_wall(&piece);
        } else {
            builder.put_anywhere(&piece);
        }
    }
    // The corner at +x +y: at least one wall is within reach.
    let (near, far) = (builder.rng.uniform(0.8, 2.0), builder.rng.uniform(2.5, 5.0));
    builder.build_with_robot_in([x - far, x - near, y - far, y - near])
}
