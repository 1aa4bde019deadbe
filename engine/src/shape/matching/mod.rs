//! Method B (paper section IV.B): the class whose expected moments of the visible surface are those of the novelty.

pub(super) mod estimate;
mod evidence;
pub(super) mod extent;
mod fit;
pub(super) mod moments;
mod refine;
mod score;
pub(super) mod select;
mod starts;
