//! The beams of a line scanner: raw values to ranges in metres, indices to azimuths in radians.

mod beam;
mod scan_geometry;

pub(crate) use beam::Beam;
pub use scan_geometry::ScanGeometry;
