//! Readers and writers of point clouds (PLY, PCD, XYZ text): bytes to points and back. Files are opened by the caller.

mod cloud;
mod columns;
mod error;
mod lzf;
mod measured_points;
mod number;
mod pcd;
mod pcd_header;
mod ply;
mod ply_header;
mod ply_write;
mod read;
mod scalar;
mod table_layout;
mod text;
mod unread;
mod xyz;

pub use cloud::CloudFile;
pub use error::FormatError;
pub use measured_points::MeasuredPoints;
pub use ply_write::write_ply;
pub use read::read_cloud;
