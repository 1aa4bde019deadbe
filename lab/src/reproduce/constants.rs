//! Constants of the paper's experiments, and what it leaves to choose.

use std::ops::{Range, RangeInclusive};

/// Beams into the corridor (paper section V).
pub(crate) const CORRIDOR_POINTS: usize = 400;
/// Variance of the noise on every coordinate, square metres, as printed (paper section V).
pub(crate) const PRINTED_VARIANCE_M2: f64 = 0.001;
/// The other reading: a standard deviation of 0.001 m.
pub(crate) const FINE_SIGMA_M: f64 = 0.001;
/// Scenes of each class, and as many without an object (paper section V).
pub(crate) const SCENES_PER_CLASS: usize = 100;
/// Points on the object as in the figures of the paper.
pub(crate) const MANY_POINTS: [usize; 2] = [60, 120];
/// Hardly any points on the object.
pub(crate) const FEW_POINTS: [usize; 2] = [15, 30];

/// The corridor from and to along x, y, z, metres; the sensor is at the origin. Chosen: objects fit in clear of its walls.
pub(crate) const CORRIDOR_BOUNDS_M: [[f64; 3]; 2] = [[-3.0, -1.5, -1.2], [6.0, 1.5, 1.5]];
/// Least distance of objects from walls, metres: nearer, noise of 3 cm hides which points are whose (5 sigma is 16 cm).
pub(crate) const CLEARANCE_M: f64 = 0.2;
/// Half the field of the corridor's rows, degrees: in azimuth and in elevation.
pub(crate) const FIELD_DEG: [f64; 2] = [110.0, 55.0];
/// Centres of objects along x, y, z, metres.
pub(crate) const OBJECT_POSITION_M: [[f64; 2]; 3] = [[1.8, 4.0], [-0.9, 0.9], [-0.7, 0.9]];
/// Radii of spheres, metres.
pub(crate) const SPHERE_RADIUS_M: [f64; 2] = [0.2, 0.45];
/// Radii of cylinders, metres.
pub(crate) const CYLINDER_RADIUS_M: [f64; 2] = [0.15, 0.35];
/// Lengths of cylinders, metres.
pub(crate) const CYLINDER_LENGTH_M: [f64; 2] = [0.8, 1.6];
/// Greatest lean of a cylinder from upright, radians.
pub(crate) const MAX_LEAN_RAD: f64 = 0.6;
/// Longer and shorter sides of planes, metres.
pub(crate) const PLANE_SIDES_M: [[f64; 2]; 2] = [[0.8, 1.6], [0.4, 0.8]];
/// Greatest angle between the normal of a plane and the line of sight, radians.
pub(crate) const MAX_SLANT_RAD: f64 = 0.85;
/// Objects drawn until one is clear of the walls.
pub(crate) const MAX_TRIES: usize = 10_000;
/// Objects drawn in a furnished room, each seen by two whole sweeps. Three in four of every class show as many points as
/// they should (printed by the tests of `furnished_room.rs`): that none does has a probability of 1e-18.
pub(crate) const ROOM_MAX_TRIES: usize = 30;

/// The rotation about the normal of a plane counts where one side is so many times the other.
pub(crate) const MIN_SIDE_RATIO: f64 = 1.2;
/// Half a 95 % interval in standard deviations.
pub(crate) const SIGMAS_95: f64 = 1.96;

/// Repeats at each test site (paper section V).
pub(crate) const REPEATS: usize = 10;
/// First and last tilt of a sweep, degrees.
pub(crate) const SWEEP_TILT_DEG: [f64; 2] = [-35.0, 30.0];
/// Rows of a sweep at a test site.
pub(crate) const SITE_ROWS: usize = 120;
/// Greatest pose error of the revisit, metres and degrees.
pub(crate) const RETURN_ERROR: [f64; 2] = [0.03, 1.5];
/// Height of the pan-tilt's base over the floor, metres.
pub(crate) const BASE_HEIGHT_M: f64 = 0.5;
/// Thickness of the door leaf, metres.
pub(crate) const DOOR_THICKNESS_M: f64 = 0.04;
/// Height of the person, metres.
pub(crate) const PERSON_HEIGHT_M: f64 = 1.75;
/// Position of the person, metres.
pub(crate) const PERSON_POSITION_M: [f64; 2] = [2.4, -0.2];

/// Positions of objects in the furnished room along x, metres: within the range of the laser, clear of the furniture.
pub(crate) const FURNISHED_AHEAD_M: Range<f64> = 1.2..3.2;
/// The same along y.
pub(crate) const FURNISHED_ASIDE_M: Range<f64> = -1.3..1.3;
/// Their sides and diameters, metres (cylinders half as long again, planes up to twice as long).
pub(crate) const FURNISHED_SIZES_M: Range<f64> = 0.25..0.65;
/// Points that they show; others are drawn again.
pub(crate) const FURNISHED_POINTS: RangeInclusive<usize> = 60..=800;
/// Rows that a sweep of the furnished room may have.
pub(crate) const FURNISHED_ROWS: [usize; 3] = [40, 80, 120];

/// Diameter and length of the cylinder of Fig. 4d, metres: the middle of those in the corridor.
pub(crate) const IDEAL_CYLINDER_M: [f64; 2] = [0.5, 1.2];
/// Its position, metres from the sensor at the origin; ideal moments do not depend on it.
pub(crate) const IDEAL_CYLINDER_POSITION_M: [f64; 3] = [3.0, 0.0, 0.0];
/// Points besides its Gaussian.
pub(crate) const IDEAL_CYLINDER_POINTS: usize = 400;
/// Its attitudes.
pub(crate) const CYLINDER_ATTITUDES: usize = 50;
