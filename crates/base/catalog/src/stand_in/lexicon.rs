//! The nouns of `config/catalog/stand_ins.tsv`, sorted for search.

use std::sync::LazyLock;

use glam::DVec3;

use super::rules::{Rule, rule};
use crate::{Recipe, SizeRange};
use geometry::Rgb;

/// Column of rows whose nouns share no specific meaning with a category.
const NO_CATEGORY: &str = "-";

/// Beginning of the first column of rows whose nouns cannot stand on a table.
const NOT_PLACEABLE: &str = "not:";

/// Rule of toys of large objects.
const TOY: &str = "toy";

/// Words that make a toy of what follows.
const MINIATURES: &[&str] = &["toy ", "model ", "miniature "];

/// Stand-in for the nouns of one row.
#[derive(Clone, Debug, PartialEq)]
pub struct StandIn {
    /// Form of its kind ("camera"): a hidden category of that name after `stand_in_` builds it.
    pub family: &'static str,
    /// Extents of small and large specimens, meters.
    pub size: SizeRange,
    /// Main substance, one of `config/materials.toml`.
    pub substance: &'static str,
    /// Name of the catalog's category with the nearest meaning.
    pub nearest: Option<&'static str>,
}

impl StandIn {
    /// Name of the hidden category that builds it ("stand_in_camera").
    pub fn category_name(&self) -> String {
        format!("stand_in_{}", self.family)
    }

    /// The center of the size range, meters.
    pub fn typical_size_m(&self) -> DVec3 {
        self.size.typical_m()
    }

    /// The recipe of the stand-in. What is `None` is usual: the typical size, a color of its family, the substance.
    pub fn recipe(
        &self,
        size_m: Option<DVec3>,
        color: Option<Rgb>,
        material: Option<String>,
        seed: u64,
    ) -> Recipe {
        Recipe {
            category: self.category_name(),
            size_m: size_m.unwrap_or_else(|| self.typical_size_m()),
            color,
            material: Some(material.unwrap_or_else(|| self.substance.to_owned())),
            seed,
        }
    }
}

/// Reason why something cannot stand on a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Obstacle {
    /// Larger than a table: vehicles, buildings, furniture, trees.
    TooLarge,
    /// Matter without a shape: liquids, powders, materials.
    Substance,
    /// A person, or a part of a body.
    Person,
    /// A place or a part of the landscape.
    Place,
    /// No physical object.
    Abstract,
}

impl Obstacle {
    /// Name of the reason in the configuration ("too_large").
    pub fn name(self) -> &'static str {
        match self {
            Self::TooLarge => "too_large",
            Self::Substance => "substance",
            Self::Person => "person",
            Self::Place => "place",
            Self::Abstract => "abstract",
        }
    }

    /// The obstacle as the end of a sentence ("A sofa ...").
    pub fn explanation(self) -> &'static str {
        match self {
            Self::TooLarge => "is too large for a table",
            Self::Substance => "is a substance without a shape; name a container of it",
            Self::Person => "is a person or a part of a body",
            Self::Place => "is a place",
            Self::Abstract => "is not a physical object",
        }
    }

    fn named(name: &str) -> Option<Self> {
        let all = [Self::TooLarge, Self::Substance, Self::Person, Self::Place, Self::Abstract];
        all.into_iter().find(|obstacle| obstacle.name() == name)
    }
}

/// Ability of an object of some name to stand on a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placeability {
    Placeable(&'static StandIn),
    NotPlaceable(Obstacle),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Meaning {
    /// Index into the stand-ins.
    StandIn(usize),
    NotPlaceable(Obstacle),
}

pub(super) struct Lexicon {
    stand_ins: Vec<StandIn>,
    /// Sorted by noun.
    meanings: Vec<(&'static str, Meaning)>,
    /// Index of the toy without a nearest category.
    toy: usize,
}

static LEXICON: LazyLock<Lexicon> = LazyLock::new(|| {
    Lexicon::read(include_str!("../../../../../config/catalog/stand_ins.tsv"))
        .expect("the built-in stand-ins are complete (a test loads them)")
});

pub(super) fn lexicon() -> &'static Lexicon {
    &LEXICON
}

impl Lexicon {
    /// `None` if a row lacks a column or names an unknown rule or reason.
    fn read(text: &'static str) -> Option<Self> {
        let mut stand_ins = vec![of_rule(rule(TOY)?, None)];
        let mut meanings = Vec::new();
        for row in text.lines().filter(|line| !line.starts_with('#')) {
            let [key, nearest, nouns] = row.split('\t').collect::<Vec<_>>().try_into().ok()?;
            let meaning = match key.strip_prefix(NOT_PLACEABLE) {
                Some(reason) => Meaning::NotPlaceable(Obstacle::named(reason)?),
                None => {
                    let nearest = (nearest != NO_CATEGORY).then_some(nearest);
                    let found = of_rule(rule(key)?, nearest);
                    // Long rows are split, so that a row often repeats the one before.
                    if stand_ins.last() != Some(&found) {
                        stand_ins.push(found);
                    }
                    Meaning::StandIn(stand_ins.len() - 1)
                }
            };
            meanings.extend(nouns.split(';').map(|noun| (noun, meaning)));
        }
        meanings.sort_unstable_by_key(|(noun, _)| *noun);
        Some(Self { stand_ins, meanings, toy: 0 })
    }

    pub fn placeability(&'static self, noun: &str) -> Option<Placeability> {
        let meaning = self.meaning(noun).or_else(|| self.miniature(noun))?;
        Some(match meaning {
            Meaning::StandIn(index) => Placeability::Placeable(&self.stand_ins[index]),
            Meaning::NotPlaceable(obstacle) => Placeability::NotPlaceable(obstacle),
        })
    }

    /// The noun as written, without hyphens, in one word ("cash box"), or as the plural of a pair ("tweezers").
    fn meaning(&self, noun: &str) -> Option<Meaning> {
        let spaced = noun.replace('-', " ");
        self.exact(&spaced)
            .or_else(|| self.exact(&spaced.replace(' ', "")))
            .or_else(|| self.exact(spaced.strip_suffix('s')?))
    }

    fn exact(&self, noun: &str) -> Option<Meaning> {
        let at = self.meanings.binary_search_by_key(&noun, |(known, _)| known).ok()?;
        Some(self.meanings[at].1)
    }

    /// "toy truck" is a toy; "toy bear" is the stand-in of a bear.
    fn miniature(&self, noun: &str) -> Option<Meaning> {
        let original = MINIATURES.iter().find_map(|word| noun.strip_prefix(word))?;
        match self.meaning(original)? {
            Meaning::NotPlaceable(Obstacle::TooLarge | Obstacle::Person) => Some(Meaning::StandIn(self.toy)),
            meaning => Some(meaning),
        }
    }

    /// Every noun with what it stands for.
    #[cfg(test)]
    pub fn all(&'static self) -> impl Iterator<Item = (&'static str, Option<&'static StandIn>)> {
        self.meanings.iter().map(|(noun, meaning)| match meaning {
            Meaning::StandIn(index) => (*noun, Some(&self.stand_ins[*index])),
            Meaning::NotPlaceable(_) => (*noun, None),
        })
    }
}

fn of_rule(rule: &'static Rule, nearest: Option<&'static str>) -> StandIn {
    StandIn {
        family: &rule.family,
        size: SizeRange { low_m: rule.low_m, high_m: rule.high_m },
        substance: &rule.substance,
        nearest,
    }
}
