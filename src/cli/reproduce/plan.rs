//! The scenes of a run.

use clap::ValueEnum;
use patrold_engine::report::class_name;
use patrold_lab::reproduce::{
    BeamLayout, CorridorNoise, CorridorObject, CorridorScene, FurnishedRoom, PointDensity,
    ScenePair, ScenePairError, TestSite,
};

/// The sets of table1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum CorridorSetArg {
    /// Noise of variance 0.001 m^2, 60-120 points on the object
    Printed,
    /// The same, 15-30 points
    PrintedFew,
    /// Noise of 1 mm, 60-120 points
    Fine,
    /// The same, 15-30 points
    FineFew,
}

impl CorridorSetArg {
    fn as_str(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::PrintedFew => "printed-few",
            Self::Fine => "fine",
            Self::FineFew => "fine-few",
        }
    }

    fn noise_and_density(self) -> (CorridorNoise, PointDensity) {
        match self {
            Self::Printed => (CorridorNoise::Printed, PointDensity::Many),
            Self::PrintedFew => (CorridorNoise::Printed, PointDensity::Few),
            Self::Fine => (CorridorNoise::Fine, PointDensity::Many),
            Self::FineFew => (CorridorNoise::Fine, PointDensity::Few),
        }
    }
}

/// One scene to be judged.
#[derive(Debug, Clone, Copy)]
pub(super) enum ScenePlan {
    Corridor(CorridorSetArg, CorridorScene),
    /// With the number of the repeat.
    Site(TestSite, usize),
    Room(FurnishedRoom),
}

impl ScenePlan {
    /// Set that it belongs to.
    pub(super) fn set(&self) -> &'static str {
        match self {
            Self::Corridor(set, _) => set.as_str(),
            Self::Site(..) => "sites",
            Self::Room(_) => "rooms",
        }
    }

    /// Its object or site.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Corridor(_, corridor) => corridor.object.as_str(),
            Self::Site(site, _) => site.as_str(),
            Self::Room(room) => room
                .class
                .map_or(CorridorObject::Nothing.as_str(), class_name),
        }
    }

    /// Whether nothing appears in it.
    pub(super) fn is_empty(&self) -> bool {
        self.kind() == CorridorObject::Nothing.as_str()
    }

    /// The name by which it can be run alone.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Corridor(_, corridor) => corridor.name(),
            Self::Site(site, repeat) => format!("{}-{repeat}", site.as_str()),
            Self::Room(room) => format!("{}-{}", self.kind(), room.number),
        }
    }

    /// The scene under this seed.
    pub(super) fn simulate(&self, seed: u64) -> Result<ScenePair, ScenePairError> {
        match self {
            Self::Corridor(_, corridor) => corridor.simulate(seed),
            Self::Site(site, repeat) => site.simulate(*repeat, seed),
            Self::Room(room) => room.simulate(self.name(), seed),
        }
    }
}

/// The scenes of table1: `number` of each object and set, or of `only` one set.
pub(super) fn corridor_scenes(
    number: Option<usize>,
    only: Option<CorridorSetArg>,
    beams: BeamLayout,
) -> Vec<ScenePlan> {
    let number = number.unwrap_or(CorridorScene::SCENES_PER_CLASS);
    let sets = CorridorSetArg::value_variants().iter().copied();
    let sets = sets.filter(|set| only.is_none_or(|only| only == *set));
    let scenes = |set: CorridorSetArg| {
        let (noise, density) = set.noise_and_density();
        CorridorObject::ALL.into_iter().flat_map(move |object| {
            (0..number).map(move |number| {
                let corridor = CorridorScene {
                    object,
                    noise,
                    density,
                    beams,
                    number,
                };
                ScenePlan::Corridor(set, corridor)
            })
        })
    };
    sets.flat_map(scenes).collect()
}

/// The scenes of table2: `number` repeats at each site.
pub(super) fn site_scenes(number: Option<usize>) -> Vec<ScenePlan> {
    let number = number.unwrap_or(TestSite::REPEATS);
    let repeats = |site| (0..number).map(move |k| ScenePlan::Site(site, k));
    TestSite::ALL.into_iter().flat_map(repeats).collect()
}

/// The scenes of the furnished room: `number` of each class.
pub(super) fn room_scenes(number: Option<usize>) -> Vec<ScenePlan> {
    let number = number.unwrap_or(CorridorScene::SCENES_PER_CLASS);
    let rooms =
        |class| (0..number).map(move |number| ScenePlan::Room(FurnishedRoom { class, number }));
    FurnishedRoom::CLASSES.into_iter().flat_map(rooms).collect()
}
