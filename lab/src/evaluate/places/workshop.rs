//! A workshop: machines, workbenches, a leaning board, hanging lamps. Held out.

use crate::evaluate::builder::{FurniturePose, PlaceBuilder};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture::{self, Furniture, FurniturePart};
use crate::evaluate::place::SimulatedPlace;
use crate::evaluate::seeded_rng::SeededRng;
use nalgebra::Point3;
use patrold_sim::world::{Body, PlaneTable, Wall};

/// A workshop of random size and machines.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(5.0, 10.0),
        rng.uniform(4.5, 8.0),
        rng.uniform(2.8, 5.0),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let wall = [Wall::Front, Wall::Back, Wall::Left, Wall::Right][builder.rng.integer(0, 3)];
    let door = Doorway::random(&mut builder, wall);
    builder.add_walls(vec![door.opening()], true, true);
    builder.add_floor();
    door.furnish(&mut builder);
    for _ in 0..builder.rng.integer(1, 3) {
        let machine = machine(builder.rng);
        builder.put_anywhere(&machine);
    }
    for _ in 0..builder.rng.integer(1, 3) {
        let bench = furniture::table(builder.rng);
        builder.put_at_wall(&bench);
    }
    if builder.rng.chance(0.7) {
        leaning_board(&mut builder);
    }
    for _ in 0..builder.rng.integer(2, 8) {
        let piece = match builder.rng.integer(0, 2) {
            0 => furniture::can(builder.rng, 0.15),
            1 => hopper(builder.rng),
            _ => furniture::small_box(builder.rng, 0.4),
        };
        builder.put_on_top(&piece);
    }
    for _ in 0..builder.rng.integer(2, 5) {
        let piece = match builder.rng.integer(0, 4) {
            0 => furniture::stool(builder.rng),
            1 => furniture::can(builder.rng, 0.28),
            2 => hopper(builder.rng),
            3 => furniture::bin(builder.rng),
            _ => furniture::small_box(builder.rng, 0.8),
        };
        builder.put_anywhere(&piece);
    }
    for i in 0..builder.rng.integer(0, 2) {
        let lamp = Furniture {
            name: "lamp",
            parts: vec![
                FurniturePart::Cone([0.0; 3], 0.2, 0.2),
                FurniturePart::Upright([0.0, 0.0, 0.4], 0.01, 0.5),
            ],
            half_footprint_m: [0.2; 2],
            height_m: 0.65,
            tops: Vec::new(),
            removable: false,
        };
        let at = Point3::new(1.5 * i as f64 - 0.7, 0.3, size[2] - 0.9);
        builder.put(&lamp, &FurniturePose { at, yaw_deg: 0.0 });
    }
    builder.build_with_robot()
}

/// A machine: a bed, a column, a horizontal spindle.
fn machine(rng: &mut SeededRng) -> Furniture {
    let half_footprint_m = [rng.uniform(0.35, 0.6), rng.uniform(0.5, 1.1)];
    let (bed, top) = (rng.uniform(0.7, 1.0), rng.uniform(1.3, 1.9));
    let radius = rng.uniform(0.08, 0.18);
    Furniture {
        name: "machine",
        parts: vec![
            FurniturePart::Box(
                [0.0, 0.0, bed / 2.0],
                [2.0 * half_footprint_m[0], 2.0 * half_footprint_m[1], bed],
            ),
            FurniturePart::Box(
                [0.2 - half_footprint_m[0], 0.0, (bed + top) / 2.0],
                [0.35, 0.5, top - bed],
            ),
            FurniturePart::Lying([0.1, 0.0, bed + radius + 0.1], radius, half_footprint_m[1]),
        ],
        half_footprint_m,
        height_m: top,
        tops: Vec::new(),
        removable: false,
    }
}

/// A cone on its base.
fn hopper(rng: &mut SeededRng) -> Furniture {
    let radius = rng.uniform(0.14, 0.25);
    let height = radius * rng.uniform(1.2, 2.5);
    Furniture {
        name: "cone",
        parts: vec![FurniturePart::Cone([0.0; 3], radius, height)],
        half_footprint_m: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: true,
    }
}

/// A board that leans against the wall at -y, by 8-20 deg.
fn leaning_board(builder: &mut PlaceBuilder<'_>) {
    let lean = builder.rng.uniform(8.0, 20.0_f64).to_radians();
    let (wide, long) = (builder.rng.uniform(0.6, 1.4), builder.rng.uniform(1.4, 2.3));
    let [x, y, _] = builder.size.map(|s| s / 2.0);
    let foot = long * lean.sin();
    let body = Body::Plane(PlaneTable {
        name: None,
        reflectance: None,
        centre: [
            builder.rng.uniform(0.8 - x, x - 0.8),
            0.03 - y + foot / 2.0,
            long * lean.cos() / 2.0,
        ],
        normal: [0.0, lean.cos(), lean.sin()],
        size: [wide, long],
        spin_deg: 0.0,
    });
    builder.add("board".to_owned(), body);
}
