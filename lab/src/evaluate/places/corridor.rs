//! A corridor: long and narrow, doors and a side corridor, ends often out of reach, little furniture.

use crate::evaluate::builder::{FurniturePose, PlaceBuilder, opening, room};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture::{self, Furniture, FurniturePart};
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_sim::world::Wall;

/// A corridor of random length and width.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(7.0, 22.0),
        rng.uniform(1.7, 2.8),
        rng.uniform(2.2, 3.0),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let mut doors: Vec<Doorway> = Vec::new();
    for _ in 0..builder.rng.integer(2, 5) {
        let wall = [Wall::Left, Wall::Right][builder.rng.integer(0, 1)];
        let door = Doorway::random(&mut builder, wall);
        let apart = |d: &Doorway| d.wall != door.wall || (d.at_m - door.at_m).abs() > 1.6;
        if doors.iter().all(apart) {
            doors.push(door);
        }
    }
    let mut openings: Vec<_> = doors.iter().map(Doorway::opening).collect();
    let crossing = builder
        .rng
        .chance(0.35)
        .then(|| builder.rng.uniform(-2.0, 2.0));
    let free = |at: f64| {
        doors
            .iter()
            .all(|d| d.wall != Wall::Left || (d.at_m - at).abs() > 1.8)
    };
    if let Some(at) = crossing.filter(|at| free(*at)) {
        openings.push(opening(Wall::Left, at, 1.6, 0.0, 2.1));
        let depth = builder.rng.uniform(1.5, 4.0);
        let centre = [at, size[1] / 2.0 + 0.08 + depth / 2.0, 1.15];
        let side = room(
            centre,
            [1.8, depth, 2.3],
            vec![opening(Wall::Right, 0.0, 1.6, 0.0, 2.1)],
            true,
            true,
        );
        builder.add("crossing".to_owned(), side);
    }
    builder.add_walls(openings, true, true);
    builder.add_floor();
    for door in &doors {
        door.furnish(&mut builder);
    }
    // A pipe under the ceiling.
    if builder.rng.chance(0.4) {
        let y = builder.rng.sign() * (size[1] / 2.0 - 0.15);
        let radius = builder.rng.uniform(0.03, 0.08);
        let pipe = Furniture {
            name: "pipe",
            parts: vec![FurniturePart::Lying([0.0; 3], radius, size[0] - 0.1)],
            half_footprint_m: [radius, size[0] / 2.0],
            height_m: radius,
            tops: Vec::new(),
            removable: false,
        };
        let at = Point3::new(0.0, y, size[2] - 0.25);
        builder.put(&pipe, &FurniturePose { at, yaw_deg: 90.0 });
    }
    for _ in 0..builder.rng.integer(1, 5) {
        let piece = match builder.rng.integer(0, 4) {
            0 => furniture::radiator(builder.rng),
            1 => furniture::bin(builder.rng),
            2 => furniture::can(builder.rng, 0.1),
            3 => furniture::bench(builder.rng),
            _ => furniture::cupboard(builder.rng),
        };
        builder.put_at_wall(&piece);
    }
    builder.build_with_robot()
}
