//! Things that places are furnished with, each of random size. Metres; a piece stands on z = 0 about the origin of its
//! own frame and turns its back towards -x.

use super::draw::Draw;

/// What a piece is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// A box: middle, sizes.
    Box([f64; 3], [f64; 3]),
    /// An upright cylinder: middle, radius, length.
    Upright([f64; 3], f64, f64),
    /// A cylinder that lies along y: middle, radius, length.
    Lying([f64; 3], f64, f64),
    /// A ball: middle, radius.
    Ball([f64; 3], f64),
    /// An upright cone: middle of the base, radius, height.
    Cone([f64; 3], f64, f64),
}

/// A flat top of a piece: middle, half sizes, height.
pub type Top = ([f64; 2], [f64; 2], f64);

/// A piece of furniture.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// What it is.
    pub name: &'static str,
    /// What it is made of.
    pub parts: Vec<Part>,
    /// Half its footprint.
    pub half: [f64; 2],
    /// Its height.
    pub height_m: f64,
    /// Where things can be put on it.
    pub tops: Vec<Top>,
    /// Whether somebody might carry it away.
    pub removable: bool,
}

fn legs(x: f64, y: f64, height: f64, radius: f64) -> impl Iterator<Item = Part> {
    [(x, y), (x, -y), (-x, y), (-x, -y)]
        .map(|(x, y)| Part::Upright([x, y, height / 2.0], radius, height))
        .into_iter()
}

/// A table on four thin legs.
pub fn table(draw: &mut Draw) -> Piece {
    let half = [draw.within(0.3, 0.45), draw.within(0.4, 1.0)];
    let height = draw.within(0.68, 0.95);
    let mut parts = vec![Part::Box(
        [0.0, 0.0, height - 0.02],
        [2.0 * half[0], 2.0 * half[1], 0.04],
    )];
    let radius = draw.within(0.012, 0.035);
    parts.extend(legs(half[0] - 0.05, half[1] - 0.05, height - 0.04, radius));
    Piece {
        name: "table",
        parts,
        half,
        height_m: height,
        tops: vec![([0.0; 2], half, height)],
        removable: false,
    }
}

/// A desk: a top on one side panel and a chest of drawers, often with a screen.
pub fn desk(draw: &mut Draw) -> Piece {
    let half = [draw.within(0.35, 0.45), draw.within(0.6, 0.9)];
    let height = draw.within(0.7, 0.76);
    let below = height - 0.04;
    let mut parts = vec![
        Part::Box(
            [0.0, 0.0, height - 0.02],
            [2.0 * half[0], 2.0 * half[1], 0.04],
        ),
        Part::Box(
            [0.0, half[1] - 0.02, below / 2.0],
            [1.8 * half[0], 0.04, below],
        ),
        Part::Box(
            [0.0, 0.22 - half[1], below / 2.0],
            [1.6 * half[0], 0.42, below],
        ),
    ];
    let mut tops = vec![([0.15, 0.0], [half[0] - 0.15, half[1]], height)];
    if draw.chance(0.6) {
        let (width, tall) = (draw.within(0.45, 0.7), draw.within(0.28, 0.42));
        parts.push(Part::Box(
            [-0.15, 0.0, height + 0.1 + tall / 2.0],
            [0.05, width, tall],
        ));
        parts.push(Part::Upright([-0.15, 0.0, height + 0.05], 0.03, 0.1));
        tops = Vec::new();
    }
    Piece {
        name: "desk",
        parts,
        half,
        height_m: height,
        tops,
        removable: false,
    }
}

/// A chair: seat, back, four legs or a column.
pub fn chair(draw: &mut Draw) -> Piece {
    let side = draw.within(0.4, 0.5);
    let (seat, back) = (draw.within(0.43, 0.5), draw.within(0.8, 1.05));
    let mut parts = vec![
        Part::Box([0.0, 0.0, seat - 0.03], [side, side, 0.06]),
        Part::Box(
            [0.02 - side / 2.0, 0.0, (seat + back) / 2.0 + 0.05],
            [0.04, side * 0.9, back - seat - 0.1],
        ),
    ];
    if draw.chance(0.5) {
        parts.extend(legs(
            side / 2.0 - 0.03,
            side / 2.0 - 0.03,
            seat - 0.06,
            0.015,
        ));
    } else {
        parts.push(Part::Upright([0.0, 0.0, seat / 2.0], 0.04, seat - 0.06));
        parts.push(Part::Upright([0.0, 0.0, 0.04], side / 2.0, 0.06));
    }
    Piece {
        name: "chair",
        parts,
        half: [side / 2.0; 2],
        height_m: back,
        tops: Vec::new(),
        removable: true,
    }
}

/// A round stool.
pub fn stool(draw: &mut Draw) -> Piece {
    let (radius, height) = (draw.within(0.15, 0.2), draw.within(0.45, 0.75));
    let mut parts = vec![Part::Upright([0.0, 0.0, height - 0.03], radius, 0.06)];
    let out = radius * 0.65;
    parts.extend(legs(out, out, height - 0.06, 0.012));
    Piece {
        name: "stool",
        parts,
        half: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: true,
    }
}

/// A closed cupboard.
pub fn cupboard(draw: &mut Draw) -> Piece {
    let size = [draw.within(0.35, 0.6), draw.within(0.6, 1.4)];
    let height = draw.within(0.8, 2.1);
    let half = size.map(|s| s / 2.0);
    Piece {
        name: "cupboard",
        parts: vec![Part::Box(
            [0.0, 0.0, height / 2.0],
            [size[0], size[1], height],
        )],
        half,
        height_m: height,
        tops: if height < 1.3 {
            vec![([0.0; 2], half, height)]
        } else {
            Vec::new()
        },
        removable: false,
    }
}

/// An open shelf: posts and boards, with or without a back. Its boards carry goods.
pub fn shelf(draw: &mut Draw) -> Piece {
    let size = [draw.within(0.35, 0.6), draw.within(0.9, 2.0)];
    let half = size.map(|s| s / 2.0);
    let height = draw.within(1.2, 2.2);
    let boards = draw.count(3, 5);
    let mut parts: Vec<Part> = legs(half[0] - 0.02, half[1] - 0.02, height, 0.02).collect();
    let mut tops = Vec::new();
    for i in 0..boards {
        let z = 0.1 + (height - 0.2) * i as f64 / (boards - 1) as f64;
        parts.push(Part::Box([0.0, 0.0, z], [size[0], size[1], 0.025]));
        tops.push(([0.0; 2], half, z + 0.0125));
    }
    if draw.chance(0.4) {
        parts.push(Part::Box(
            [0.01 - half[0], 0.0, height / 2.0],
            [0.02, size[1], height],
        ));
    }
    Piece {
        name: "shelf",
        parts,
        half,
        height_m: height,
        tops,
        removable: false,
    }
}

/// A box with goods in it, with sides of at most `most_m`.
pub fn goods(draw: &mut Draw, most_m: f64) -> Piece {
    let size = [0, 1, 2].map(|_| draw.within(0.12, most_m));
    let half = [size[0] / 2.0, size[1] / 2.0];
    Piece {
        name: "goods",
        parts: vec![Part::Box([0.0, 0.0, size[2] / 2.0], size)],
        half,
        height_m: size[2],
        tops: Vec::new(),
        removable: size.iter().all(|s| *s > 0.2),
    }
}

/// A can, bottle or drum of at most this radius.
pub fn can(draw: &mut Draw, most_radius_m: f64) -> Piece {
    let radius = draw.within(0.04, most_radius_m);
    let height = radius * draw.within(1.5, 4.0);
    Piece {
        name: "can",
        parts: vec![Part::Upright([0.0, 0.0, height / 2.0], radius, height)],
        half: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: radius > 0.13,
    }
}

/// A waste bin.
pub fn bin(draw: &mut Draw) -> Piece {
    let (radius, height) = (draw.within(0.13, 0.22), draw.within(0.3, 0.65));
    Piece {
        name: "bin",
        parts: vec![Part::Upright([0.0, 0.0, height / 2.0], radius, height)],
        half: [radius; 2],
        height_m: height,
        tops: Vec::new(),
        removable: true,
    }
}

/// A pillar of the building.
pub fn pillar(draw: &mut Draw, height_m: f64) -> Piece {
    let radius = draw.within(0.12, 0.35);
    let middle = [0.0, 0.0, height_m / 2.0];
    let part = if draw.chance(0.5) {
        Part::Upright(middle, radius, height_m)
    } else {
        Part::Box(middle, [2.0 * radius, 2.0 * radius, height_m])
    };
    Piece {
        name: "pillar",
        parts: vec![part],
        half: [radius; 2],
        height_m,
        tops: Vec::new(),
        removable: false,
    }
}

/// A radiator: a row of ribs before the wall.
pub fn radiator(draw: &mut Draw) -> Piece {
    let (ribs, height) = (draw.count(8, 18), draw.within(0.4, 0.7));
    let half = [0.06, 0.04 * ribs as f64];
    let rib = |i: usize| {
        let y = 0.08 * (i as f64 + 0.5) - half[1];
        Part::Box([0.0, y, 0.12 + height / 2.0], [0.1, 0.05, height])
    };
    Piece {
        name: "radiator",
        parts: (0..ribs).map(rib).collect(),
        half,
        height_m: height + 0.12,
        tops: Vec::new(),
        removable: false,
    }
}

/// A plant: a ball of leaves over a pot.
pub fn plant(draw: &mut Draw) -> Piece {
    let (pot, crown) = (draw.within(0.12, 0.2), draw.within(0.2, 0.4));
    let stem = draw.within(0.3, 0.9);
    Piece {
        name: "plant",
        parts: vec![
            Part::Upright([0.0, 0.0, 0.15], pot, 0.3),
            Part::Upright([0.0, 0.0, 0.3 + stem / 2.0], 0.02, stem),
            Part::Ball([0.0, 0.0, 0.3 + stem], crown),
        ],
        half: [crown.max(pot); 2],
        height_m: 0.3 + stem + crown,
        tops: Vec::new(),
        removable: true,
    }
}

/// A bench without a back.
pub fn bench(draw: &mut Draw) -> Piece {
    let half = [draw.within(0.17, 0.25), draw.within(0.5, 1.0)];
    let height = draw.within(0.4, 0.5);
    let side = |y: f64| Part::Box([0.0, y, height / 2.0], [1.6 * half[0], 0.06, height - 0.06]);
    Piece {
        name: "bench",
        parts: vec![
            Part::Box(
                [0.0, 0.0, height - 0.03],
                [2.0 * half[0], 2.0 * half[1], 0.06],
            ),
            side(half[1] - 0.1),
            side(0.1 - half[1]),
        ],
        half,
        height_m: height,
        tops: vec![([0.0; 2], half, height)],
        removable: false,
    }
}
