//! Readers and writers of point clouds (PLY, PCD, XYZ text): bytes to points and back. Files are opened by the caller.

mod cloud;
mod error;
mod lzf;
mod pcd;
mod pcd_header;
mod ply;
mod ply_header;
mod ply_write;
mod read;
mod scalar;
mod text;
mod xyz;

pub use cloud::{CloudFile, split_finite};
pub use error::FormatError;
pub use ply_write::write_ply;
pub use read::read_cloud;
