//! Stored form of views and mixtures. Versioned; exact to the last bit.

mod error;
mod mixture;
mod view;

pub use error::BlobError;
pub use mixture::{decode_mixture, encode_mixture, is_outdated_mixture};
pub use view::{decode_view, encode_view};
