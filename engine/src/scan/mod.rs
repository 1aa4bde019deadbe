//! Takes the numbers of one revolution, gives what each beam says, in metres and radians.

mod beam;
mod optics;

pub use beam::Beam;
pub use optics::Optics;
