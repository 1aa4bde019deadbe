//! The geometric primitives: place, attitude, size; distances and normals of their surfaces; their
//! visible patches; how they move with parameters. A class is one file here, one row of
//! [`Bounds`](super::constants::Bounds) and one arm of [`Primitive`].

mod any;
mod axes;
mod cone;
mod cuboid;
mod cylinder;
mod plane;
mod quadrature;
mod sphere;
mod superquadric;

pub use any::Primitive;
pub use cone::Cone;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use plane::Plane;
pub use sphere::Sphere;
pub use superquadric::Superquadric;

pub(super) use axes::{perpendicular, rotation_with_third, turned};
pub(super) use quadrature::{Patch, interval};
