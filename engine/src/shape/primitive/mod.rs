//! The geometric primitives: pose and size; distances and normals of their surfaces; their visible surface elements; how
//! they change with their parameters. A class is one file here, its rows of
//! [`ParameterBounds`](super::constants::ParameterBounds) and one arm of [`Primitive`].

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

pub(super) use axes::{perpendicular, rotation_with_third, tilted};
pub(super) use quadrature::{SurfaceElement, gauss_legendre};
