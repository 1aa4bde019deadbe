//! What a column of Tables I and II says of many scenes.

use super::Mark;

/// Counts and spreads over scenes.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Scenes with something new.
    pub objects: usize,
    /// Scenes with nothing new.
    pub empty: usize,
    /// Shapes told in all of them, `ambiguous` left out.
    pub shapes: usize,
    /// Things told with their class.
    pub right: usize,
    /// Things told as ambiguous.
    pub ambiguous: usize,
    /// Shapes told that are not there.
    pub wrong: usize,
    /// Root mean square error of the sizes, centimetres, over shapes of the right class.
    pub size_cm: [Option<f64>; 3],
    /// Mean of the sizes' errors, centimetres; what is left of the above is their standard deviation.
    pub size_bias_cm: [Option<f64>; 3],
    /// Median error of the sizes, share of the true size.
    pub size_share: Option<f64>,
    /// Root mean square rotation about the shape's own axes, degrees.
    pub rotation_deg: [Option<f64>; 3],
    /// Share of sizes within their 95 % interval.
    pub coverage: Option<f64>,
    /// Median time of the whole chain, milliseconds.
    pub chain_ms: f64,
    /// Median time of making the reference ready, milliseconds.
    pub reference_ms: f64,
    /// Mean bytes of mixture, and of the cloud that it stands for.
    pub bytes: [f64; 2],
}

impl Row {
    /// Over these scenes.
    pub fn of<'a>(marks: impl Iterator<Item = &'a Mark> + Clone) -> Self {
        let count = |of: fn(&Mark) -> usize| marks.clone().map(of).sum::<usize>();
        let median = |of: fn(&Mark) -> f64| {
            let mut all: Vec<f64> = marks.clone().map(of).collect();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied().unwrap_or(0.0)
        };
        let scenes = marks.clone().count().max(1) as f64;
        let covered = marks
            .clone()
            .fold([0; 2], |[a, b], m| [a + m.covered[0], b + m.covered[1]]);
        Self {
            objects: count(|m| usize::from(m.real)),
            empty: count(|m| usize::from(!m.real)),
            shapes: count(|m| m.shapes),
            right: count(|m| usize::from(m.right)),
            ambiguous: count(|m| usize::from(m.ambiguous)),
            wrong: count(|m| m.wrong),
            size_cm: [0, 1, 2]
                .map(|k| rms(marks.clone().filter_map(|m| m.size_error_m?[k])).map(|e| 100.0 * e)),
            size_bias_cm: [0, 1, 2]
                .map(|k| mean(marks.clone().filter_map(|m| m.size_error_m?[k])).map(|e| 100.0 * e)),
            size_share: {
                let shares = marks
                    .clone()
                    .filter_map(|m| m.size_share)
                    .flatten()
                    .flatten();
                let mut shares: Vec<f64> = shares.collect();
                shares.sort_by(f64::total_cmp);
                shares.get(shares.len() / 2).copied()
            },
            rotation_deg: [0, 1, 2].map(|k| {
                rms(marks.clone().filter_map(|m| m.rotation_error_rad?[k])).map(f64::to_degrees)
            }),
            coverage: (covered[1] > 0).then(|| covered[0] as f64 / covered[1] as f64),
            chain_ms: median(|m| m.chain_ms),
            reference_ms: median(|m| m.reference_ms),
            bytes: [0, 1].map(|k| marks.clone().map(|m| m.bytes[k] as f64).sum::<f64>() / scenes),
        }
    }

    /// TruePos and FalsePos of Eq. 14 with `NumberShapes` read as the number of true things, as the counts of Table I
    /// are; where nothing was there, of scenes.
    pub fn per_object(&self) -> [f64; 2] {
        self.over(if self.objects > 0 {
            self.objects
        } else {
            self.empty
        })
    }

    /// The same with `NumberShapes` as printed: the shapes that were told.
    pub fn per_shape(&self) -> [f64; 2] {
        self.over(self.shapes)
    }

    /// Share of the things told right of those that were not told as ambiguous; `None` where nothing is left.
    pub fn definite(&self) -> Option<f64> {
        let left = self.objects - self.ambiguous;
        (left > 0).then(|| self.right as f64 / left as f64)
    }

    /// Share of the things told as ambiguous; `None` where nothing was there.
    pub fn ambiguous_share(&self) -> Option<f64> {
        (self.objects > 0).then(|| self.ambiguous as f64 / self.objects as f64)
    }

    fn over(&self, number: usize) -> [f64; 2] {
        [self.right, self.wrong].map(|n| n as f64 / number.max(1) as f64)
    }
}

fn mean(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = errors.fold((0.0, 0), |(s, n), e| (s + e, n + 1));
    (count > 0).then(|| sum / f64::from(count))
}

fn rms(errors: impl Iterator<Item = f64>) -> Option<f64> {
    mean(errors.map(|e| e * e)).map(f64::sqrt)
}

/// A column of the paper's table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperColumn {
    /// Table, 1 or 2.
    pub table: u8,
    /// Its heading.
    pub heading: &'static str,
    /// Execution time, milliseconds.
    pub time_ms: f64,
    /// TruePos and FalsePos.
    pub rates: [f64; 2],
    /// Standard deviation of the size, centimetres.
    pub size_cm: [f64; 3],
    /// Standard deviation of the rotation, degrees.
    pub rotation_deg: [f64; 3],
}

/// Tables I and II as printed.
pub const PAPER: [PaperColumn; 4] = [
    PaperColumn {
        table: 1,
        heading: "Euclidean Space",
        time_ms: 349.1,
        rates: [0.8330, 0.1467],
        size_cm: [12.13, 11.01, 8.09],
        rotation_deg: [2.01, 1.12, 3.22],
    },
    PaperColumn {
        table: 1,
        heading: "Feature Space",
        time_ms: 74.25,
        rates: [0.9367, 0.0400],
        size_cm: [9.11, 7.998, 7.11],
        rotation_deg: [1.32, 1.99, 2.88],
    },
    PaperColumn {
        table: 2,
        heading: "Euclidean Space",
        time_ms: 323.1,
        rates: [0.8667, 0.1912],
        size_cm: [16.21, 13.24, 10.55],
        rotation_deg: [4.21, 3.98, 5.12],
    },
    PaperColumn {
        table: 2,
        heading: "Feature Space",
        time_ms: 315.6,
        rates: [0.9000, 0.0667],
        size_cm: [12.12, 6.22, 8.19],
        rotation_deg: [3.12, 2.01, 3.02],
    },
];

#[cfg(test)]
mod tests {
    use super::Row;
    use crate::reproduce::Mark;

    fn mark(real: bool, right: bool, wrong: usize) -> Mark {
        Mark {
            name: String::new(),
            real,
            shapes: wrong + usize::from(right),
            right,
            ambiguous: false,
            wrong,
            told: None,
            size_error_m: right.then_some([Some(0.03), Some(-0.04), None]),
            size_share: right.then_some([Some(0.1), Some(0.2), None]),
            rotation_error_rad: None,
            covered: [usize::from(right), 2 * usize::from(right)],
            chain_ms: 1.0,
            reference_ms: 2.0,
            bytes: [40, 4800],
        }
    }

    #[test]
    fn both_readings_of_equation_14_are_counted() {
        let marks = [
            mark(true, true, 0),
            mark(true, true, 1),
            mark(true, false, 1),
            mark(true, false, 0),
            mark(false, false, 1),
        ];
        let row = Row::of(marks.iter());
        // Two things right, two sizes each: the upper of the two in the middle.
        assert_eq!(row.size_share, Some(0.2));
        assert_eq!((row.objects, row.empty, row.shapes), (4, 1, 5));
        assert_eq!(row.per_object(), [0.5, 0.75]);
        assert_eq!(row.per_shape(), [0.4, 0.6]);
        assert!((row.size_cm[1].expect("sizes") - 4.0).abs() < 1e-12);
        assert!((row.size_bias_cm[0].expect("sizes") - 3.0).abs() < 1e-12);
        assert_eq!((row.size_cm[2], row.coverage), (None, Some(0.5)));
    }

    #[test]
    fn what_is_ambiguous_is_no_miss_of_the_class() {
        let ambiguous = Mark {
            ambiguous: true,
            ..mark(true, false, 0)
        };
        let marks = [
            mark(true, true, 0),
            ambiguous.clone(),
            mark(true, false, 1),
            mark(false, false, 0),
        ];
        let row = Row::of(marks.iter());
        assert_eq!(row.definite(), Some(0.5));
        assert_eq!(row.ambiguous_share(), Some(1.0 / 3.0));
        assert_eq!(Row::of([ambiguous].iter()).definite(), None);
        let empty = Row::of(marks[3..].iter());
        assert_eq!((empty.definite(), empty.ambiguous_share()), (None, None));
    }
}
