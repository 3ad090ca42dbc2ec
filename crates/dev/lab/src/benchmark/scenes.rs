//! Scenes of the layout benchmark: 78 sentences with fixed seeds, in the proportions of the paper's test set (Sec.
//! Experiments): 31 office and living room, 21 dining and kitchen, 14 workbench, 12 crafting; 66 rectangular
//! tables, 8 round or oval, 4 triangular or irregular.
//!
//! A sentence names a theme and a table; the analyst completes it with objects of the theme, so the objects of a
//! scene follow from sentence and seed. Published scenes never change: a new set is a new list.

use serde::{Deserialize, Serialize};

use scene::TableShape;
use scene::request::RequestOptions;

/// Maximum object counts, used in turn: the analyst completes a theme with 8 to 15 objects unless that is too many.
const MAX_OBJECTS: [u32; 10] = [15, 15, 7, 15, 12, 15, 6, 15, 15, 10];

/// Seed of the first scene; the seeds increase by one per scene.
const FIRST_SEED: u64 = 7_000;

/// The four families of the paper's test set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    OfficeLiving,
    DiningKitchen,
    WorkbenchUtility,
    CraftingHobby,
}

/// The three kinds of table outline the paper counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outline {
    /// Rectangular or square.
    Rectangular,
    RoundOrOval,
    TriangularOrIrregular,
}

/// One scene of the benchmark.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BenchmarkScene {
    /// `office_living_03`, unique.
    pub name: String,
    pub family: Family,
    pub outline: Outline,
    /// Text given to the analyst.
    pub text: &'static str,
    pub seed: u64,
    /// Maximum number of objects.
    pub max_objects: u32,
}

/// Sentences of a family, each with its table outline and number of seeds.
type Sentences = &'static [(&'static str, Outline, u32)];

const SET: [(Family, Sentences); 4] = [
    (
        Family::OfficeLiving,
        &[
            ("A rectangular office desk", Outline::Rectangular, 4),
            ("A rectangular computer desk", Outline::Rectangular, 4),
            ("A rectangular home office desk", Outline::Rectangular, 4),
            ("A rectangular coffee table in a living room", Outline::Rectangular, 5),
            ("A round coffee table in a living room", Outline::RoundOrOval, 2),
            ("An oval coffee table in a cozy living room", Outline::RoundOrOval, 2),
            ("A kidney-shaped coffee table in a lounge", Outline::TriangularOrIrregular, 1),
            ("A rectangular study desk", Outline::Rectangular, 5),
            ("A rectangular desk of a student at homework", Outline::Rectangular, 4),
        ],
    ),
    (
        Family::DiningKitchen,
        &[
            ("A rectangular dining table", Outline::Rectangular, 3),
            ("Lunch on a rectangular dining table", Outline::Rectangular, 3),
            ("An oval dining table", Outline::RoundOrOval, 1),
            ("A round dining table", Outline::RoundOrOval, 1),
            ("Breakfast on a rectangular table", Outline::Rectangular, 4),
            ("Breakfast on a round table", Outline::RoundOrOval, 1),
            ("A rectangular kitchen table for meal prep", Outline::Rectangular, 5),
            ("Afternoon tea on a rectangular table", Outline::Rectangular, 2),
            ("Afternoon tea on an oval table", Outline::RoundOrOval, 1),
        ],
    ),
    (
        Family::WorkbenchUtility,
        &[
            ("A carpenter's rectangular workbench", Outline::Rectangular, 5),
            ("A rectangular electronics repair bench", Outline::Rectangular, 5),
            ("A rectangular workbench for bicycle repair", Outline::Rectangular, 4),
        ],
    ),
    (
        Family::CraftingHobby,
        &[
            ("A rectangular art table for painting", Outline::Rectangular, 3),
            ("A rectangular hobby desk for model making", Outline::Rectangular, 3),
            ("A kidney-shaped hobby table", Outline::TriangularOrIrregular, 1),
            ("A rectangular sewing table", Outline::Rectangular, 2),
            ("A triangular sewing table", Outline::TriangularOrIrregular, 2),
            ("A rectangular crafting table", Outline::Rectangular, 1),
        ],
    ),
];

/// The 78 scenes, families one after the other.
pub fn scenes() -> Vec<BenchmarkScene> {
    let mut scenes: Vec<BenchmarkScene> = Vec::new();
    for (family, sentences) in SET {
        let instances =
            sentences.iter().flat_map(|&(text, outline, seeds)| (0..seeds).map(move |_| (text, outline)));
        for (number, (text, outline)) in instances.enumerate() {
            let name = format!("{}_{:02}", family.name(), number + 1);
            let seed = FIRST_SEED + scenes.len() as u64;
            let max_objects = MAX_OBJECTS[scenes.len() % MAX_OBJECTS.len()];
            scenes.push(BenchmarkScene { name, family, outline, text, seed, max_objects });
        }
    }
    scenes
}

/// Evenly spaced `count` of `all`, so that a short run covers every family.
pub fn spread(all: Vec<BenchmarkScene>, count: usize) -> Vec<BenchmarkScene> {
    let (total, count) = (all.len(), count.min(all.len()));
    let chosen: Vec<usize> = (0..count).map(|k| (2 * k + 1) * total / (2 * count)).collect();
    all.into_iter().enumerate().filter(|(k, _)| chosen.contains(k)).map(|(_, scene)| scene).collect()
}

impl BenchmarkScene {
    /// Request options of the scene.
    pub fn options(&self) -> RequestOptions {
        RequestOptions { max_objects: Some(self.max_objects), ..RequestOptions::default() }
    }
}

impl Family {
    pub const ALL: [Self; 4] =
        [Self::OfficeLiving, Self::DiningKitchen, Self::WorkbenchUtility, Self::CraftingHobby];

    /// Name in scene descriptions.
    pub fn name(self) -> &'static str {
        match self {
            Self::OfficeLiving => "office_living",
            Self::DiningKitchen => "dining_kitchen",
            Self::WorkbenchUtility => "workbench_utility",
            Self::CraftingHobby => "crafting_hobby",
        }
    }
}

impl Outline {
    /// The paper's kind of a table shape.
    pub fn of(shape: TableShape) -> Self {
        match shape {
            TableShape::Rectangular | TableShape::Square => Self::Rectangular,
            TableShape::Round | TableShape::Oval => Self::RoundOrOval,
            TableShape::Triangular | TableShape::Irregular => Self::TriangularOrIrregular,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use embedded::text_parser::{DescribeOptions, describe};
    use tabletopgen::config::layers::{Sources, load};

    #[test]
    fn scenes_have_proportions_of_paper() {
        let all = scenes();
        let of = |family| all.iter().filter(|scene| scene.family == family).count();
        assert_eq!(Family::ALL.map(of), [31, 21, 14, 12]);
        let on = |outline| all.iter().filter(|scene| scene.outline == outline).count();
        let outlines = [Outline::Rectangular, Outline::RoundOrOval, Outline::TriangularOrIrregular];
        assert_eq!(outlines.map(on), [66, 8, 4]);
        let distinct: BTreeSet<_> = all.iter().map(|scene| (&scene.name, scene.seed)).collect();
        assert_eq!(distinct.len(), 78);
    }

    #[test]
    fn sentences_parse_to_their_family_and_outline() {
        let sources = Sources { file: None, environment: Vec::new(), arguments: Vec::new() };
        let settings = load(sources).expect("the defaults load").config.analyst;
        for scene in scenes() {
            let options = DescribeOptions {
                max_objects: scene.max_objects as usize,
                table: None,
                on_unknown: Default::default(),
            };
            let description = describe(scene.text, scene.seed, &options, &settings).expect("is understood");
            let name = &scene.name;
            assert_eq!(description.family, scene.family.name(), "{name}");
            assert_eq!(description.table.shape.map(Outline::of), Some(scene.outline), "{name}");
            assert!((6..=15).contains(&description.objects.len()), "{name}: {}", description.objects.len());
        }
    }

    #[test]
    fn spread_covers_every_family() {
        let few = spread(scenes(), 8);
        assert_eq!(few.len(), 8);
        assert!(Family::ALL.iter().all(|family| few.iter().any(|scene| scene.family == *family)));
        assert_eq!(spread(scenes(), 100).len(), 78);
    }
}
