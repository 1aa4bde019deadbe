//! Fig. 3 and Fig. 4d as numbers.

use super::figure_scenes::ideal_corridor;
use crate::cli::experiment::number;
use crate::cli::failure::Failure;
use patrold_lab::reproduce::{
    AxisAccuracy, CorridorObject, CylinderAttitude, GaussianRemoval, axis_accuracy,
    cylinder_attitudes, remove_gaussians,
};
use serde::Serialize;

/// Fig. 3 and Fig. 4d.
#[derive(Debug, Serialize)]
pub(super) struct FigureNumbers {
    fig3: Fig3,
    fig4d: Fig4d,
    #[serde(skip)]
    attitudes: Vec<CylinderAttitude>,
}

/// d_GMM while Gaussians are removed.
#[derive(Debug, Serialize)]
struct Fig3 {
    scene: String,
    set: &'static str,
    #[serde(flatten)]
    removal: GaussianRemoval,
}

/// An ideal cylinder by both methods.
#[derive(Debug, Serialize)]
struct Fig4d {
    attitudes: usize,
    euclidean: AxisAccuracy,
    feature: AxisAccuracy,
}

impl FigureNumbers {
    /// The figures of this seed.
    pub(super) fn new(seed: u64) -> Result<Self, Failure> {
        let scene = ideal_corridor(CorridorObject::Cylinder, seed)?;
        let empty = ideal_corridor(CorridorObject::Nothing, seed)?;
        let removal = remove_gaussians(&scene, &empty.current).map_err(Failure::failed)?;
        let attitudes = cylinder_attitudes(seed).map_err(Failure::failed)?;
        Ok(Self {
            fig3: Fig3 {
                scene: scene.name,
                set: "fine",
                removal,
            },
            fig4d: Fig4d {
                attitudes: attitudes.len(),
                euclidean: axis_accuracy(&attitudes, |a| a.euclidean.as_ref()),
                feature: axis_accuracy(&attitudes, |a| a.feature.as_ref()),
            },
            attitudes,
        })
    }

    /// Fig. 3.
    pub(super) fn removal(&self) -> &GaussianRemoval {
        &self.fig3.removal
    }

    /// Fig. 4d.
    pub(super) fn attitudes(&self) -> &[CylinderAttitude] {
        &self.attitudes
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let Fig3 {
            scene,
            set,
            removal,
        } = &self.fig3;
        let steps = removal.steps.iter().map(|step| {
            let of = if step.of_object {
                "of the object"
            } else {
                "another"
            };
            format!("{:.4} ({of})", step.d_gmm_m)
        });
        let steps: Vec<String> = steps.collect();
        format!(
            "Fig. 3, {scene} ({set}): {} and {} Gaussians, d_GMM {:.4} m ({:.4} of another view with nothing new), U_th {:.4}; removed one by one: {}\n\
             Fig. 4d, Euclidean space: {}\nFig. 4d, feature space: {}",
            removal.components[0],
            removal.components[1],
            removal.d_gmm_m,
            removal.unchanged_m,
            removal.u_th_m,
            steps.join(", "),
            self.fig4d.text(&self.fig4d.euclidean),
            self.fig4d.text(&self.fig4d.feature)
        )
    }
}

impl Fig4d {
    fn text(&self, accuracy: &AxisAccuracy) -> String {
        format!(
            "cylinder {} of {}, axis off by {} deg (median), {} deg (max)",
            accuracy.right,
            self.attitudes,
            number(accuracy.median_deg, 2),
            number(accuracy.max_deg, 2)
        )
    }
}
