//! Statements of a text about an image: the objects that a recognition should search for, and categories that are
//! absent.
//!
//! The text beside an image is described like a text alone ([`SceneAnalyst::describe`](crate::SceneAnalyst::describe)).
//! [`RecognitionHints::of`] keeps of the description what holds for an image: the objects that the text names, not
//! those that a theme adds, and not their places.
//!
//! Contract of adapters: a recognized object that is a named one has its id, and no other object has that id. Objects
//! that the image does not show are left out. [`RecognitionHints::apply`] then gives the named objects the text's
//! label, material and mass.

use std::collections::BTreeSet;

use glam::DVec3;
use serde::Serialize;

use geometry::Rgb;
use scene::instance::SupportRelation;
use scene::text_account::TextMeaning;
use scene::{InstanceId, ObjectSpec, Recognition, RelationKind, RequestedPose, SceneDescription, StandIn};

/// Maximum number of named objects.
const MAX_NAMED: usize = 64;

/// Longest label, characters.
const MAX_LABEL_CHARS: usize = 200;

/// The objects that a text names in an image, and the categories that it excludes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecognitionHints {
    named: Vec<NamedObject>,
    absent: Vec<String>,
}

/// An object that the text names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedObject {
    pub id: InstanceId,
    /// The words of the text ("red coffee mug").
    pub label: String,
    /// Catalog category, or the hidden category of a stand-in.
    pub category: String,
    /// The requested object that its category replaces, where the catalog does not have it.
    #[serde(flatten, serialize_with = "scene::stand_in::fields::serialize")]
    pub stand_in: Option<StandIn>,
    /// Upright extents, meters: stated, or one of many possible.
    pub size_m: DVec3,
    pub size_is_stated: bool,
    pub color: Option<Rgb>,
    pub material: Option<String>,
    pub mass_kg: Option<f64>,
    pub pose: RequestedPose,
    /// The named object on or in which it is.
    pub supporter: Option<(SupportRelation, InstanceId)>,
}

/// Reason why a description gives no hints.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidHints {
    #[error("the text names {count} objects; name at most {}", MAX_NAMED)]
    TooMany { count: usize },
    #[error("two objects of the description have the name {id}; an adapter must give each its own")]
    RepeatedId { id: InstanceId },
    #[error("the object {id} of the description has no size; an adapter must give three positive extents")]
    Size { id: InstanceId },
    #[error(
        "the object {id} of the description has a label of no or more than {} characters",
        MAX_LABEL_CHARS
    )]
    Label { id: InstanceId },
}

impl RecognitionHints {
    /// The hints of a described text.
    ///
    /// # Errors
    ///
    /// [`InvalidHints`] if there are too many objects, or if one has no name of its own, no size or no label.
    pub fn of(description: &SceneDescription) -> Result<Self, InvalidHints> {
        let requested: Vec<&ObjectSpec> =
            description.objects.iter().filter(|object| object.requested).collect();
        if requested.len() > MAX_NAMED {
            return Err(InvalidHints::TooMany { count: requested.len() });
        }
        let mut ids = BTreeSet::new();
        for object in &requested {
            let id = object.id.clone();
            if !ids.insert(&object.id) {
                return Err(InvalidHints::RepeatedId { id });
            }
            if !(object.size_m.is_finite() && object.size_m.min_element() > 0.0) {
                return Err(InvalidHints::Size { id });
            }
            if !(1..=MAX_LABEL_CHARS).contains(&object.label.chars().count()) {
                return Err(InvalidHints::Label { id });
            }
        }
        let named = requested.iter().map(|object| named(object, description, &ids)).collect();
        Ok(Self { named, absent: description.excluded_categories.clone() })
    }

    /// The named objects, in the order of the text.
    pub fn named(&self) -> &[NamedObject] {
        &self.named
    }

    /// Categories that the text says are absent.
    pub fn absent(&self) -> &[String] {
        &self.absent
    }

    pub fn find(&self, id: &InstanceId) -> Option<&NamedObject> {
        self.named.iter().find(|named| &named.id == id)
    }

    /// Gives the recognized objects that the text names its label, category, mark, material and mass. A stated size
    /// replaces a judged one; a measured size stays, as the adapter that measures takes the scale from stated sizes.
    pub fn apply(&self, recognition: &mut Recognition) {
        for object in &mut recognition.objects {
            let Some(named) = self.find(&object.id) else { continue };
            object.label.clone_from(&named.label);
            object.category.clone_from(&named.category);
            object.mass_kg = named.mass_kg;
            object.stand_in.clone_from(&named.stand_in);
            if named.material.is_some() {
                object.material.clone_from(&named.material);
            }
            if named.size_is_stated && object.seen_as.is_none() {
                object.size_m = named.size_m;
            }
        }
    }
}

fn named(object: &ObjectSpec, description: &SceneDescription, ids: &BTreeSet<&InstanceId>) -> NamedObject {
    let support = object.relations.iter().find(|relation| relation.kind.is_support());
    let supporter = support.and_then(|support| {
        let relation = match support.kind {
            RelationKind::In => SupportRelation::In,
            _ => SupportRelation::On,
        };
        support.target.clone().filter(|target| ids.contains(target)).map(|target| (relation, target))
    });
    NamedObject {
        id: object.id.clone(),
        label: object.label.clone(),
        category: object.category.clone(),
        stand_in: object.stand_in.clone(),
        size_m: object.size_m,
        size_is_stated: size_is_stated(object, description),
        color: object.color,
        material: object.material.clone(),
        mass_kg: object.mass_kg,
        pose: object.pose,
        supporter,
    }
}

/// Parts of units, for lengths whose number is a word ("ten centimeters").
const UNITS: [&str; 5] = ["meter", "metre", "inch", "foot", "feet"];

/// Whether the text gives a length of the object, not only a word such as "small".
fn size_is_stated(object: &ObjectSpec, description: &SceneDescription) -> bool {
    description.understood.iter().any(|part| match &part.meaning {
        TextMeaning::Property { property, value, objects } => {
            let is_length =
                value.chars().any(|c| c.is_ascii_digit()) || UNITS.iter().any(|unit| value.contains(unit));
            property == "size" && is_length && objects.contains(&object.id)
        }
        _ => false,
    })
}

#[cfg(test)]
mod tests;
