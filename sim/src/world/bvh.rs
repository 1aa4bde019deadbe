//! Bounding volume hierarchy: rays and nearest-neighbour searches visit few items.

use nalgebra::{Point3, Vector3};

/// A box along the axes; `low <= high` in every coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Corner of the least coordinates.
    pub low: Point3<f64>,
    /// Corner of the greatest coordinates.
    pub high: Point3<f64>,
}

/// Boxes are padded by this, metres, so that a ray along a face does not slip between floats.
const PADDING_M: f64 = 1e-7;
const MAX_LEAF_ITEMS: usize = 4;

impl Aabb {
    fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.inf(&other.low),
            high: self.high.sup(&other.high),
        }
    }

    /// Range at which a ray enters the box (0 if it starts inside), if it does.
    fn entry(&self, origin: &Point3<f64>, inverse: &Vector3<f64>) -> Option<f64> {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let a = (self.low[axis] - PADDING_M - origin[axis]) * inverse[axis];
            let b = (self.high[axis] + PADDING_M - origin[axis]) * inverse[axis];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter <= leave).then_some(enter)
    }

    fn squared_distance(&self, point: &Point3<f64>) -> f64 {
        (0..3)
            .map(|i| {
                (self.low[i] - point[i])
                    .max(point[i] - self.high[i])
                    .max(0.0)
                    .powi(2)
            })
            .sum()
    }
}

#[derive(Debug, Clone)]
struct Node {
    bounds: Aabb,
    /// Leaf: range in `order`. Inner node: the right child; the left one is the next node.
    first: usize,
    /// Items in the leaf; 0 for an inner node.
    count: usize,
}

/// The tree. Items are the indices in the slice that it was built from.
#[derive(Debug, Clone, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

impl Bvh {
    /// A tree over `bounds`, halved at the median of the longest side: n log n.
    pub(crate) fn build(bounds: &[Aabb]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(bounds.len()),
            order: (0..bounds.len()).collect(),
        };
        let mut order = std::mem::take(&mut tree.order);
        tree.add_node(bounds, &mut order, 0);
        tree.order = order;
        tree
    }

    /// Adds the node of `items`, which begin at `first` in the final order.
    fn add_node(&mut self, bounds: &[Aabb], items: &mut [usize], first: usize) {
        let of = |i: &usize| bounds.get(*i);
        let Some(all) = items
            .iter()
            .filter_map(of)
            .copied()
            .reduce(|a, b| a.union(&b))
        else {
            return;
        };
        let index = self.nodes.len();
        self.nodes.push(Node {
            bounds: all,
            first,
            count: items.len(),
        });
        if items.len() <= MAX_LEAF_ITEMS {
            return;
        }
        let axis = (all.high - all.low).imax();
        let middle = items.len() / 2;
        let key = |i: &usize| of(i).map_or(0.0, |b| b.low[axis] + b.high[axis]);
        items.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let (left, right) = items.split_at_mut(middle);
        self.add_node(bounds, left, first);
        let right_child = self.nodes.len();
        self.add_node(bounds, right, first + middle);
        if let Some(node) = self.nodes.get_mut(index) {
            node.count = 0;
            node.first = right_child;
        }
    }

    /// Visits items near the ray, roughly nearest first; `visit` lowers `limit` (a range in metres) when it hits.
    pub(crate) fn visit_along_ray(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        limit: &mut f64,
        visit: impl FnMut(usize, &mut f64),
    ) {
        let inverse = direction.map(|c| 1.0 / c);
        self.walk(limit, |bounds| bounds.entry(origin, &inverse), visit);
    }

    /// Visits items near `point`; `visit` lowers `limit` (a squared distance) as it finds nearer ones.
    pub(crate) fn visit_near_point(
        &self,
        point: &Point3<f64>,
        limit: &mut f64,
        visit: impl FnMut(usize, &mut f64),
    ) {
        self.walk(limit, |bounds| Some(bounds.squared_distance(point)), visit);
    }

    fn walk(
        &self,
        limit: &mut f64,
        measure: impl Fn(&Aabb) -> Option<f64>,
        mut visit: impl FnMut(usize, &mut f64),
    ) {
        let root = self.nodes.first().and_then(|n| measure(&n.bounds));
        let mut stack = Vec::with_capacity(32);
        stack.extend(root.map(|distance| (distance, 0usize)));
        while let Some((distance, index)) = stack.pop() {
            if distance > *limit {
                continue;
            }
            let Some(node) = self.nodes.get(index) else {
                continue;
            };
            if node.count > 0 {
                for item in self.order.iter().skip(node.first).take(node.count) {
                    visit(*item, limit);
                }
                continue;
            }
            let mut children = [index + 1, node.first]
                .map(|p| Some((self.nodes.get(p).and_then(|n| measure(&n.bounds))?, p)));
            // The nearer child is pushed last and so popped first.
            if let [Some(left), Some(right)] = children
                && left.0 < right.0
            {
                children.swap(0, 1);
            }
            stack.extend(children.into_iter().flatten());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Aabb, Bvh};
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_hit_and_no_neighbour_is_missed(
            corners in proptest::collection::vec(proptest::array::uniform6(-5.0..5.0f64), 0..60),
            origin in proptest::array::uniform3(-6.0..6.0f64),
            direction in proptest::array::uniform3(-1i8..=1),
        ) {
            let boxes: Vec<Aabb> = corners.iter().map(|c| {
                let low = Point3::new(c[0], c[1], c[2]);
                Aabb { low, high: low + Vector3::new(c[3], c[4], c[5]).abs() }
            }).collect();
            let tree = Bvh::build(&boxes);
            let origin = Point3::from(origin);
            let direction = Vector3::from(direction.map(f64::from));
            prop_assume!(direction.norm() > 0.5);
            let inverse = direction.map(|c| 1.0 / c);
            let (mut best, mut limit) = (None, f64::INFINITY);
            tree.visit_along_ray(&origin, &direction, &mut limit, |i, limit| {
                if let Some(t) = boxes[i].entry(&origin, &inverse) && t < *limit {
                    (best, *limit) = (Some(t), t);
                }
            });
            let expected = boxes.iter().filter_map(|b| b.entry(&origin, &inverse)).min_by(f64::total_cmp);
            prop_assert_eq!(best, expected);
            let mut nearest = f64::INFINITY;
            let mut limit = f64::INFINITY;
            tree.visit_near_point(&origin, &mut limit, |i, limit| {
                nearest = nearest.min(boxes[i].squared_distance(&origin));
                *limit = nearest;
            });
            prop_assert_eq!(nearest, boxes.iter().map(|b| b.squared_distance(&origin)).fold(f64::INFINITY, f64::min));
        }
    }
}
