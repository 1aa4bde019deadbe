//! Kinds of place, one file each: a function from chance to a furnished [`super::Place`]. `None` where chance left no
//! room for the robot.

mod canteen;
mod corridor;
mod hall;
mod kind;
mod lab;
mod office;
mod ramp;
mod storeroom;
mod workshop;

pub use kind::Kind;
