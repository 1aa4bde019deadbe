//! Whole visits in virtual time: the patrol's machine, the station's machines, emulated devices, the engine. What the
//! loop, its threads and the disk would do between them is done here at once, in order.

mod elsewhere;
mod faults;
mod lost_steps;
mod patrol;
mod plugs;
mod way_back;
