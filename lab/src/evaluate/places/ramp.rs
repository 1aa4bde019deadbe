//! Two levels joined by a ramp or by stairs, with a handrail.

use crate::evaluate::builder::{Builder, cuboid, cylinder};
use crate::evaluate::doorway::Doorway;
use crate::evaluate::draw::Draw;
use crate::evaluate::furniture as f;
use crate::evaluate::place::{GROUND, Place, Support};
use patrold_sim::world::{Body, PlaneTable, Wall};

/// Two levels of random size; the robot stands on either.
pub fn build(draw: &mut Draw) -> Option<Place> {
    let size = [
        draw.within(6.0, 12.0),
        draw.within(2.4, 5.0),
        draw.within(3.2, 4.5),
    ];
    let mut b = Builder::new(draw, size);
    let door = Doorway::somewhere(&mut b, Wall::Back);
    b.walls(vec![door.hole()], false, true);
    let [x, y] = [size[0] / 2.0, size[1] / 2.0];
    let stairs = b.draw.chance(0.4);
    let from = b.draw.within(-0.35, 0.1) * x;
    let (run, rise) = if stairs {
        let steps = b.draw.count(2, 6);
        let step = [b.draw.within(0.26, 0.34), b.draw.within(0.14, 0.19)];
        flight(&mut b, from, steps, step, y);
        (steps as f64 * step[0], (steps as f64 + 1.0) * step[1])
    } else {
        let run = b.draw.within(0.4, 0.8) * (x - from);
        (run, run * b.draw.within(0.04, 0.12))
    };
    let to = from + run;
    level(&mut b, [-x, from], 0.0, y);
    level(&mut b, [to, x], rise, y);
    if stairs {
        // The last riser.
        let riser = cuboid(
            [to + 0.01, 0.0, rise / 2.0],
            [0.02, 2.0 * y, rise - 0.001],
            0.0,
        );
        b.add(format!("{GROUND}/riser"), riser);
    } else {
        slope(&mut b, [from, to], rise, y);
    }
    door.furnish(&mut b);
    rail(&mut b, [from, to], rise, y);
    for _ in 0..b.draw.count(2, 6) {
        let piece = match b.draw.count(0, 4) {
            0 => f::bench(b.draw),
            1 => f::plant(b.draw),
            2 => f::bin(b.draw),
            3 => f::cupboard(b.draw),
            _ => f::goods(b.draw, 0.7),
        };
        if b.draw.chance(0.6) {
            b.at_wall(&piece);
        } else {
            b.anywhere(&piece);
        }
    }
    b.robot()
}

/// A level piece of floor between two x.
fn level(b: &mut Builder<'_>, span: [f64; 2], z_m: f64, half_y: f64) {
    let middle = (span[0] + span[1]) / 2.0;
    let plane = PlaneTable {
        name: None,
        reflectance: None,
        centre: [middle, 0.0, z_m],
        normal: [0.0, 0.0, 1.0],
        size: [span[1] - span[0], 2.0 * half_y],
        spin_deg: 0.0,
    };
    b.add(format!("{GROUND}/level {z_m:.2}"), Body::Plane(plane));
    b.supports.push(Support {
        centre: [middle, 0.0],
        half: [(span[1] - span[0]) / 2.0, half_y],
        yaw_deg: 0.0,
        z_m,
        grade: 0.0,
        floor: true,
    });
}

/// A ramp between two x, from z = 0 up to `rise`.
fn slope(b: &mut Builder<'_>, span: [f64; 2], rise: f64, half_y: f64) {
    let run = span[1] - span[0];
    let middle = (span[0] + span[1]) / 2.0;
    let plane = PlaneTable {
        name: None,
        reflectance: None,
        centre: [middle, 0.0, rise / 2.0],
        normal: [-rise, 0.0, run],
        // A leaning plane's first size lies level, here along y.
        size: [2.0 * half_y, f64::hypot(run, rise)],
        spin_deg: 0.0,
    };
    b.add(format!("{GROUND}/ramp"), Body::Plane(plane));
    b.supports.push(Support {
        centre: [middle, 0.0],
        half: [run / 2.0, half_y],
        yaw_deg: 0.0,
        z_m: rise / 2.0,
        grade: rise / run,
        floor: true,
    });
}

/// Steps from x = `from` on; `step` is tread and riser.
fn flight(b: &mut Builder<'_>, from: f64, steps: usize, step: [f64; 2], half_y: f64) {
    for i in 0..steps {
        let top = step[1] * (i as f64 + 1.0);
        let centre = [from + step[0] * (i as f64 + 0.5), 0.0, top / 2.0];
        let body = cuboid(centre, [step[0], 2.0 * half_y, top], 0.0);
        b.add(format!("{GROUND}/step {i}"), body);
    }
}

/// A handrail along one side.
fn rail(b: &mut Builder<'_>, span: [f64; 2], rise: f64, half_y: f64) {
    const OVER_M: f64 = 0.95;
    let y = b.draw.sign() * (half_y - 0.12);
    let run = span[1] - span[0];
    let middle = [(span[0] + span[1]) / 2.0, y, rise / 2.0 + OVER_M];
    let bar = cylinder(middle, [run, 0.0, rise], 0.02, f64::hypot(run, rise));
    b.add("rail/bar".to_owned(), bar);
    let posts = (run / 1.2).ceil().max(1.0) as usize;
    for i in 0..=posts {
        let share = i as f64 / posts as f64;
        let foot = rise * share;
        let centre = [span[0] + run * share, y, foot + OVER_M / 2.0];
        b.add(
            format!("rail/{i}"),
            cylinder(centre, [0.0, 0.0, 1.0], 0.018, OVER_M),
        );
    }
}
