//! A laboratory: benches on thin legs full of equipment, stools, a fume hood, bottles, pipes under the ceiling.

use crate::evaluate::builder::{FurniturePose, PlaceBuilder, opening};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture::{self, Furniture, FurniturePart};
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_sim::world::Wall;

/// A laboratory of random size and equipment.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(4.5, 8.5),
        rng.uniform(4.0, 7.0),
        rng.uniform(2.6, 3.4),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let door = Doorway::random(&mut builder, Wall::Back);
    let mut openings = vec![door.opening()];
    if builder.rng.chance(0.5) {
        let width = builder.rng.uniform(1.0, 3.0);
        openings.push(opening(
            Wall::Left,
            builder.rng.uniform(-0.5, 0.5),
            width,
            1.0,
            2.2,
        ));
    }
    builder.add_walls(openings, true, true);
    builder.add_floor();
    door.furnish(&mut builder);
    if builder.rng.chance(0.6) {
        let hood = fume_hood(builder.rng);
        builder.put_at_wall(&hood);
    }
    for _ in 0..builder.rng.integer(2, 4) {
        let bench = furniture::table(builder.rng);
        builder.put_at_wall(&bench);
    }
    for _ in 0..builder.rng.integer(0, 2) {
        let island = furniture::table(builder.rng);
        builder.put_anywhere(&island);
    }
    for _ in 0..builder.rng.integer(0, 2) {
        let bottle = bottle(builder.rng);
        builder.put_at_wall(&bottle);
    }
    for _ in 0..builder.rng.integer(8, 24) {
        let piece = if builder.rng.chance(0.5) {
            furniture::small_box(builder.rng, 0.5)
        } else {
            furniture::can(builder.rng, 0.12)
        };
        builder.put_on_top(&piece);
    }
    for _ in 0..builder.rng.integer(1, 5) {
        let piece = match builder.rng.integer(0, 3) {
            0 => furniture::bin(builder.rng),
            1 => furniture::chair(builder.rng),
            _ => furniture::stool(builder.rng),
        };
        builder.put_anywhere(&piece);
    }
    for i in 0..builder.rng.integer(0, 3) {
        let radius = builder.rng.uniform(0.02, 0.12);
        let pipe = Furniture {
            name: "pipe",
            parts: vec![FurniturePart::Lying([0.0; 3], radius, size[1] - 0.1)],
            half_footprint_m: [radius, size[1] / 2.0],
            height_m: radius,
            tops: Vec::new(),
            removable: false,
        };
        let at = Point3::new(0.5 * i as f64 - 0.5, 0.0, size[2] - 0.3);
        builder.put(&pipe, &FurniturePose { at, yaw_deg: 0.0 });
    }
    builder.build_with_robot()
}

/// A fume hood: a low cupboard, above it a chamber open to the front.
fn fume_hood(rng: &mut SeededRng) -> Furniture {
    let (deep, wide) = (rng.uniform(0.6, 0.8), rng.uniform(1.0, 1.6));
    let (low, high) = (0.9, rng.uniform(1.9, 2.3));
    let tall = high - low;
    let side = |y: f64| FurniturePart::Box([0.0, y, low + tall / 2.0], [deep, 0.04, tall]);
    Furniture {
        name: "hood",
        parts: vec![
            FurniturePart::Box([0.0, 0.0, low / 2.0], [deep, wide, low]),
            side(wide / 2.0 - 0.02),
            side(0.02 - wide / 2.0),
            FurniturePart::Box(
                [0.02 - deep / 2.0, 0.0, low + tall / 2.0],
                [0.04, wide, tall],
            ),
            FurniturePart::Box([0.0, 0.0, high - 0.15], [deep, wide, 0.3]),
        ],
        half_footprint_m: [deep / 2.0, wide / 2.0],
        height_m: high,
        tops: vec![([0.0; 2], [deep / 2.0 - 0.1, wide / 2.0 - 0.1], low)],
        removable: false,
    }
}

/// A gas bottle.
fn bottle(rng: &mut SeededRng) -> Furniture {
    let (radius, height) = (rng.uniform(0.1, 0.14), rng.uniform(1.1, 1.6));
    Furniture {
        name: "bottle",
        parts: vec![
            FurniturePart::Upright([0.0, 0.0, height / 2.0], radius, height),
            FurniturePart::Sphere([0.0, 0.0, height], radius),
        ],
        half_footprint_m: [radius; 2],
        height_m: height + radius,
        tops: Vec::new(),
        removable: true,
    }
}
