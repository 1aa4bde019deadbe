//! An office: desks and chairs, cupboards and shelves at the walls, a window over a radiator, a door.

use crate::evaluate::builder::{FurniturePose, PlaceBuilder, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture;
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_sim::world::Wall;

/// An office of random size and furniture.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(4.0, 7.5),
        rng.uniform(3.4, 6.0),
        rng.uniform(2.4, 3.0),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let door = Doorway::random(&mut builder, Wall::Right);
    let mut openings = vec![door.opening()];
    let windows = builder.rng.integer(0, 2);
    for i in 0..windows {
        let wall = [Wall::Front, Wall::Left][i];
        let width = builder.rng.uniform(0.8, 1.8);
        let sill = builder.rng.uniform(0.8, 1.1);
        let top = builder.rng.uniform(1.9, 2.3);
        openings.push(opening(
            wall,
            builder.rng.uniform(-0.6, 0.6),
            width,
            sill,
            top,
        ));
    }
    builder.add_walls(openings, true, true);
    builder.add_floor();
    door.furnish(&mut builder);
    if windows > 0 {
        let radiator = furniture::radiator(builder.rng);
        let at = Point3::new(
            size[0] / 2.0 - radiator.half_footprint_m[0] - 0.04,
            0.0,
            0.0,
        );
        builder.put(&radiator, &FurniturePose { at, yaw_deg: 180.0 });
    }
    if builder.rng.chance(0.3) {
        let pillar = furniture::pillar(builder.rng, size[2]);
        builder.put_anywhere(&pillar);
    }
    for _ in 0..builder.rng.integer(1, 3) {
        let desk = furniture::desk(builder.rng);
        if builder.rng.chance(0.7) {
            builder.put_at_wall(&desk);
        } else {
            builder.put_anywhere(&desk);
        }
    }
    for _ in 0..builder.rng.integer(1, 3) {
        let piece = if builder.rng.chance(0.5) {
            furniture::cupboard(builder.rng)
        } else {
            furniture::shelf(builder.rng)
        };
        builder.put_at_wall(&piece);
    }
    for _ in 0..builder.rng.integer(1, 4) {
        let chair = furniture::chair(builder.rng);
        builder.put_anywhere(&chair);
    }
    for _ in 0..builder.rng.integer(2, 10) {
        let small_box = furniture::small_box(builder.rng, 0.35);
        builder.put_on_top(&small_box);
    }
    for _ in 0..builder.rng.integer(0, 2) {
        let piece = if builder.rng.chance(0.5) {
            furniture::bin(builder.rng)
        } else {
            furniture::plant(builder.rng)
        };
        builder.put_anywhere(&piece);
    }
    builder.build_with_robot()
}
