//! The three test sites as scenes: an office, a corridor, a laboratory. Sizes are chosen, after the photographs of paper
//! Fig. 6a-c; the robot stands at the origin, ahead is x.

use super::constants::DOOR_THICKNESS_M;
use nalgebra::{Point3, Rotation3, Vector3};

/// An office of 5 x 4.4 x 2.7 m, and a doorway of 0.86 m in its right wall to a passage.
pub(super) const OFFICE: &str = "
[[room]]
name = 'office'
centre = [0.9, 0.3, 1.35]
size = [5.0, 4.4, 2.7]
openings = [{ wall = 'right', at_m = 0.97, width_m = 0.86, from_m = 0.0, to_m = 2.05 }]

[[room]]
name = 'passage'
centre = [1.8, -3.0, 1.25]
size = [4.0, 2.0, 2.5]
openings = [{ wall = 'left', at_m = 0.07, width_m = 0.86, from_m = 0.0, to_m = 2.05 }]

[[box]]
name = 'desk/top'
centre = [2.3, 2.05, 0.73]
size = [1.6, 0.8, 0.04]

[[box]]
name = 'desk/drawers'
centre = [2.85, 2.05, 0.35]
size = [0.42, 0.6, 0.7]

[[box]]
name = 'desk/screen'
centre = [2.2, 2.2, 1.0]
size = [0.6, 0.06, 0.36]

[[box]]
name = 'chair/seat'
centre = [2.1, 1.4, 0.46]
size = [0.46, 0.46, 0.08]

[[box]]
name = 'chair/back'
centre = [2.1, 1.16, 0.78]
size = [0.44, 0.05, 0.5]

[[cylinder]]
name = 'chair/column'
centre = [2.1, 1.4, 0.21]
radius_m = 0.05
length_m = 0.42

[[box]]
name = 'shelf'
centre = [3.2, 0.4, 0.95]
size = [0.35, 1.2, 1.9]

[[cylinder]]
name = 'bin'
centre = [3.1, -0.7, 0.17]
radius_m = 0.14
length_m = 0.34
";

/// A corridor of 9 x 2.4 x 2.5 m with a cupboard, and a doorway of 0.9 m in its left wall to a room behind.
pub(super) const CORRIDOR: &str = "
[[room]]
name = 'corridor'
centre = [1.5, 0.0, 1.25]
size = [9.0, 2.4, 2.5]
openings = [{ wall = 'left', at_m = 0.6, width_m = 0.9, from_m = 0.0, to_m = 2.0 }]

[[room]]
name = 'behind'
centre = [2.1, 2.3, 1.25]
size = [3.0, 2.0, 2.5]
openings = [{ wall = 'right', at_m = 0.0, width_m = 0.9, from_m = 0.0, to_m = 2.0 }]

[[box]]
name = 'cupboard'
centre = [4.2, -1.0, 0.9]
size = [0.8, 0.4, 1.8]

[[box]]
name = 'bench'
centre = [-1.5, -0.95, 0.22]
size = [1.2, 0.4, 0.44]
";

/// A laboratory of 7 x 5.6 x 3.2 m, and a doorway of 1 m in its front wall to a hallway.
pub(super) const LABORATORY: &str = "
[[room]]
name = 'laboratory'
centre = [-0.7, -0.4, 1.6]
size = [7.0, 5.6, 3.2]
openings = [{ wall = 'front', at_m = 0.9, width_m = 1.0, from_m = 0.0, to_m = 2.1 }]

[[room]]
name = 'hallway'
centre = [3.7, 0.5, 1.3]
size = [1.6, 5.0, 2.6]
openings = [{ wall = 'back', at_m = 0.0, width_m = 1.0, from_m = 0.0, to_m = 2.1 }]

[[box]]
name = 'bench/top'
centre = [0.4, -2.8, 0.9]
size = [3.2, 0.75, 0.05]

[[box]]
name = 'bench/left'
centre = [-1.0, -2.8, 0.44]
size = [0.06, 0.7, 0.88]

[[box]]
name = 'bench/right'
centre = [1.8, -2.8, 0.44]
size = [0.06, 0.7, 0.88]

[[box]]
name = 'oven'
centre = [1.1, -2.85, 1.2]
size = [0.6, 0.5, 0.55]

[[cylinder]]
name = 'flask'
centre = [0.1, -2.7, 1.08]
radius_m = 0.11
length_m = 0.3

[[box]]
name = 'hood'
centre = [2.4, -1.4, 1.1]
size = [0.75, 1.5, 2.2]

[[cylinder]]
name = 'bottle'
centre = [2.5, 1.9, 0.75]
radius_m = 0.12
length_m = 1.5

[[box]]
name = 'island'
centre = [0.8, 1.75, 0.45]
size = [1.4, 0.7, 0.9]
";

/// A door of a site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SiteDoor {
    /// Hinge on the floor, metres.
    hinge_m: [f64; 2],
    /// Direction of the closed leaf from its hinge, degrees from x, counter-clockwise.
    closed_deg: f64,
    /// Rotation of the open leaf from there, degrees.
    pub open_deg: f64,
    /// Width and height of the leaf, metres.
    pub leaf_m: [f64; 2],
}

/// The office's door opens into the office, past a right angle.
pub(super) const OFFICE_DOOR: SiteDoor = SiteDoor {
    hinge_m: [2.3, -1.87],
    closed_deg: 180.0,
    open_deg: -100.0,
    leaf_m: [0.86, 2.05],
};
/// The corridor's door stays closed.
pub(super) const CORRIDOR_DOOR: SiteDoor = SiteDoor {
    hinge_m: [2.55, 1.17],
    closed_deg: 180.0,
    open_deg: 80.0,
    leaf_m: [0.9, 2.0],
};
/// The laboratory's door opens into the laboratory, past a right angle: where it was, it disappears.
pub(super) const LABORATORY_DOOR: SiteDoor = SiteDoor {
    hinge_m: [2.77, 1.0],
    closed_deg: -90.0,
    open_deg: -100.0,
    leaf_m: [1.0, 2.1],
};

impl SiteDoor {
    /// Its table in a scene, with this rotation from closed.
    pub(super) fn table(&self, angle_deg: f64) -> String {
        let ([x, y], [width, height]) = (self.hinge_m, self.leaf_m);
        format!(
            "\n[[door]]\nname = 'door'\nhinge = [{x:?}, {y:?}, 0.0]\nyaw_deg = {:?}\nwidth_m = {width:?}\n\
             height_m = {height:?}\nthickness_m = {DOOR_THICKNESS_M}\nangle_deg = {angle_deg:?}\n",
            self.closed_deg
        )
    }

    /// Direction of the leaf from its hinge, and its middle, with this rotation from closed.
    pub(super) fn leaf(&self, angle_deg: f64) -> (Vector3<f64>, Point3<f64>) {
        let angle_rad = (self.closed_deg + angle_deg).to_radians();
        let along = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad) * Vector3::x();
        let hinge = Point3::new(self.hinge_m[0], self.hinge_m[1], self.leaf_m[1] / 2.0);
        (along, hinge + along * (self.leaf_m[0] / 2.0))
    }
}
