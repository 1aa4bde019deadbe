//! Two levels joined by a ramp or by stairs, with a handrail.

use crate::evaluate::builder::{PlaceBuilder, cuboid, cylinder};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::furniture;
use crate::evaluate::place::{GROUND, SimulatedPlace, SupportSurface};
use crate::evaluate::seeded_rng::SeededRng;
use patrold_sim::world::{Body, PlaneTable, Wall};

/// Two levels of random size; the robot is on either.
pub(crate) fn build(rng: &mut SeededRng) -> Option<SimulatedPlace> {
    let size = [
        rng.uniform(6.0, 12.0),
        rng.uniform(2.4, 5.0),
        rng.uniform(3.2, 4.5),
    ];
    let mut builder = PlaceBuilder::new(rng, size);
    let door = Doorway::random(&mut builder, Wall::Back);
    builder.add_walls(vec![door.opening()], false, true);
    let [x, y] = [size[0] / 2.0, size[1] / 2.0];
    let stairs = builder.rng.chance(0.4);
    let from = builder.rng.uniform(-0.35, 0.1) * x;
    let (run, rise) = if stairs {
        let steps = builder.rng.integer(2, 6);
        let step = [
            builder.rng.uniform(0.26, 0.34),
            builder.rng.uniform(0.14, 0.19),
        ];
        flight(&mut builder, from, steps, step, y);
        (steps as f64 * step[0], (steps as f64 + 1.0) * step[1])
    } else {
        let run = builder.rng.uniform(0.4, 0.8) * (x - from);
        (run, run * builder.rng.uniform(0.04, 0.12))
    };
    let to = from + run;
    level(&mut builder, [-x, from], 0.0, y);
    level(&mut builder, [to, x], rise, y);
    if stairs {
        // The last riser.
        let riser = cuboid(
            [to + 0.01, 0.0, rise / 2.0],
            [0.02, 2.0 * y, rise - 0.001],
            0.0,
        );
        builder.add(format!("{GROUND}/riser"), riser);
    } else {
        slope(&mut builder, [from, to], rise, y);
    }
    door.furnish(&mut builder);
    rail(&mut builder, [from, to], rise, y);
    for _ in 0..builder.rng.integer(2, 6) {
        let piece = match builder.rng.integer(0, 4) {
            0 => furniture::bench(builder.rng),
            1 => furniture::plant(builder.rng),
            2 => furniture::bin(builder.rng),
            3 => furniture::cupboard(builder.rng),
            _ => furniture::small_box(builder.rng, 0.7),
        };
        if builder.rng.chance(0.6) {
            builder.put_at_wall(&piece);
        } else {
            builder.put_anywhere(&piece);
        }
    }
    builder.build_with_robot()
}

/// A level floor between two x.
fn level(builder: &mut PlaceBuilder<'_>, span: [f64; 2], z_m: f64, half_y: f64) {
    let middle = (span[0] + span[1]) / 2.0;
    let plane = PlaneTable {
        name: None,
        reflectance: None,
        centre: [middle, 0.0, z_m],
        normal: [0.0, 0.0, 1.0],
        size: [span[1] - span[0], 2.0 * half_y],
        spin_deg: 0.0,
    };
    builder.add(format!("{GROUND}/level {z_m:.2}"), Body::Plane(plane));
    builder.supports.push(SupportSurface {
        centre: [middle, 0.0],
        half: [(span[1] - span[0]) / 2.0, half_y],
        yaw_deg: 0.0,
        z_m,
        grade: 0.0,
        floor: true,
    });
}

/// A ramp between two x, from z = 0 up to `rise`.
fn slope(builder: &mut PlaceBuilder<'_>, span: [f64; 2], rise: f64, half_y: f64) {
    let run = span[1] - span[0];
    let middle = (span[0] + span[1]) / 2.0;
    let plane = PlaneTable {
        name: None,
        reflectance: None,
        centre: [middle, 0.0, rise / 2.0],
        normal: [-rise, 0.0, run],
        // The first size of an inclined plane is level, here along y.
        size: [2.0 * half_y, f64::hypot(run, rise)],
        spin_deg: 0.0,
    };
    builder.add(format!("{GROUND}/ramp"), Body::Plane(plane));
    builder.supports.push(SupportSurface {
        centre: [middle, 0.0],
        half: [run / 2.0, half_y],
        yaw_deg: 0.0,
        z_m: rise / 2.0,
        grade: rise / run,
        floor: true,
    });
}

/// Steps from x = `from` on; `step` is tread and riser.
fn flight(builder: &mut PlaceBuilder<'_>, from: f64, steps: usize, step: [f64; 2], half_y: f64) {
    for i in 0..steps {
        let top = step[1] * (i as f64 + 1.0);
        let centre = [from + step[0] * (i as f64 + 0.5), 0.0, top / 2.0];
        let body = cuboid(centre, [step[0], 2.0 * half_y, top], 0.0);
        builder.add(format!("{GROUND}/step {i}"), body);
    }
}

/// A handrail along one side.
fn rail(builder: &mut PlaceBuilder<'_>, span: [f64; 2], rise: f64, half_y: f64) {
    const OVER_M: f64 = 0.95;
    let y = builder.rng.sign() * (half_y - 0.12);
    let run = span[1] - span[0];
    let middle = [(span[0] + span[1]) / 2.0, y, rise / 2.0 + OVER_M];
    let bar = cylinder(middle, [run, 0.0, rise], 0.02, f64::hypot(run, rise));
    builder.add("rail/bar".to_owned(), bar);
    let posts = (run / 1.2).ceil().max(1.0) as usize;
    for i in 0..=posts {
        let share = i as f64 / posts as f64;
        let foot = rise * share;
        let centre = [span[0] + run * share, y, foot + OVER_M / 2.0];
        builder.add(
            format!("rail/{i}"),
            cylinder(centre, [0.0, 0.0, 1.0], 0.018, OVER_M),
        );
    }
}
