//! The whole comparison, step by step.

use super::algorithm1;
use super::quantify::{Side, quantify, split_settings};
use super::tell::tell;
use super::verdict::{Findings, verdict};
use super::{
    Evidence, EvidenceSettings, Judge, Model, Novelty, NoveltyError, Onlooker, Prepared,
    Segmentation, Settings, Sight, Thing, Verdict, noise, segment,
};
use crate::geometry::{Field, Landmarks, NoiseLaw, Passage, Pose, Registration, View, register};
use crate::mixture::{Components, FitSettings, Mixture, fit, split_until_flat};
use nalgebra::Point3;

/// The step that begins; lets the caller time them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stage {
    /// The current view is indexed and modelled.
    Fit,
    /// The views are brought together.
    Register,
    /// What changed is found.
    Segment,
    /// d_GMM is taken.
    Distance,
}

/// A reference made ready for any number of revisits.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The view, its rays, surfaces and noise.
    pub prepared: Prepared,
    /// Its flat places, ready for registrations.
    pub landmarks: Landmarks,
    /// Its mixture (Gamma of Algorithm 1).
    pub mixture: Mixture,
}

impl Reference {
    /// Indexes and models `view`; `seed` is that of fits with random starts.
    ///
    /// # Errors
    /// A view with too few points or with coordinates that are not finite.
    pub fn prepare(view: &View, settings: &Settings, seed: u64) -> Result<Self, NoveltyError> {
        let prepared = Prepared::of(view, "reference", &settings.evidence)?;
        let mixture = model(&prepared, settings, seed)?;
        Ok(Self {
            landmarks: Landmarks::of(&prepared.surfaces),
            prepared,
            mixture,
        })
    }
}

/// What a comparison found.
#[derive(Debug, Clone)]
pub struct Detection {
    /// Quiet, changed or not observed.
    pub verdict: Verdict,
    /// Why.
    pub reason: String,
    /// d_GMM (Eq. 6), in the unit of the ground distance (metres but for fm).
    pub d_gmm: f64,
    /// The part of d_GMM that no novelty explains.
    pub unexplained: f64,
    /// d_GMM times the visible surface, m^2 m.
    pub work_m3: f64,
    /// The threshold in force, in the unit of d_GMM.
    pub u_th: f64,
    /// What came and what went; positions in the current view's frame.
    pub novelties: Vec<Novelty>,
    /// For each current point, whether it lies on a listed novelty that appeared.
    pub labels: Vec<bool>,
    /// How the views were brought together.
    pub registration: Registration,
    /// How many times further apart than their noise explains the surfaces lie that both views saw.
    pub disagreement: f64,
    /// Components with mass: reference, current.
    pub components: [usize; 2],
    /// Noise used: reference, current.
    pub noise: [NoiseLaw; 2],
    /// Share of each view's surface that the other could see: reference, current.
    pub overlap: [f64; 2],
}

/// Compares `current` with `reference`.
///
/// # Errors
/// A view with too few points or with coordinates that are not finite; a mixture that cannot be
/// fitted. All milder trouble is a verdict.
pub fn detect(
    reference: &Reference,
    current: &View,
    settings: &Settings,
    seed: u64,
    observer: &mut dyn FnMut(Stage),
) -> Result<Detection, NoveltyError> {
    observer(Stage::Fit);
    let now = Prepared::of(current, "current", &settings.evidence)?;
    let then = &reference.prepared;

    observer(Stage::Register);
    let pair = Pair::register(reference, &now, settings);

    observer(Stage::Segment);
    let evidence = pair.judge(settings);
    let onlookers = [pair.onlooker(0), pair.onlooker(1)];
    let (things, literal) = match settings.segmentation {
        Segmentation::Evidence => {
            let things = [
                segment(then, &evidence[0], &onlookers[0], &settings.segment),
                segment(&now, &evidence[1], &onlookers[1], &settings.segment),
            ];
            (things, None)
        }
        Segmentation::Mixture => {
            let own_model = match settings.model {
                Model::Refit => None,
                Model::Independent { .. } => Some(model(&now, settings, seed)?),
            };
            let found = algorithm1::run(&reference.mixture, own_model, &pair, &evidence, settings)?;
            let literal = (found.d, found.contributions, found.components);
            (found.things, Some(literal))
        }
    };

    observer(Stage::Distance);
    let points = [points_of(&things[0]), points_of(&things[1])];
    let sights = evidence.each_ref().map(|e| sights(e));
    let sides = [
        pair.side(0, &sights[0], &points[0]),
        pair.side(1, &sights[1], &points[1]),
    ];
    let mut balance = quantify(&reference.mixture, &sides[0], &sides[1], &settings.quantify)?;
    if let Some((d, contributions, components)) = literal {
        balance.restate(d, contributions, components);
    }
    let novelties = tell(&things, &sides, &onlookers, &balance, &settings.segment)?;

    let mut labels = vec![false; current.points.len()];
    for i in points[1].iter().flatten() {
        labels[*i] = true;
    }
    let disagreement = pair.disagreement();
    let (verdict, reason) = verdict(
        &Findings {
            registration: &pair.registration,
            disagreement,
            balance: &balance,
            u_th: settings.u_th(),
            listed: novelties.len(),
        },
        &settings.verdict,
    );
    Ok(Detection {
        verdict,
        reason,
        d_gmm: balance.d,
        unexplained: balance.rest,
        work_m3: balance.work_m3,
        u_th: settings.u_th(),
        novelties,
        labels,
        disagreement,
        components: balance.components,
        noise: [then.noise, now.noise],
        overlap: balance.overlap,
        registration: pair.registration,
    })
}

/// Two views brought together.
pub struct Pair<'a> {
    /// The reference and the current view.
    pub views: [&'a Prepared; 2],
    /// How they lie on one another.
    pub registration: Registration,
    /// How well they agree on common surfaces.
    pub between: Option<noise::Between>,
}

impl<'a> Pair<'a> {
    fn register(reference: &'a Reference, now: &'a Prepared, settings: &Settings) -> Self {
        let then = &reference.prepared;
        let sigma_m = then
            .noise
            .sigma_m(then.middle_range_m)
            .hypot(now.noise.sigma_m(now.middle_range_m));
        let gate_m = (settings.evidence.gate_sigmas * sigma_m).max(settings.evidence.least_gate_m);
        let registration = register(
            &reference.landmarks,
            &now.surfaces,
            &now.view.origin,
            &Pose::identity(),
            gate_m,
            &settings.registration,
        );
        let between = noise::between(
            &then.surfaces,
            &then.view.origin,
            &now.view.points,
            &registration,
            2.0 * gate_m,
        );
        Self {
            views: [then, now],
            registration,
            between,
        }
    }

    /// Carries places of view `side` (0 reference, 1 current) into the reference's frame.
    pub fn reference_from(&self, side: usize) -> Passage {
        if side == 0 {
            Passage::identity()
        } else {
            self.registration.reference_from_current()
        }
    }

    /// Carries places of view `side` (0 reference, 1 current) into the other view's frame.
    fn other_from(&self, side: usize) -> Passage {
        let reference_from_current = self.registration.reference_from_current();
        match side {
            0 => reference_from_current.inverse(),
            _ => reference_from_current,
        }
    }

    /// The view that judges the points of view `side`.
    fn onlooker(&self, side: usize) -> Onlooker<'a> {
        Onlooker {
            view: self.views[1 - side],
            from_own: self.other_from(side),
        }
    }

    /// Judges each view's points by the other's rays. Far points stay as what rays end at: only that they are judged
    /// themselves ends with the range limit.
    fn judge(&self, settings: &Settings) -> [Vec<Evidence>; 2] {
        [0, 1].map(|side| {
            let (own, other) = (self.views[side], self.views[1 - side]);
            let other_from_own = self.other_from(side);
            let mut evidence = Judge {
                other,
                other_from_own,
                own,
                between: self.between,
                registration: &self.registration,
                reference_from_own: self.reference_from(side),
                field: self.field(side, &settings.evidence),
                settings: &settings.evidence,
            }
            .judge();
            if let Some(most_m) = settings.max_range_m {
                // Near to both sensors, or a surface at the limit would weigh on one side only.
                let other_origin = other_from_own.pose.inverse() * other.view.origin;
                let beyond = |p: &Point3<f64>| {
                    (p - own.view.origin).norm() > most_m || (p - other_origin).norm() > most_m
                };
                for (e, p) in evidence.iter_mut().zip(&own.view.points) {
                    if beyond(p) {
                        *e = Evidence::none(Sight::Beyond);
                    }
                }
            }
            evidence
        })
    }

    /// Bounds of where the view that judges `side` looked, if it is a bare cloud: its own, and, where both sensors stood
    /// alike in their frames, those of the other visit.
    fn field(&self, side: usize, settings: &EvidenceSettings) -> Option<Field> {
        let (own, other) = (self.views[side], self.views[1 - side]);
        if !other.view.no_return.is_empty() {
            return None;
        }
        let alike = (own.view.origin - other.view.origin).norm() < settings.same_stand_m;
        Some(if alike {
            other.rays.field.joined(&own.rays.field)
        } else {
            other.rays.field.clone()
        })
    }

    fn side(&self, side: usize, sights: &'a [Sight], novelties: &'a [Vec<usize>]) -> Side<'a> {
        Side {
            own: self.views[side],
            reference_from_own: self.reference_from(side),
            sights,
            novelties,
        }
    }

    /// Noise between the views over the noise of both, at the reference's median range.
    fn disagreement(&self) -> f64 {
        let [then, now] = self.views;
        let at = then.middle_range_m;
        let both = then.noise.sigma_m(at).hypot(now.noise.sigma_m(at));
        self.between.map_or(0.0, |b| b.ranges.sigma_m(at) / both)
    }
}

/// The mixture of a view by itself, from its thinned surface.
fn model(own: &Prepared, settings: &Settings, seed: u64) -> Result<Mixture, NoveltyError> {
    let most_m = settings.max_range_m.unwrap_or(f64::INFINITY);
    let places: Vec<Point3<f64>> = own
        .surfaces
        .patches
        .iter()
        .map(|p| p.mean)
        .filter(|p| (p - own.view.origin).norm() <= most_m)
        .collect();
    Ok(match settings.model {
        Model::Refit => split_until_flat(&places, None, &split_settings(own))?,
        Model::Independent { most } => {
            let bic = FitSettings {
                components: Components::Bic { max: most },
                seed,
                ..FitSettings::default()
            };
            fit(&places, None, &bic)?.mixture
        }
    })
}

fn points_of(things: &[Thing]) -> Vec<Vec<usize>> {
    things.iter().map(|t| t.points.clone()).collect()
}

fn sights(evidence: &[Evidence]) -> Vec<Sight> {
    evidence.iter().map(|e| e.sight).collect()
}
