//! Checks whether the head lost steps: whether a sweep fits the reference at the angles that the head reports.

mod bend;
mod constants;
mod mismatch;

pub use mismatch::{Mismatch, ViewTurn, find_mismatch, view_turn};
