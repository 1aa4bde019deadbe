//! The scenes of Fig. 3 and 4, and the letters of Fig. 5 and 6.

use super::figure_svg::PanelLetters;
use crate::cli::failure::Failure;
use patrold_lab::reproduce::{
    AppearedPicture, BeamLayout, CorridorNoise, CorridorObject, CorridorScene, PointDensity,
    ScenePair, ScenePicture, TestSite, scene_picture,
};

/// An ideal corridor, as in Fig. 3: the reading of least noise.
pub(super) fn ideal_corridor(object: CorridorObject, seed: u64) -> Result<ScenePair, Failure> {
    let scene = CorridorScene {
        object,
        noise: CorridorNoise::Fine,
        density: PointDensity::Many,
        beams: BeamLayout::Rows,
        number: 0,
    };
    scene.simulate(seed).map_err(Failure::failed)
}

/// The scene of Fig. 3.
pub(super) fn fig3(seed: u64) -> Result<ScenePicture, Failure> {
    scene_picture(&ideal_corridor(CorridorObject::Cylinder, seed)?).map_err(Failure::failed)
}

/// The novelty of Fig. 4, the largest of the door in Fig. 6a: two Gaussians describe it, as in paper Fig. 4a.
pub(super) fn fig4(seed: u64) -> Result<Option<AppearedPicture>, Failure> {
    let scene = TestSite::DoorOpened.simulate(0, seed);
    let picture = scene_picture(&scene.map_err(Failure::failed)?).map_err(Failure::failed)?;
    let appeared = picture.appeared.into_iter();
    Ok(appeared.max_by_key(|novelty| novelty.points.len()))
}

/// The letters of the scene of this object in Fig. 5 and of this site in Fig. 6: before, now, Gaussians, shapes.
pub(super) fn letters(kind: &str) -> PanelLetters {
    let letter = |first: char, nth: usize| char::from_u32(first as u32 + nth as u32);
    let object = CorridorObject::ALL.iter().position(|o| o.as_str() == kind);
    let site = TestSite::ALL.iter().position(|s| s.as_str() == kind);
    match (object, site) {
        (Some(nth), _) => [None, letter('a', nth), None, letter('d', nth)],
        (_, Some(nth)) => ['a', 'd', 'g', 'j'].map(|first| letter(first, nth)),
        _ => [None; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::letters;

    #[test]
    fn panels_have_the_letters_of_the_paper() {
        assert_eq!(letters("sphere"), [None, Some('a'), None, Some('d')]);
        assert_eq!(letters("plane"), [None, Some('c'), None, Some('f')]);
        let closed = ['c', 'f', 'i', 'l'].map(Some);
        assert_eq!(letters("door-closed"), closed);
        assert_eq!(letters("superquadric"), [None; 4]);
    }
}
