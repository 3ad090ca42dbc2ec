//! Draft objects requested by the text and the theme, before their sizes are final.

use glam::DVec3;

use super::lexicon::Lexicon;
use super::phrase::Attributes;
use catalog::Category;
use geometry::Rgb;
use runtime::seed::child_seed;
use scene::request::MAX_SEED;
use scene::{InstanceId, ObjectSpec, Relation, RelationKind};

/// A draft object.
#[derive(Clone, Debug)]
pub(super) struct DraftObject {
    pub id: InstanceId,
    /// Index into the catalog.
    pub category: usize,
    pub label: String,
    pub color: Option<Rgb>,
    pub material: Option<String>,
    pub attributes: Attributes,
    /// Zero until `sizing`.
    pub size_m: DVec3,
    pub requested: bool,
    /// Relations to other objects by index; `None` is the table.
    pub relations: Vec<(RelationKind, Option<usize>)>,
}

pub(super) struct Draft<'a, 'c> {
    pub lexicon: &'a Lexicon<'c>,
    pub family: &'a str,
    pub seed: u64,
    pub objects: Vec<DraftObject>,
    /// Indices of the objects of each mention.
    pub of_mention: Vec<Vec<usize>>,
}

impl<'a, 'c> Draft<'a, 'c> {
    pub fn new(lexicon: &'a Lexicon<'c>, family: &'a str, seed: u64) -> Self {
        Self { lexicon, family, seed, objects: Vec::new(), of_mention: Vec::new() }
    }

    pub fn category(&self, object: usize) -> &'c Category {
        &self.lexicon.categories[self.objects[object].category]
    }

    /// Adds an object with the next free number of its category.
    pub fn add(&mut self, category: usize, label: String, attributes: Attributes, requested: bool) -> usize {
        let name = &self.lexicon.categories[category].name;
        let number = 1 + self.objects.iter().filter(|object| object.category == category).count();
        self.objects.push(DraftObject {
            id: InstanceId::numbered(name, number),
            category,
            label,
            color: attributes.colors.first().copied().or(attributes.material_color),
            material: attributes.substance.clone(),
            attributes,
            size_m: DVec3::ZERO,
            requested,
            relations: Vec::new(),
        });
        self.objects.len() - 1
    }

    pub fn supporter(&self, object: usize) -> Option<usize> {
        self.objects[object].relations.iter().find(|(kind, _)| kind.is_support()).and_then(|(_, to)| *to)
    }

    /// Whether `object` rests on `base`, directly or indirectly.
    pub fn rests_on(&self, object: usize, base: usize) -> bool {
        let mut at = Some(object);
        // The number of objects bounds the depth of the support tree.
        for _ in 0..=self.objects.len() {
            match at {
                Some(here) if here == base => return true,
                Some(here) => at = self.supporter(here),
                None => return false,
            }
        }
        true
    }

    /// Adds a relation; a second support, a cycle and a repetition are ignored.
    pub fn relate(&mut self, from: usize, kind: RelationKind, to: Option<usize>) {
        if to == Some(from) || self.objects[from].relations.contains(&(kind, to)) {
            return;
        }
        if kind.is_support() {
            let circle = to.is_some_and(|to| self.rests_on(to, from));
            if circle || self.supporter(from).is_some() {
                return;
            }
        }
        self.objects[from].relations.push((kind, to));
    }

    pub fn into_objects(self) -> Vec<ObjectSpec> {
        let ids: Vec<InstanceId> = self.objects.iter().map(|object| object.id.clone()).collect();
        self.objects
            .into_iter()
            .map(|object| ObjectSpec {
                seed: child_seed(self.seed, object.id.as_str()) & MAX_SEED,
                category: self.lexicon.categories[object.category].name.clone(),
                id: object.id,
                label: object.label,
                size_m: object.size_m,
                color: object.color,
                material: object.material,
                requested: object.requested,
                stand_in: false,
                pose: scene::RequestedPose::Upright,
                yaw_rad: None,
                position_m: None,
                state: None,
                mass_kg: None,
                relations: object
                    .relations
                    .into_iter()
                    .map(|(kind, to)| Relation::new(kind, to.map(|to| ids[to].clone())))
                    .collect(),
            })
            .collect()
    }
}
