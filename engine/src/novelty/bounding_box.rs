//! Box along the axes around points.

use nalgebra::{Point3, center};

/// The smallest box along the axes that holds some points.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundingBox {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl BoundingBox {
    /// Of no points it is a box that contains nothing.
    pub(super) fn new(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        let far = f64::INFINITY;
        let start = Self {
            low: Point3::new(far, far, far),
            high: Point3::new(-far, -far, -far),
        };
        points.into_iter().fold(start, |bounds, p| Self {
            low: bounds.low.inf(&p),
            high: bounds.high.sup(&p),
        })
    }

    /// Whether `p` lies in it, or outside by no more than `margin_m` along each axis, metres.
    pub(super) fn contains(&self, p: &Point3<f64>, margin_m: f64) -> bool {
        (0..3).all(|k| p[k] >= self.low[k] - margin_m && p[k] <= self.high[k] + margin_m)
    }

    /// Length of its diagonal, metres.
    pub(super) fn diagonal_m(&self) -> f64 {
        (self.high - self.low).norm()
    }

    /// Its centre.
    pub(super) fn centre(&self) -> Point3<f64> {
        center(&self.low, &self.high)
    }

    /// Distance between it and `other`, metres: that of their points is not smaller.
    pub(super) fn gap_m(&self, other: &Self) -> f64 {
        let apart = (other.low - self.high).sup(&(self.low - other.high));
        apart.map(|along| along.max(0.0)).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::BoundingBox;
    use nalgebra::Point3;

    #[test]
    fn a_box_knows_its_size_and_its_distance_to_another() {
        let near = BoundingBox::new([Point3::new(1.0, 5.0, -1.0), Point3::new(-2.0, 1.0, 11.0)]);
        assert_eq!(near.diagonal_m(), 13.0);
        assert_eq!(near.centre(), Point3::new(-0.5, 3.0, 5.0));
        let far = BoundingBox::new([Point3::new(4.0, 9.0, 0.0), Point3::new(5.0, 10.0, 1.0)]);
        assert_eq!((near.gap_m(&far), far.gap_m(&near)), (5.0, 5.0));
        let inside = BoundingBox::new([Point3::new(0.0, 2.0, 0.0)]);
        assert_eq!(near.gap_m(&inside), 0.0);
        let outside = Point3::new(1.5, 5.5, 0.0);
        assert!(near.contains(&outside, 0.6) && !near.contains(&outside, 0.4));
    }
}
