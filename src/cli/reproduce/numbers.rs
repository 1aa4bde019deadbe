//! Fig. 3 and Fig. 4d as numbers.

use crate::cli::failure::Failure;
use patrold_lab::reproduce::{
    Attitude, Beams, Corridor, Density, Noise, Removals, Thing, Told, attitudes, removals, told,
};
use serde::Serialize;

/// What the figures show.
#[derive(Debug, Serialize)]
pub struct Figures {
    fig3: Fig3,
    fig4d: Fig4d,
    #[serde(skip)]
    removals: Removals,
    #[serde(skip)]
    attitudes: Vec<Attitude>,
}

/// d_GMM while Gaussians are taken away.
#[derive(Debug, Serialize)]
struct Fig3 {
    scene: String,
    set: &'static str,
    u_th_m: f64,
    unchanged_m: f64,
    components: [usize; 2],
    d_gmm_m: f64,
    removed: Vec<Taken>,
}

/// One that was taken.
#[derive(Debug, Serialize)]
struct Taken {
    mean: [f64; 3],
    weight: f64,
    of_thing: bool,
    d_gmm_m: f64,
}

/// An ideal cylinder by both methods.
#[derive(Debug, Serialize)]
struct Fig4d {
    attitudes: usize,
    euclidean: Axis,
    feature: Axis,
}

/// A method's axis.
#[derive(Debug, Serialize)]
struct Axis {
    right: usize,
    median_deg: Option<f64>,
    most_deg: Option<f64>,
}

impl Axis {
    fn of(told: &Told) -> Self {
        Self {
            right: told.right,
            median_deg: told.median_deg,
            most_deg: told.most_deg,
        }
    }

    fn prose(&self, attitudes: usize) -> String {
        let deg = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{v:.2}"));
        format!(
            "cylinder {} of {attitudes}, axis off by {} deg (median), {} deg (most)",
            self.right,
            deg(self.median_deg),
            deg(self.most_deg)
        )
    }
}

impl Figures {
    /// The figures of this seed.
    pub fn new(seed: u64) -> Result<Self, Failure> {
        // The corridor of Fig. 3 is ideal: the reading of least noise.
        let corridor = |thing| Corridor {
            thing,
            noise: Noise::Fine,
            density: Density::Many,
            beams: Beams::Rows,
            number: 0,
        };
        let look = corridor(Thing::Cylinder).look(seed);
        let look = look.map_err(Failure::failed)?;
        let empty = corridor(Thing::Nothing).look(seed);
        let empty = empty.map_err(Failure::failed)?;
        let removals = removals(&look, &empty.current).map_err(Failure::failed)?;
        let attitudes = attitudes(seed).map_err(Failure::failed)?;
        let removed = removals.steps.iter().map(|s| Taken {
            mean: s.mean.coords.into(),
            weight: s.weight,
            of_thing: s.of_thing,
            d_gmm_m: s.d_gmm_m,
        });
        Ok(Self {
            fig3: Fig3 {
                scene: look.name,
                set: "fine",
                u_th_m: removals.u_th_m,
                unchanged_m: removals.unchanged_m,
                components: removals.components,
                d_gmm_m: removals.d_gmm_m,
                removed: removed.collect(),
            },
            fig4d: Fig4d {
                attitudes: attitudes.len(),
                euclidean: Axis::of(&told(&attitudes, |a| a.euclidean.as_ref())),
                feature: Axis::of(&told(&attitudes, |a| a.feature.as_ref())),
            },
            removals,
            attitudes,
        })
    }

    /// Fig. 3.
    pub fn removals(&self) -> &Removals {
        &self.removals
    }

    /// Fig. 4d.
    pub fn attitudes(&self) -> &[Attitude] {
        &self.attitudes
    }

    /// For people.
    pub fn prose(&self) -> String {
        let steps = self.fig3.removed.iter().map(|taken| {
            let whose = if taken.of_thing {
                "the thing's"
            } else {
                "another"
            };
            format!("{:.4} ({whose})", taken.d_gmm_m)
        });
        let steps: Vec<String> = steps.collect();
        let Fig4d {
            attitudes,
            euclidean,
            feature,
        } = &self.fig4d;
        format!(
            "Fig. 3, {} ({}): {} and {} Gaussians, d_GMM {:.4} m ({:.4} of another look with nothing new), U_th {:.4}; taken away one by one: {}\n\
             Fig. 4d, Euclidean space: {}\nFig. 4d, feature space: {}",
            self.fig3.scene,
            self.fig3.set,
            self.fig3.components[0],
            self.fig3.components[1],
            self.fig3.d_gmm_m,
            self.fig3.unchanged_m,
            self.fig3.u_th_m,
            steps.join(", "),
            euclidean.prose(*attitudes),
            feature.prose(*attitudes)
        )
    }
}
