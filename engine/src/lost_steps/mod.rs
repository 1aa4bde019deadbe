//! Takes a sweep and its registration on the reference, gives whether the head's angles are to be doubted.

mod bend;
mod constants;
mod doubt;

pub use doubt::{Doubt, Suspicion, doubt};
