//! The mixture itself (Theta of Eq. 3) and its invariant.

use super::Gaussian;

/// A Gaussian mixture: `weights[k]` belongs to `components[k]`.
///
/// Invariant (Eq. 2): every weight is finite and not negative, and they sum to one (within
/// rounding); an empty mixture has neither.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mixture {
    /// Mixing probabilities p_k.
    pub weights: Vec<f64>,
    /// The components theta_k.
    pub components: Vec<Gaussian>,
}

impl Mixture {
    /// Number of components K.
    pub fn len(&self) -> usize {
        self.components.len()
    }

    /// Whether there is no component.
    pub fn is_empty(&self) -> bool {
        self.components.is_empty()
    }
}
