//! What one view says about a point of the other (`docs/novelty.md section 5`).

/// How the other view saw the position of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Visibility {
    /// Outside its field of view, or in a gap that proves nothing.
    OutOfView,
    /// Behind a surface.
    Occluded,
    /// On a surface.
    OnSurface,
    /// Its rays passed through.
    FreeSpace,
    /// Beyond the range limit: neither novelty nor mass.
    OutOfRange,
}

/// A point's deviation from the other view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// How the other view saw it.
    pub visibility: Visibility,
    /// Deviation in sigmas, the least of all rays around; 0 if not in free space.
    pub z: f64,
    /// Deviation in sigmas by the nearest ray alone, for growth and undersampled objects.
    pub z_loose: f64,
    /// Whether the other view got no return from there.
    pub no_return: bool,
}

impl Evidence {
    /// No deviation.
    pub(super) fn none(visibility: Visibility) -> Self {
        Self {
            visibility,
            z: 0.0,
            z_loose: 0.0,
            no_return: false,
        }
    }

    /// A deviation of `z` sigmas, by all rays and by the nearest.
    pub(super) fn from_deviation(z: f64) -> Self {
        Self {
            z,
            z_loose: z,
            ..Self::none(if z > 5.0 {
                Visibility::FreeSpace
            } else {
                Visibility::OnSurface
            })
        }
    }
}
