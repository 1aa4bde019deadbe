//! Takes the points and Gaussians of one novelty, gives its shape (paper section IV).

mod model;

pub use model::{Alternative, Class, Method, Retrieval, Shape};
