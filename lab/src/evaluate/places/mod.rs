//! Kinds of place, one file each.

mod canteen;
mod corridor;
mod hall;
mod place_kind;
mod lab;
mod office;
mod ramp;
mod storeroom;
mod workshop;

pub use place_kind::PlaceKind;
