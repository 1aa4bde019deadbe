//! Whether two sightings are of one thing: the ratio of two likelihoods (docs/novelty.md section 15).

use super::constants::{
    COMES_BACK, GOES, MAX_CHI_SQUARE_3, MAX_CHI_SQUARE_6, MAX_CHI_SQUARE_9, MOVES, NEW_THINGS,
    PLACE_VOLUME_M3, STAYS, TURNED_SD_SHARES, WHOLE_RATIO, WIDTH_RANGE_M, WRONG_CLASS_SHARE,
};
use super::incident::{AlarmState, Incident, Relation};
use super::sighting::{Lengths, SHAPE_CLASSES, Sighting};
use patrold_engine::novelty::PlaceView;
use std::f64::consts::TAU;

/// How an incident's thing would have become a sighting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Likeness {
    pub(super) relation: Relation,
    /// Logarithm of the likelihood that the sighting is the incident's thing, over that of a new thing while the
    /// incident's is not seen.
    pub(super) gain: f64,
    /// Distance from where it was, metres.
    pub(super) distance_m: f64,
}

/// A difference of normal figures.
#[derive(Clone, Copy)]
struct Difference {
    figures: usize,
    chi_square: f64,
    log_density: f64,
}

/// The most likely way in which `seen` is the thing of `incident`; `None` if it is another thing.
pub(super) fn likeness(
    incident: &Incident,
    place: PlaceView,
    seen: &Sighting,
    same_place_m: f64,
) -> Option<Likeness> {
    let anchor = &incident.anchor;
    let offset = seen.centre - anchor.centre;
    if anchor.kind != seen.kind || !offset.iter().all(|x| x.is_finite()) {
        return None;
    }
    let place_sd = [0, 1, 2].map(|axis| anchor.centre_sd_m[axis].hypot(seen.centre_sd_m[axis]));
    let of_place = Difference::new(offset.into(), place_sd);
    let stays = of_place.chi_square <= MAX_CHI_SQUARE_3 && offset.norm() <= same_place_m;
    // In its place a thing shows the same part of it; elsewhere it may be turned.
    let of_size = size_difference(
        anchor,
        seen,
        if stays { [0.0; 3] } else { TURNED_SD_SHARES },
    );
    let has_bodies = of_size.figures > 3;
    let agreement = class_agreement(anchor, seen);
    let of_thing = if stays {
        of_place.with(of_size)
    } else {
        of_size
    };
    let is_same = of_thing.chi_square - 2.0 * agreement.ln().min(0.0) <= of_thing.limit();
    let is_back = incident.state == AlarmState::Cleared;
    let relation = match (is_back, stays, is_same) {
        (true, true, true) => Relation::Back,
        (false, true, true) => Relation::Seen,
        // In doubt an open incident goes on; what was acknowledged or is gone never stands for another thing.
        (false, true, false) if incident.state == AlarmState::Open => Relation::Changed,
        // A thing that may still stand where nobody could look has not moved.
        (false, false, true) if place != PlaceView::Hidden => Relation::Moved,
        _ => return None,
    };
    let of_relation = match relation {
        Relation::Back => COMES_BACK.ln(),
        Relation::Moved => MOVES.ln() - PLACE_VOLUME_M3.ln(),
        _ => STAYS.ln(),
    };
    let not_seen = match (is_back, place) {
        (true, _) | (_, PlaceView::Hidden) => 0.0,
        _ => GOES.ln(),
    };
    let same = of_relation + of_thing.log_density + agreement.ln();
    let gain = same - log_density_of_new(seen, has_bodies) - not_seen;
    (gain > 0.0).then_some(Likeness {
        relation,
        gain,
        distance_m: offset.norm(),
    })
}

impl Difference {
    fn new(differences: [f64; 3], sd: [f64; 3]) -> Self {
        let mut sum = Self {
            figures: 3,
            chi_square: 0.0,
            log_density: 0.0,
        };
        for (difference, sd) in differences.into_iter().zip(sd) {
            let z = difference / sd;
            sum.chi_square += z * z;
            sum.log_density -= 0.5 * (z * z + (TAU * sd * sd).ln());
        }
        sum
    }

    /// Both, of independent figures.
    fn with(self, other: Self) -> Self {
        Self {
            figures: self.figures + other.figures,
            chi_square: self.chi_square + other.chi_square,
            log_density: self.log_density + other.log_density,
        }
    }

    /// What its chi-square may be if there is none.
    fn limit(&self) -> f64 {
        match self.figures {
            ..=3 => MAX_CHI_SQUARE_3,
            4..=6 => MAX_CHI_SQUARE_6,
            _ => MAX_CHI_SQUARE_9,
        }
    }
}

/// Of what is seen and of the whole, where both sightings have a shape. `turned_shares` are the errors of the widths by another
/// aspect.
fn size_difference(a: &Sighting, b: &Sighting, turned_shares: [f64; 3]) -> Difference {
    let of = |a: &Lengths, b: &Lengths, shares: [f64; 3]| {
        let difference = [0, 1, 2].map(|axis| b.m[axis] - a.m[axis]);
        let sd = [0, 1, 2].map(|axis| {
            let turned_m = shares[axis] * a.m[axis].max(b.m[axis]);
            a.sd_m[axis].hypot(b.sd_m[axis]).hypot(turned_m)
        });
        Difference::new(difference, sd)
    };
    let of_widths = of(&a.widths, &b.widths, turned_shares);
    match (&a.body, &b.body) {
        (Some(a), Some(b)) => of_widths.with(of(a, b, [0.0; 3])),
        _ => of_widths,
    }
}

/// Likelihood of both sightings' classes if they are of one thing, over that if they are of two.
fn class_agreement(a: &Sighting, b: &Sighting) -> f64 {
    let classes = SHAPE_CLASSES.len() as f64;
    let doubted = |p: f64| (1.0 - WRONG_CLASS_SHARE) * p + WRONG_CLASS_SHARE / classes;
    let pairs = a.classes.iter().zip(&b.classes);
    pairs
        .map(|(p, q)| doubted(*p) * doubted(*q) * classes)
        .sum()
}

/// Logarithm of the density of new things of this size at one place: in a visit, per cubic metre and per metre of each length
/// that is compared.
fn log_density_of_new(seen: &Sighting, with_body: bool) -> f64 {
    let [from, to] = WIDTH_RANGE_M;
    let log_uniform = |length: f64, ratio: f64| -(ratio.ln() * length.max(from)).ln();
    let widths = seen.widths.m.iter().map(|m| log_uniform(*m, to / from));
    // The whole is little larger than what is seen of it.
    let body = seen.body.iter().filter(|_| with_body);
    let body = body
        .flat_map(|body| body.m)
        .map(|m| log_uniform(m, WHOLE_RATIO));
    // Three widths in falling order: six orders fall together.
    NEW_THINGS.ln() - PLACE_VOLUME_M3.ln() + 6.0_f64.ln() + widths.sum::<f64>() + body.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::super::constants::{NEW_THINGS, PLACE_VOLUME_M3, WHOLE_RATIO};
    use super::{Difference, Lengths, Sighting, class_agreement, likeness, log_density_of_new};
    use crate::alarm::{AlarmState, Incident};
    use nalgebra::{Matrix3, Point3};
    use patrold_engine::novelty::NoveltyKind;
    use patrold_engine::novelty::PlaceView;

    /// Of a thing whose points spread as those of a box of these sides.
    fn sighting(sides_m: [f64; 3], body_m: Option<[f64; 3]>) -> Sighting {
        let lengths = |m| Lengths { m, sd_m: [0.01; 3] };
        Sighting {
            kind: NoveltyKind::Appeared,
            centre: Point3::new(1.0, 2.0, 0.5),
            centre_sd_m: [0.03; 3],
            spread: Matrix3::from_diagonal(&sides_m.map(|side| side * side / 12.0).into()),
            widths: lengths(sides_m),
            body: body_m.map(lengths),
            classes: [1.0 / 6.0; 6],
        }
    }

    /// A product of densities: per order of magnitude of each width from 5 cm to 2.5 m, a factor of 50; six orders of the widths;
    /// the whole up to three times as long.
    #[test]
    fn new_things_of_each_size_are_as_probable_as_the_product_of_their_lengths_says() {
        let per_width = 1.0 / 50.0_f64.ln();
        let widths = NEW_THINGS / PLACE_VOLUME_M3 * 6.0 * per_width.powi(3) / (2.0 * 0.5 * 0.1);
        let per_length = 1.0 / WHOLE_RATIO.ln();
        let body = per_length.powi(3) / (2.2 * 0.6 * 0.3);
        let without = sighting([2.0, 0.5, 0.1], None);
        let with = sighting([2.0, 0.5, 0.1], Some([2.2, 0.6, 0.3]));
        for (seen, compared, expected) in [
            (&without, false, widths),
            (&without, true, widths),
            (&with, false, widths),
            (&with, true, widths * body),
        ] {
            let density = log_density_of_new(seen, compared).exp();
            assert!(
                (density / expected - 1.0).abs() < 1e-9,
                "{density} {expected}"
            );
        }
        // Below the range, as at its end.
        let thin = log_density_of_new(&sighting([2.0, 0.5, 0.001], None), false).exp();
        let least = log_density_of_new(&sighting([2.0, 0.5, 0.05], None), false).exp();
        assert!((thin / least - 1.0).abs() < 1e-9);
    }

    /// The density of a normal distribution: 1 sd off, and 2 sd off, of 0.1 m; and both together.
    #[test]
    fn independent_differences_add_up() {
        let one = Difference::new([0.1, 0.0, 0.0], [0.1; 3]);
        let other = Difference::new([0.0, 0.2, 0.1], [0.1; 3]);
        let at_zero = -3.0 * (0.1 * std::f64::consts::TAU.sqrt()).ln();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        near(one.chi_square, 1.0);
        near(one.log_density, at_zero - 0.5);
        near(other.chi_square, 5.0);
        near(other.log_density, at_zero - 2.5);
        let both = one.with(other);
        assert_eq!(both.figures, 6);
        near(both.chi_square, 6.0);
        near(both.log_density, 2.0 * at_zero - 3.0);
    }

    /// One shape in ten has a wrong class, any of the six.
    #[test]
    fn classes_agree_as_their_doubted_probabilities_say() {
        let of = |class: Option<usize>| {
            let mut seen = sighting([1.0; 3], None);
            if let Some(class) = class {
                seen.classes = [0.0; 6];
                seen.classes[class] = 1.0;
            }
            seen
        };
        let (right, wrong) = (0.9 + 0.1 / 6.0, 0.1 / 6.0);
        for (one, other, expected) in [
            (
                Some(3),
                Some(3),
                6.0 * (right * right + 5.0 * wrong * wrong),
            ),
            (
                Some(3),
                Some(4),
                6.0 * (2.0 * right * wrong + 4.0 * wrong * wrong),
            ),
            (Some(3), None, 1.0),
            (None, None, 1.0),
        ] {
            let agreement = class_agreement(&of(one), &of(other));
            assert!(
                (agreement - expected).abs() < 1e-9,
                "{agreement} {expected}"
            );
        }
    }

    /// A body that the other sighting has not is no evidence, neither of one thing nor of two.
    #[test]
    fn a_body_counts_where_both_have_one() {
        let gain = |anchor_body, seen_body| {
            let incident = Incident {
                id: 1,
                state: AlarmState::Open,
                anchor: sighting([0.5, 0.4, 0.3], anchor_body),
            };
            let seen = sighting([0.5, 0.4, 0.3], seen_body);
            let found = likeness(&incident, PlaceView::Otherwise, &seen, 0.5);
            found.expect("the same thing").gain
        };
        let body = Some([0.6, 0.5, 0.4]);
        let without = gain(None, None);
        assert_eq!(gain(None, body), without);
        assert_eq!(gain(body, None), without);
        assert!(gain(body, body) > without + 1.0);
    }
}
