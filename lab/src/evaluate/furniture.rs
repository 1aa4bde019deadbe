//! Furniture of random size. Metres; a piece stands on z = 0 about the origin of its own frame, its back towards -x.

use super::seeded_rng::SeededRng;

/// A part of a piece of furniture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FurniturePart {
    /// A box: middle, sizes.
    Box([f64; 3], [f64; 3]),
    /// An upright cylinder: middle, radius, length.
    Upright([f64; 3], f64, f64),
    /// A cylinder that lies along y: middle, radius, length.
    Lying([f64; 3], f64, f64),
    /// A sphere: middle, radius.
    Sphere([f64; 3], f64),
    /// An upright cone: middle of the base, radius, height.
    Cone([f64; 3], f64, f64),
}

/// A flat top of a piece: middle, half sizes, height.
pub(crate) type TopSurface = ([f64; 2], [f64; 2], f64);

/// A piece of furniture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Furniture {
    pub name: &'static str,
    pub parts: Vec<FurniturePart>,
    /// Half its footprint along x and y, metres.
    pub half_footprint_m: [f64; 2],
    pub height_m: f64,
    /// Where other objects can be put.
    pub tops: Vec<TopSurface>,
    /// Whether it may be taken away.
    pub removable: bool,
}

fn legs(x: f64, y: f64, height: f64, radius: f64) -> impl Iterator<Item = FurniturePart> {
    [(x, y), (x, -y), (-x, y), (-x, -y)]
        .map(|(x, y)| FurniturePart::Upright([x, y, height / 2.0], radius, height))
        .into_iter()
}

/// A table on four thin legs.
pub(crate) fn table(rng: &mut SeededRng) -> Furniture {
    let half_footprint_m = [rng.uniform(0.3, 0.45), rng.uniform(0.4, 1.0)];
    let height = rng.uniform(0.68, 0.95);
    let mut parts = vec![FurniturePart::Box(
        [0.0, 0.0, height - 0.02],
        [2.0 * half_footprint_m[0], 2.0 * half_footprint_m[1], 0.04],
    )];
    let radius = rng.uniform(0.012, 0.035);
    parts.extend(legs(
        half_footprint_m[0] - 0.05,
        half_footprint_m[1] - 0.05,
        height - 0.04,
        radius,
    ));
    Furniture {
        name: "table",
        parts,
        half_footprint_m,
        height_m: height,
        tops: vec![([0.0; 2], half_footprint_m, height)],
        removable: false,
    }
}

/// A desk: a top on one side panel and a chest of drawers, often with a screen.
pub(crate) fn desk(rng: &mut SeededRng) -> Furniture {
    let half_footprint_m = [rng.uniform(0.35, 0.45), rng.uniform(0.6, 0.9)];
    let height = rng.uniform(0.7, 0.76);
    let below = height - 0.04;
    let mut parts = vec![
        FurniturePart::Box(
            [0.0, 0.0, height - 0.02],
            [2.0 * half_footprint_m[0], 2.0 * half_footprint_m[1], 0.04],
        ),
        FurniturePart::Box(
            [0.0, half_footprint_m[1] - 0.02, below / 2.0],
            [1.8 * half_footprint_m[0], 0.04, below],
        ),
        FurniturePart::Box(
            [0.0, 0.22 - half_footprint_m[1], below / 2.0],
            [1.6 * half_footprint_m[0], 0.42, below],
        ),
    ];
    let mut tops = vec![(
        [0.15, 0.0],
        [half_footprint_m[0] - 0.15, half_footprint_m[1]],
        height,
    )];
    if rng.chance(0.6) {
        let (width, tall) = (rng.uniform(0.45, 0.7), rng.uniform(0.28, 0.42));
        parts.push(FurniturePart::Box(
            [-0.15, 0.0, height + 0.1 + tall / 2.0],
            [0.05, width, tall],
        ));
        parts.push(FurniturePart::Upright(
            [-0.15, 0.0, height + 0.05],
            0.03,
            0.1,
        ));
        tops = Vec::new();
    }
    Furniture {
        name: "desk",
        parts,
        half_footprint_m,
        height_m: height,
        tops,
        removable: false,
    }
}

/// A chair: seat, back, four legs or a column.
pub(crate) fn chair(rng: &mut SeededRng) -> Furniture {
    let side = rng.uniform(0.4, 0.5);
    let (seat, back) = (rng.uniform(0.43, 0.5), rng.uniform(0.8, 1.05));
    let mut parts = vec![
        FurniturePart::Box([0.0, 0.0, seat - 0.03], [side, side, 0.06]),
        FurniturePart::Box(
            [0.02 - side / 2.0, 0.0, (seat + back) / 2.0 + 0.05],
            [0.04, side * 0.9, back - seat - 0.1],
        ),
    ];
    if rng.chance(0.5) {
        parts.extend(legs(
            side / 2.0 - 0.03,
            side / 2.0 - 0.03,
            seat - 0.06,
            0.015,
        ));
    } else {
        parts.push(FurniturePart::Upright(
            [0.0, 0.0, seat / 2.0],
            0.04,
            seat - 0.06,
        ));
        parts.push(FurniturePart::Upright([0.0, 0.0, 0.04], side / 2.0, 0.06));
    }
    Furniture {
        name: "chair",
        parts,
        half_footprint_m: [side / 2.0; 2],
        height_m: back,
        tops: Vec::new(),
        removable: true,
    }
}

/// A round stool.
pub(crate) fn stool(rng: &mut SeededRng) -> Furniture {
    let (radius, height) = (rng.uniform(0.15, 0.2), rng.uniform(0.45, 0.75));
    let mut parts = vec![FurniturePart::Upright(
        [0.0, 0.0, height - 0.03],
        radius,
        0.06,
    )];
    let legs_at = radius * 0.65;
    parts.extend(legs(legs_at, legs_at, height - 0.06, 0.012));
    Furniture {
        name: "stool",
        parts,
        half_footprint_m: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: true,
    }
}

/// A closed cupboard.
pub(crate) fn cupboard(rng: &mut SeededRng) -> Furniture {
    let size = [rng.uniform(0.35, 0.6), rng.uniform(0.6, 1.4)];
    let height = rng.uniform(0.8, 2.1);
    let half_footprint_m = size.map(|s| s / 2.0);
    Furniture {
        name: "cupboard",
        parts: vec![FurniturePart::Box(
            [0.0, 0.0, height / 2.0],
            [size[0], size[1], height],
        )],
        half_footprint_m,
        height_m: height,
        tops: if height < 1.3 {
            vec![([0.0; 2], half_footprint_m, height)]
        } else {
            Vec::new()
        },
        removable: false,
    }
}

/// An open shelf: posts and boards, with or without a back. Its boards carry goods.
pub(crate) fn shelf(rng: &mut SeededRng) -> Furniture {
    let size = [rng.uniform(0.35, 0.6), rng.uniform(0.9, 2.0)];
    let half_footprint_m = size.map(|s| s / 2.0);
    let height = rng.uniform(1.2, 2.2);
    let boards = rng.integer(3, 5);
    let mut parts: Vec<FurniturePart> = legs(
        half_footprint_m[0] - 0.02,
        half_footprint_m[1] - 0.02,
        height,
        0.02,
    )
    .collect();
    let mut tops = Vec::new();
    for i in 0..boards {
        let z = 0.1 + (height - 0.2) * i as f64 / (boards - 1) as f64;
        parts.push(FurniturePart::Box([0.0, 0.0, z], [size[0], size[1], 0.025]));
        tops.push(([0.0; 2], half_footprint_m, z + 0.0125));
    }
    if rng.chance(0.4) {
        parts.push(FurniturePart::Box(
            [0.01 - half_footprint_m[0], 0.0, height / 2.0],
            [0.02, size[1], height],
        ));
    }
    Furniture {
        name: "shelf",
        parts,
        half_footprint_m,
        height_m: height,
        tops,
        removable: false,
    }
}

/// A box with sides of at most `max_m`.
pub(crate) fn small_box(rng: &mut SeededRng, max_m: f64) -> Furniture {
    let size = [0, 1, 2].map(|_| rng.uniform(0.12, max_m));
    let half_footprint_m = [size[0] / 2.0, size[1] / 2.0];
    Furniture {
        name: "goods",
        parts: vec![FurniturePart::Box([0.0, 0.0, size[2] / 2.0], size)],
        half_footprint_m,
        height_m: size[2],
        tops: Vec::new(),
        removable: size.iter().all(|s| *s > 0.2),
    }
}

/// A can, bottle or drum.
pub(crate) fn can(rng: &mut SeededRng, max_radius_m: f64) -> Furniture {
    let radius = rng.uniform(0.04, max_radius_m);
    let height = radius * rng.uniform(1.5, 4.0);
    Furniture {
        name: "can",
        parts: vec![FurniturePart::Upright(
            [0.0, 0.0, height / 2.0],
            radius,
            height,
        )],
        half_footprint_m: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: radius > 0.13,
    }
}

/// A waste bin.
pub(crate) fn bin(rng: &mut SeededRng) -> Furniture {
    let (radius, height) = (rng.uniform(0.13, 0.22), rng.uniform(0.3, 0.65));
    Furniture {
        name: "bin",
        parts: vec![FurniturePart::Upright(
            [0.0, 0.0, height / 2.0],
            radius,
            height,
        )],
        half_footprint_m: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: true,
    }
}

/// A pillar of the building.
pub(crate) fn pillar(rng: &mut SeededRng, height_m: f64) -> Furniture {
    let radius = rng.uniform(0.12, 0.35);
    let middle = [0.0, 0.0, height_m / 2.0];
    let part = if rng.chance(0.5) {
        FurniturePart::Upright(middle, radius, height_m)
    } else {
        FurniturePart::Box(middle, [2.0 * radius, 2.0 * radius, height_m])
    };
    Furniture {
        name: "pillar",
        parts: vec![part],
        half_footprint_m: [radius; 2],
        height_m,
        tops: Vec::new(),
        removable: false,
    }
}

/// A radiator: a row of ribs in front of the wall.
pub(crate) fn radiator(rng: &mut SeededRng) -> Furniture {
    let (ribs, height) = (rng.integer(8, 18), rng.uniform(0.4, 0.7));
    let half_footprint_m = [0.06, 0.04 * ribs as f64];
    let rib = |i: usize| {
        let y = 0.08 * (i as f64 + 0.5) - half_footprint_m[1];
        FurniturePart::Box([0.0, y, 0.12 + height / 2.0], [0.1, 0.05, height])
    };
    Furniture {
        name: "radiator",
        parts: (0..ribs).map(rib).collect(),
        half_footprint_m,
        height_m: height + 0.12,
        tops: Vec::new(),
        removable: false,
    }
}

/// A plant: a sphere of leaves over a pot.
pub(crate) fn plant(rng: &mut SeededRng) -> Furniture {
    let (pot, crown) = (rng.uniform(0.12, 0.2), rng.uniform(0.2, 0.4));
    let stem = rng.uniform(0.3, 0.9);
    Furniture {
        name: "plant",
        parts: vec![
            FurniturePart::Upright([0.0, 0.0, 0.15], pot, 0.3),
            FurniturePart::Upright([0.0, 0.0, 0.3 + stem / 2.0], 0.02, stem),
            FurniturePart::Sphere([0.0, 0.0, 0.3 + stem], crown),
        ],
        half_footprint_m: [crown.max(pot); 2],
        height_m: 0.3 + stem + crown,
        tops: Vec::new(),
        removable: true,
    }
}

/// A bench without a back.
pub(crate) fn bench(rng: &mut SeededRng) -> Furniture {
    let half_footprint_m = [rng.uniform(0.17, 0.25), rng.uniform(0.5, 1.0)];
    let height = rng.uniform(0.4, 0.5);
    let side = |y: f64| {
        FurniturePart::Box(
            [0.0, y, height / 2.0],
            [1.6 * half_footprint_m[0], 0.06, height - 0.06],
        )
    };
    Furniture {
        name: "bench",
        parts: vec![
            FurniturePart::Box(
                [0.0, 0.0, height - 0.03],
                [2.0 * half_footprint_m[0], 2.0 * half_footprint_m[1], 0.06],
            ),
            side(half_footprint_m[1] - 0.1),
            side(0.1 - half_footprint_m[1]),
        ],
        half_footprint_m,
        height_m: height,
        tops: vec![([0.0; 2], half_footprint_m, height)],
        removable: false,
    }
}
