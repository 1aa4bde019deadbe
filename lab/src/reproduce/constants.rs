//! What the paper says of its experiments, and what it leaves to choose, with units.

use std::ops::{Range, RangeInclusive};

/// Points of the corridor (section V).
pub const CORRIDOR_POINTS: usize = 400;
/// Variance of the noise on every coordinate, square metres, as printed (section V).
pub const PRINTED_VARIANCE_M2: f64 = 0.001;
/// The other reading: a standard deviation of 0.001 m.
pub const FINE_SIGMA_M: f64 = 0.001;
/// Scenes of each class, and scenes with nothing new beside them.
pub const SCENES: usize = 100;
/// Points on the thing in the paper's pictures; and hardly any.
pub const MANY: [usize; 2] = [60, 120];
/// See [`MANY`].
pub const FEW: [usize; 2] = [15, 30];

/// The corridor: from and to along x, y, z, metres; the sensor stands at the origin. Chosen: wide enough for
/// things to stand clear of its walls.
pub const CORRIDOR_M: [[f64; 3]; 2] = [[-3.0, -1.5, -1.2], [6.0, 1.5, 1.5]];
/// Things keep this far from walls, metres: nearer, noise of 3 cm hides what belongs to which (5 sigma is 16 cm).
pub const CLEARANCE_M: f64 = 0.2;
/// Field of the corridor's rows, degrees across (both sides) and up and down.
pub const FIELD_DEG: [f64; 2] = [110.0, 55.0];
/// Where things stand: ahead, aside and in height of their middles, metres.
pub const PLACE_M: [[f64; 2]; 3] = [[1.8, 4.0], [-0.9, 0.9], [-0.7, 0.9]];
/// Radii of balls, metres.
pub const BALL_RADIUS_M: [f64; 2] = [0.2, 0.45];
/// Radii of cylinders, metres.
pub const CYLINDER_RADIUS_M: [f64; 2] = [0.15, 0.35];
/// Lengths of cylinders, metres.
pub const CYLINDER_LENGTH_M: [f64; 2] = [0.8, 1.6];
/// Greatest lean of a cylinder from upright, radians.
pub const LEAN_RAD: f64 = 0.6;
/// Longer and shorter sides of planes, metres.
pub const PLANE_SIDES_M: [[f64; 2]; 2] = [[0.8, 1.6], [0.4, 0.8]];
/// Greatest angle between a plane's normal and the line of sight, radians.
pub const SLANT_RAD: f64 = 0.85;
/// Draws until a thing stands clear.
pub const TRIES: usize = 10_000;
/// The same for a thing in a furnished room, each seen by two whole sweeps. Three in four show as many points as they should, of
/// every class (the tests of `rooms` print it): none of these is a chance of 1e-18.
pub const ROOM_TRIES: usize = 30;

/// A plane whose sides differ by less has no turn to be measured (the issue of symmetric axes).
pub const TURN_RATIO: f64 = 1.2;
/// A 95 % interval in standard deviations.
pub const SIGMAS_95: f64 = 1.96;
/// A component is a weight, a mean and a symmetric covariance.
pub const NUMBERS_PER_COMPONENT: usize = 1 + 3 + 6;
/// Seed of the engine; the scenes' seed is the caller's.
pub const ENGINE_SEED: u64 = 7;

/// Repeats at each test site (section V).
pub const REPEATS: usize = 10;
/// Tilt of a site's sweep from and to, degrees, and its rows.
pub const SITE_TILT_DEG: [f64; 2] = [-35.0, 30.0];
/// See [`SITE_TILT_DEG`].
pub const SITE_ROWS: usize = 120;
/// The robot comes back to within this, metres and degrees.
pub const RETURN_ERROR: [f64; 2] = [0.03, 1.5];
/// Height of the pan-tilt's base over the floor, metres.
pub const BASE_M: f64 = 0.5;
/// Hinge of the sites' door on the floor, metres; its doorway is in the scene's text.
pub const HINGE_M: [f64; 2] = [2.55, 1.17];
/// Width and height of its leaf, metres.
pub const LEAF_M: [f64; 2] = [0.9, 2.0];
/// Thickness of its leaf, metres.
pub const THICKNESS_M: f64 = 0.04;
/// How far it stands open, degrees, turned into the corridor.
pub const OPEN_DEG: f64 = 80.0;
/// Height of the person, metres.
pub const PERSON_M: f64 = 1.75;
/// Where it stands, metres.
pub const PERSON_AT_M: [f64; 2] = [2.4, -0.2];

/// Where things come to stand in the furnished room, ahead and aside, metres: within the range of the laser, clear of the
/// furniture.
pub const FURNISHED_AHEAD_M: Range<f64> = 1.2..3.2;
/// See [`FURNISHED_AHEAD_M`].
pub const FURNISHED_ASIDE_M: Range<f64> = -1.3..1.3;
/// Their sides and diameters, metres (lengths of bars half as much again, boards up to twice as long).
pub const FURNISHED_SIZES_M: Range<f64> = 0.25..0.65;
/// Points that they show; others are drawn again.
pub const FURNISHED_POINTS: RangeInclusive<usize> = 60..=800;
/// Rows that a sweep of the furnished room may have, over [`SITE_TILT_DEG`].
pub const FURNISHED_ROWS: [usize; 3] = [40, 80, 120];

/// Most Gaussians that Fig. 3 takes away; a thing has a handful.
pub const MOST_REMOVED: usize = 12;
/// Diameter and length of Fig. 4d's cylinder, metres: the middle of table1's.
pub const IDEAL_CYLINDER_M: [f64; 2] = [0.5, 1.2];
/// Where it stands, metres from the sensor at the origin; ideal moments do not depend on it.
pub const IDEAL_CYLINDER_AT_M: [f64; 3] = [3.0, 0.0, 0.0];
/// Points beside its Gaussian.
pub const IDEAL_CYLINDER_POINTS: usize = 400;
/// Attitudes that it is given.
pub const CYLINDER_ATTITUDES: usize = 50;
