//! A canteen or lobby: round tables on columns, many chairs, a counter, pillars, a glass front. Held out.

use crate::evaluate::builder::{PlaceBuilder, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture::{self, Furniture, FurniturePart};
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use patrold_sim::world::Wall;

/// A canteen of random size.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(6.0, 12.0),
        rng.uniform(5.0, 9.0),
        rng.uniform(2.6, 4.5),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let door = Doorway::random(&mut builder, Wall::Back);
    let mut openings = vec![door.opening()];
    if builder.rng.chance(0.7) {
        // Glass gives no return.
        let width = builder.rng.uniform(2.0, 0.7 * size[0]);
        let sill = builder.rng.uniform(0.05, 0.9);
        openings.push(opening(Wall::Left, 0.0, width, sill, 2.4));
    }
    builder.add_walls(openings, true, true);
    builder.add_floor();
    door.furnish(&mut builder);
    if builder.rng.chance(0.7) {
        let counter = counter(builder.rng);
        builder.put_at_wall(&counter);
    }
    for _ in 0..builder.rng.integer(0, 3) {
        let pillar = furniture::pillar(builder.rng, size[2]);
        builder.put_anywhere(&pillar);
    }
    for _ in 0..builder.rng.integer(2, 5) {
        let table = round_table(builder.rng);
        builder.put_anywhere(&table);
    }
    for _ in 0..builder.rng.integer(4, 12) {
        let chair = furniture::chair(builder.rng);
        builder.put_anywhere(&chair);
    }
    if builder.rng.chance(0.5) {
        let screen = partition(builder.rng);
        builder.put_anywhere(&screen);
    }
    for _ in 0..builder.rng.integer(1, 5) {
        let piece = match builder.rng.integer(0, 2) {
            0 => furniture::plant(builder.rng),
            1 => furniture::bin(builder.rng),
            _ => furniture::bench(builder.rng),
        };
        builder.put_anywhere(&piece);
    }
    for _ in 0..builder.rng.integer(0, 5) {
        let piece = if builder.rng.chance(0.5) {
            furniture::can(builder.rng, 0.12)
        } else {
            furniture::small_box(builder.rng, 0.3)
        };
        builder.put_on_top(&piece);
    }
    builder.build_with_robot()
}

/// A round table on a column and a foot.
fn round_table(rng: &mut SeededRng) -> Furniture {
    let (radius, height) = (rng.uniform(0.35, 0.6), rng.uniform(0.7, 1.1));
    let inner = radius / std::f64::consts::SQRT_2;
    Furniture {
        name: "round table",
        parts: vec![
            FurniturePart::Upright([0.0, 0.0, height - 0.015], radius, 0.03),
            FurniturePart::Upright([0.0, 0.0, height / 2.0], 0.035, height - 0.04),
            FurniturePart::Upright([0.0, 0.0, 0.015], 0.6 * radius, 0.03),
        ],
        half_footprint_m: [radius; 2],
        height_m: height,
        tops: vec![([0.0; 2], [inner; 2], height)],
        removable: false,
    }
}

/// A counter with a board above it.
fn counter(rng: &mut SeededRng) -> Furniture {
    let half_footprint_m = [rng.uniform(0.3, 0.45), rng.uniform(0.8, 1.8)];
    let height = rng.uniform(0.9, 1.1);
    Furniture {
        name: "counter",
        parts: vec![
            FurniturePart::Box(
                [0.0, 0.0, height / 2.0],
                [1.7 * half_footprint_m[0], 2.0 * half_footprint_m[1], height],
            ),
            FurniturePart::Box(
                [0.0, 0.0, height + 0.02],
                [2.0 * half_footprint_m[0], 2.0 * half_footprint_m[1], 0.04],
            ),
        ],
        half_footprint_m,
        height_m: height + 0.04,
        tops: vec![([0.0; 2], half_footprint_m, height + 0.04)],
        removable: false,
    }
}

/// A thin partition on two feet, open below.
fn partition(rng: &mut SeededRng) -> Furniture {
    let (wide, high) = (rng.uniform(0.8, 1.8), rng.uniform(1.3, 1.9));
    let foot = |y: f64| FurniturePart::Box([0.0, y, 0.08], [0.4, 0.05, 0.16]);
    Furniture {
        name: "partition",
        parts: vec![
            FurniturePart::Box([0.0, 0.0, (high + 0.16) / 2.0], [0.04, wide, high - 0.16]),
            foot(wide / 2.0 - 0.1),
            foot(0.1 - wide / 2.0),
        ],
        half_footprint_m: [0.2, wide / 2.0],
        height_m: high,
        tops: Vec::new(),
        removable: true,
    }
}
