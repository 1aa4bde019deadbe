//! Takes the bytes of a recorded cloud (PLY, PCD, XYZ text), gives its points; gives bytes back. Pure: reading
//! and writing files is the caller's.

mod cloud;
mod lzf;
mod pcd;
mod pcd_header;
mod ply;
mod ply_header;
mod ply_write;
mod scalar;
mod text;
mod xyz;

pub use cloud::{CloudFile, FormatError, read_cloud, split_finite};
pub use ply_write::write_ply;
