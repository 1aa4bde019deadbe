//! The figures of the paper as SVG: Fig. 3 (a corridor and its Gaussians), 4 (how shapes are retrieved), 5 and 6 (scenes
//! and shapes).

use super::panel::{Panel, save};
use crate::cli::failure::Failure;
use nalgebra::Point3;
use patrold_engine::mixture::Gaussian;
use patrold_engine::shape::{Primitive, Shape};
use patrold_lab::reproduce::{
    AppearedPicture, CylinderAttitude, Polyline, ScenePicture, gaussian_outline, shape_outline,
};
use plotters::prelude::{BLACK, BLUE, RED, RGBColor};
use std::path::Path;

/// Standard deviations at which ellipsoids are drawn.
const ELLIPSOID_SIGMAS: f64 = 2.0;
const GREY: RGBColor = RGBColor(150, 150, 150);

/// The letters of the panels that show a scene: before, now, Gaussians, shapes; `None` for those that the paper has not.
pub(super) type PanelLetters = [Option<char>; 4];

/// Writes Fig. 3 as `fig3.svg`: a) a corridor, b) its Gaussians, c) the corridor with something new in red, d) its
/// Gaussians: those of b) where nothing changed, and in red those of the novelty with its number as label.
///
/// # Errors
/// The file cannot be written.
pub(super) fn corridor(folder: &Path, picture: &ScenePicture) -> Result<(), Failure> {
    let kept = outlines_at(1.0, &picture.kept_gaussians);
    let mut changed = Panel::new("d) its Gaussians, 1 sigma; 1: the novelty").lines(kept, GREY, 1);
    for (number, novelty) in (1..).zip(&picture.appeared) {
        changed = changed.lines(outlines_at(1.0, &novelty.gaussians), RED, 2);
        let highest = |a: &&Point3<f64>, b: &&Point3<f64>| a.z.total_cmp(&b.z);
        if let Some(top) = novelty.points.iter().max_by(highest) {
            changed = changed.label(*top, number.to_string(), RED);
        }
    }
    let panels = [
        Panel::new("a) a corridor").points(&picture.before, BLACK),
        Panel::new("b) its Gaussians, 1 sigma").lines(
            outlines_at(1.0, &picture.before_gaussians),
            BLACK,
            1,
        ),
        now("c) something new in it", picture),
        changed,
    ];
    save(folder, "fig3", &panels)
}

/// Writes Fig. 4 as `fig4.svg`: a) points and Gaussians of a novelty, b) samples on their ellipsoids, c) the shapes of
/// method A on these samples (blue) and method B (red), d) the same for the Gaussian of an ideal cylinder (grey).
///
/// # Errors
/// The file cannot be written.
pub(super) fn retrieval(
    folder: &Path,
    novelty: &AppearedPicture,
    attitude: &CylinderAttitude,
) -> Result<(), Failure> {
    let ideal = Primitive::Cylinder(attitude.cylinder);
    let mut cylinder = Panel::new("d) an ideal cylinder (grey), A and B");
    if let Some(shape) = attitude.feature.as_ref().or(attitude.euclidean.as_ref()) {
        let truth = Shape {
            class: ideal.class(),
            rotation: ideal.canonical_rotation(&Point3::origin()),
            size_m: ideal.size_m(),
            centre: ideal.centre(),
            ..shape.clone()
        };
        cylinder = cylinder.lines(shape_outline(&truth), GREY, 5);
    }
    let panels = [
        Panel::new("a) points and Gaussians of a novelty, 1 sigma")
            .points(&novelty.points, GREY)
            .lines(outlines_at(1.0, &novelty.gaussians), BLACK, 1),
        Panel::new("b) samples on the ellipsoids").points(&novelty.samples, BLACK),
        shapes(
            "c) A on samples (blue), B (red)",
            std::slice::from_ref(novelty),
        ),
        cylinder
            .lines(gaussian_outline(&attitude.gaussian, 1.0), BLACK, 1)
            .lines(outline(attitude.euclidean.as_ref()), BLUE, 2)
            .lines(outline(attitude.feature.as_ref()), RED, 2),
    ];
    save(folder, "fig4", &panels)
}

/// Writes a scene as `NAME.svg`: the cloud before, the cloud now with what appeared in red, its Gaussians, and the shapes
/// of method A on samples (blue) and method B (red).
///
/// # Errors
/// The file cannot be written.
pub(super) fn scene(
    folder: &Path,
    name: &str,
    picture: &ScenePicture,
    letters: PanelLetters,
) -> Result<(), Failure> {
    let [before, current, gaussians, retrieved] = letters;
    let title = |letter: Option<char>, text: &str| match letter {
        Some(letter) => format!("{letter}) {text}"),
        None => text.to_owned(),
    };
    let mut novelties = Panel::new(title(gaussians, "Gaussians of what appeared, 2 sigma"));
    for novelty in &picture.appeared {
        novelties =
            novelties
                .points(&novelty.points, GREY)
                .lines(ellipsoids(&novelty.gaussians), BLACK, 1);
    }
    let panels = [
        Panel::new(title(before, "before")).points(&picture.before, GREY),
        now(&title(current, "now"), picture),
        novelties,
        shapes(
            &title(retrieved, "shapes: A on samples (blue), B (red)"),
            &picture.appeared,
        ),
    ];
    save(folder, name, &panels)
}

/// The current cloud, in red what appeared.
fn now(title: &str, picture: &ScenePicture) -> Panel {
    let panel = Panel::new(title).points(&picture.unchanged, GREY);
    let appeared = picture.appeared.iter();
    appeared.fold(panel, |panel, novelty| panel.points(&novelty.points, RED))
}

/// Points and shapes of both methods.
fn shapes(title: &str, appeared: &[AppearedPicture]) -> Panel {
    appeared.iter().fold(Panel::new(title), |panel, novelty| {
        panel
            .points(&novelty.points, GREY)
            .lines(outline(novelty.euclidean.as_ref()), BLUE, 2)
            .lines(outline(novelty.feature.as_ref()), RED, 2)
    })
}

fn outline(shape: Option<&Shape>) -> Vec<Polyline> {
    shape.map(shape_outline).unwrap_or_default()
}

fn ellipsoids(gaussians: &[Gaussian]) -> Vec<Polyline> {
    outlines_at(ELLIPSOID_SIGMAS, gaussians)
}

fn outlines_at(scale: f64, gaussians: &[Gaussian]) -> Vec<Polyline> {
    let outlines = gaussians.iter().map(|g| gaussian_outline(g, scale));
    outlines.flatten().collect()
}
