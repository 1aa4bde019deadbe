//! Takes settings and a shutdown, runs the patrol: devices, requests, timers and signals in one loop.

mod stamp;

pub use stamp::stamp_now;
