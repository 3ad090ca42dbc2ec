//! Draft objects requested by the text and the theme, before their sizes are final.

use glam::{DVec2, DVec3};

use super::grammar::Mention;
use super::lexicon::Lexicon;
use super::phrase::Attributes;
use catalog::{Category, SizeRange};
use geometry::Rgb;
use runtime::seed::child_seed;
use scene::description::RequestedPose;
use scene::request::MAX_SEED;
use scene::{InstanceId, ObjectSpec, Relation, RelationKind, StandIn};

/// A relation to another object by index; `None` is the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DraftRelation {
    pub kind: RelationKind,
    pub to: Option<usize>,
    pub second: Option<usize>,
    pub distance_m: Option<f64>,
    /// As [`Relation::seated`].
    pub seated: bool,
}

impl DraftRelation {
    pub fn new(kind: RelationKind, to: Option<usize>) -> Self {
        Self { kind, to, second: None, distance_m: None, seated: false }
    }

    /// A relation to the plate of a person.
    pub fn of_setting(kind: RelationKind, plate: usize) -> Self {
        Self { seated: true, ..Self::new(kind, Some(plate)) }
    }
}

/// A category, or a stand-in for an object that the catalog does not have.
#[derive(Clone, Debug)]
pub(super) struct Kind<'c> {
    pub category: &'c Category,
    pub size: SizeRange,
    /// Noun of a stand-in, and its substance where the shape has no surface of its own.
    pub stand_in: Option<(String, Option<String>)>,
}

impl<'c> Kind<'c> {
    pub fn of(category: &'c Category) -> Self {
        Self { category, size: category.size, stand_in: None }
    }

    /// The kind as a stand-in for what the noun names.
    pub fn standing_in_for(self, noun: &str) -> Self {
        Self { stand_in: self.stand_in.or_else(|| Some((noun.to_owned(), None))), ..self }
    }

    /// The mark of its objects, where it is a stand-in.
    fn mark(&self) -> Option<StandIn> {
        let (noun, _) = self.stand_in.as_ref()?;
        Some(StandIn { stands_for: noun.clone(), shown_as: self.category.label.clone() })
    }

    /// First part of the ids of its objects.
    fn name(&self) -> String {
        match &self.stand_in {
            Some((noun, _)) => noun
                .chars()
                .filter(|c| c.is_ascii_alphanumeric() || *c == ' ')
                .map(|c| if c == ' ' { '_' } else { c })
                .take(40)
                .collect(),
            None => self.category.name.clone(),
        }
    }
}

/// A draft object.
#[derive(Clone, Debug)]
pub(super) struct DraftObject<'c> {
    pub id: InstanceId,
    pub kind: Kind<'c>,
    pub label: String,
    pub color: Option<Rgb>,
    pub material: Option<String>,
    pub attributes: Attributes,
    /// Zero until `sizing`.
    pub size_m: DVec3,
    pub requested: bool,
    pub pose: RequestedPose,
    pub yaw_rad: Option<f64>,
    pub position_m: Option<DVec2>,
    pub state: Option<String>,
    /// The object whose shape it has, of a set.
    pub shape_of: Option<usize>,
    pub relations: Vec<DraftRelation>,
}

impl DraftObject<'_> {
    pub fn has(&self, kind: RelationKind, to: Option<usize>) -> bool {
        self.relations.iter().any(|relation| relation.kind == kind && relation.to == to)
    }
}

pub(super) struct Draft<'a, 'c> {
    pub lexicon: &'a Lexicon<'c>,
    pub family: &'a str,
    pub seed: u64,
    pub objects: Vec<DraftObject<'c>>,
    /// Indices of the objects of each mention.
    pub of_mention: Vec<Vec<usize>>,
}

impl<'a, 'c> Draft<'a, 'c> {
    pub fn new(lexicon: &'a Lexicon<'c>, family: &'a str, seed: u64) -> Self {
        Self { lexicon, family, seed, objects: Vec::new(), of_mention: Vec::new() }
    }

    pub fn category(&self, object: usize) -> &'c Category {
        self.objects[object].kind.category
    }

    /// Adds an object with the next free number of its category.
    pub fn add(&mut self, kind: Kind<'c>, label: String, attributes: Attributes, requested: bool) -> usize {
        let name = kind.name();
        let mut number = 1 + self.objects.iter().filter(|object| object.kind.name() == name).count();
        let mut id = InstanceId::numbered(&name, number);
        // Different names may have the same form as an id.
        while self.objects.iter().any(|object| object.id == id) {
            number += 1;
            id = InstanceId::numbered(&name, number);
        }
        self.objects.push(DraftObject {
            id,
            kind,
            label,
            color: attributes.colors.first().copied().or(attributes.material_color),
            material: attributes.substance.clone(),
            attributes,
            size_m: DVec3::ZERO,
            requested,
            pose: RequestedPose::Upright,
            yaw_rad: None,
            position_m: None,
            state: None,
            shape_of: None,
            relations: Vec::new(),
        });
        self.objects.len() - 1
    }

    /// Adds an object of a mention, with its pose, state and position.
    pub fn add_of(
        &mut self,
        mention: &Mention,
        kind: Kind<'c>,
        label: String,
        attributes: Attributes,
    ) -> usize {
        let object = self.add(kind, label, attributes, true);
        let draft = &mut self.objects[object];
        draft.pose = mention.pose;
        draft.yaw_rad = mention.yaw_rad;
        draft.position_m = mention.position_m;
        draft.state = mention.state.clone();
        object
    }

    pub fn supporter(&self, object: usize) -> Option<usize> {
        self.objects[object].relations.iter().find(|relation| relation.kind.is_support()).and_then(|r| r.to)
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

    /// Removes an object and all relations to it.
    pub fn remove(&mut self, object: usize) {
        self.objects.remove(object);
        let moved = |index: usize| if index > object { index - 1 } else { index };
        for other in &mut self.objects {
            other.relations.retain(|relation| relation.to != Some(object) && relation.second != Some(object));
            for relation in &mut other.relations {
                relation.to = relation.to.map(moved);
                relation.second = relation.second.map(moved);
            }
            other.shape_of = other.shape_of.filter(|index| *index != object).map(moved);
        }
        for objects in &mut self.of_mention {
            objects.retain(|index| *index != object);
            objects.iter_mut().for_each(|index| *index = moved(*index));
        }
    }

    pub fn relate(&mut self, from: usize, kind: RelationKind, to: Option<usize>) {
        self.relate_as(from, DraftRelation::new(kind, to));
    }

    /// Adds a relation; a second support, a cycle and a repetition are ignored.
    pub fn relate_as(&mut self, from: usize, relation: DraftRelation) {
        let DraftRelation { kind, to, .. } = relation;
        if to == Some(from) || self.objects[from].has(kind, to) {
            return;
        }
        if kind.is_support() {
            let circle = to.is_some_and(|to| self.rests_on(to, from));
            if circle || self.supporter(from).is_some() {
                return;
            }
        }
        self.objects[from].relations.push(relation);
    }

    pub fn ids(&self) -> Vec<InstanceId> {
        self.objects.iter().map(|object| object.id.clone()).collect()
    }

    pub fn into_objects(self) -> Vec<ObjectSpec> {
        let ids = self.ids();
        let id = |index: Option<usize>| index.map(|index| ids[index].clone());
        self.objects
            .into_iter()
            .map(|object| ObjectSpec {
                seed: child_seed(self.seed, id(object.shape_of).as_ref().unwrap_or(&object.id).as_str())
                    & MAX_SEED,
                category: object.kind.category.name.clone(),
                id: object.id,
                label: object.label,
                size_m: object.size_m,
                color: object.color,
                material: object.material.or(object
                    .kind
                    .stand_in
                    .clone()
                    .and_then(|(_, substance)| substance)),
                requested: object.requested,
                stand_in: object.kind.mark(),
                pose: object.pose,
                yaw_rad: object.yaw_rad,
                position_m: object.position_m,
                state: object.state,
                mass_kg: object.attributes.mass_kg,
                relations: object
                    .relations
                    .into_iter()
                    .map(|relation| Relation {
                        kind: relation.kind,
                        target: id(relation.to),
                        second_target: id(relation.second),
                        distance_m: relation.distance_m,
                        seated: relation.seated,
                    })
                    .collect(),
            })
            .collect()
    }
}
