//! Kinds of place, one file each: a function from chance to a furnished [`super::Place`].

mod corridor;
mod hall;
mod kind;
mod office;
mod storeroom;

pub use kind::Kind;
