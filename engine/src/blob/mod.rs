//! Takes views and mixtures, gives them as bytes and back. Versioned; exact to the last bit.

mod error;
mod mixture;
mod view;

pub use error::BlobError;
pub use mixture::{decode as decode_mixture, encode as encode_mixture};
pub use view::{decode as decode_view, encode as encode_view};
