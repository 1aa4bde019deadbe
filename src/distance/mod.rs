//! Takes Gaussians, gives the distances between them.

/// Ground distance between two Gaussians (g_ij of Eq. 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ground {
    /// Wasserstein-2, metres.
    W2,
    /// Distance of the means, metres.
    Euclid,
    /// Foerstner-Moonen of the covariances (Eq. 10) plus the distance of the means over 1 m.
    Fm,
}
