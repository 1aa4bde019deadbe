//! Whether a visit could see a place where a thing is known to stand or to be missing, whatever it lists there.

use super::constants::{HIDDEN_PLACE_SHARE, PLACE_SAMPLES, PLACE_SHELL, UNLIKE_PLACE_SHARE};
use super::stored_view::sample_component;
use super::view_pair::ViewPair;
use super::{Detection, NoveltyKind, NoveltySettings, Reference, Visibility};
use crate::geometry::Registration;
use crate::mixture::Gaussian;
use nalgebra::Point3;

/// Where a novelty was, in the reference's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchedPlace {
    /// Whether a thing appeared or disappeared there.
    pub kind: NoveltyKind,
    /// Mean and covariance of its points.
    pub moments: Gaussian,
}

/// How a visit saw a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlaceView {
    /// As in the reference: looked through where a thing had appeared, on the surface where one had disappeared.
    AsTaught,
    /// Not as in the reference.
    Otherwise,
    /// It could not be seen.
    Hidden,
}

/// How the visit of `detection`, which was compared with `reference`, sees each of `places`.
pub fn observe_places(
    reference: &Reference,
    detection: &Detection,
    places: &[WatchedPlace],
    settings: &NoveltySettings,
) -> Vec<PlaceView> {
    let taught = &reference.prepared;
    let pair = |views, registration: &Registration| ViewPair {
        views,
        registration: registration.clone(),
        cross_view_noise: None,
    };
    let of_visit = pair([taught, &detection.current], &detection.registration);
    let of_reference = pair([taught, taught], &Registration::identity());
    let observe = |place: &WatchedPlace| {
        let moments = &place.moments;
        if !(moments.mean.iter().chain(moments.covariance.iter())).all(|x| x.is_finite()) {
            return PlaceView::Hidden;
        }
        let samples = match place.kind {
            // What the reference could not look through says nothing.
            NoveltyKind::Appeared => {
                let all: Vec<_> = sample_component(&place.moments, PLACE_SAMPLES).collect();
                let was = of_reference.visibility_of(&all, settings);
                let free = all.into_iter().zip(was);
                free.filter(|(_, was)| *was == Visibility::FreeSpace)
                    .map(|(p, _)| p)
                    .collect()
            }
            NoveltyKind::Disappeared => surface_within(&place.moments, &taught.view.points),
        };
        let seen = of_visit.visibility_of(&samples, settings);
        place_view(place.kind, &seen)
    };
    places.iter().map(observe).collect()
}

/// Points of the reference that belong to what is missing.
fn surface_within(moments: &Gaussian, points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let Some(inverse) = moments.covariance.try_inverse() else {
        return Vec::new();
    };
    let is_within = |p: &&Point3<f64>| {
        let offset = *p - moments.mean;
        offset.dot(&(inverse * offset)) <= PLACE_SHELL
    };
    let within: Vec<Point3<f64>> = points.iter().filter(is_within).copied().collect();
    let step = within.len().div_ceil(PLACE_SAMPLES as usize).max(1);
    within.into_iter().step_by(step).collect()
}

fn place_view(kind: NoveltyKind, seen: &[Visibility]) -> PlaceView {
    let (taught, otherwise) = match kind {
        NoveltyKind::Appeared => (Visibility::FreeSpace, Visibility::OnSurface),
        NoveltyKind::Disappeared => (Visibility::OnSurface, Visibility::FreeSpace),
    };
    let count = |of: Visibility| seen.iter().filter(|v| **v == of).count() as f64;
    let total = seen.len() as f64;
    let hidden = total - count(taught) - count(otherwise);
    if seen.is_empty() || hidden > HIDDEN_PLACE_SHARE * total {
        PlaceView::Hidden
    } else if count(otherwise) > UNLIKE_PLACE_SHARE * total {
        PlaceView::Otherwise
    } else {
        PlaceView::AsTaught
    }
}

#[cfg(test)]
mod tests {
    use super::{PlaceView, place_view};
    use crate::novelty::{NoveltyKind, Visibility};

    #[test]
    fn a_place_is_judged_by_what_could_be_seen_of_it() {
        let seen = |free: usize, surface: usize, occluded: usize| -> Vec<Visibility> {
            [
                vec![Visibility::FreeSpace; free],
                vec![Visibility::OnSurface; surface],
                vec![Visibility::Occluded; occluded],
            ]
            .concat()
        };
        use NoveltyKind::{Appeared, Disappeared};
        use PlaceView::{AsTaught, Hidden, Otherwise};
        for (kind, seen, expected) in [
            (Appeared, seen(10, 0, 0), AsTaught),
            (Appeared, seen(8, 2, 0), AsTaught),
            (Appeared, seen(7, 3, 0), Otherwise),
            (Appeared, seen(5, 0, 5), AsTaught),
            (Appeared, seen(4, 0, 6), Hidden),
            (Appeared, seen(0, 4, 6), Hidden),
            (Appeared, seen(0, 0, 0), Hidden),
            (Disappeared, seen(0, 10, 0), AsTaught),
            (Disappeared, seen(3, 7, 0), Otherwise),
            (Disappeared, seen(2, 8, 0), AsTaught),
            (Disappeared, seen(10, 0, 0), Otherwise),
        ] {
            assert_eq!(place_view(kind, &seen), expected, "{kind:?} {seen:?}");
        }
    }
}
