//! Place settings: a plate for each person, with cutlery at its sides and a glass behind it.

use super::counts::is_excluded;
use super::draft::{Draft, DraftRelation, Kind};
use super::grammar::ParsedText;
use super::phrase::Attributes;
use catalog::Category;
use scene::RelationKind;

/// Parts of a setting beside its plate, and their side as the person at the plate sees it.
const PARTS: [(&str, RelationKind); 3] = [
    ("fork", RelationKind::LeftOf),
    ("knife", RelationKind::RightOf),
    ("drinking_glass", RelationKind::Behind),
];

/// Adds a complete setting; returns its plate.
pub(super) fn new_setting(draft: &mut Draft) -> Option<usize> {
    let plate = add(draft, "plate")?;
    for (part, side) in PARTS {
        add_beside(draft, part, side, plate);
    }
    Some(plate)
}

/// Completes the settings of a table that is set for people, where the text names no plates and at most some of the
/// other parts ("set for four with wine glasses"). A glass or mug for each person belongs to the person's setting.
/// Nothing is added that the text excludes, or above `limit` objects.
pub(super) fn complete_settings(draft: &mut Draft, parsed: &ParsedText, limit: usize) {
    let Some(people) = parsed.people.filter(|_| parsed.is_set_for_people && !parsed.nothing_else) else {
        return;
    };
    let people = people as usize;
    let has = |draft: &Draft, of: fn(&Category) -> bool| {
        (0..draft.objects.len()).any(|object| of(draft.category(object)))
    };
    if has(draft, is_plate) {
        return;
    }
    let is_free_glass = |object: &usize| {
        is_drunk_from(draft.category(*object)) && draft.objects[*object].relations.is_empty()
    };
    let glasses: Vec<usize> = (0..draft.objects.len()).filter(is_free_glass).collect();
    let missing: Vec<(&str, RelationKind)> = PARTS
        .into_iter()
        .filter(|(part, side)| match side {
            RelationKind::Behind => glasses.is_empty(),
            _ => !has(draft, is_cutlery) && !excludes(draft, parsed, part),
        })
        .collect();
    if excludes(draft, parsed, "plate") || draft.objects.len() + people * (1 + missing.len()) > limit {
        return;
    }
    for person in 0..people {
        let Some(plate) = add(draft, "plate") else { return };
        for &(part, side) in &missing {
            add_beside(draft, part, side, plate);
        }
        if let (Some(&glass), true) = (glasses.get(person), glasses.len() == people) {
            draft.relate_as(glass, DraftRelation::of_setting(RelationKind::Behind, plate));
        }
    }
}

/// Gives the plates of a table, and the parts of their settings, the shape and size of the first of their category, as
/// of one set. Objects with sizes or colors of their own keep them.
pub(super) fn make_alike(draft: &mut Draft) {
    let is_of_setting = |object: usize| {
        let seated = |other: usize, to: usize| {
            draft.objects[other].relations.iter().any(|relation| relation.seated && relation.to == Some(to))
        };
        draft.objects[object].relations.iter().any(|relation| relation.seated)
            || (0..draft.objects.len()).any(|other| seated(other, object))
    };
    let is_plain = |object: usize| {
        let object = &draft.objects[object];
        let attributes = &object.attributes;
        object.shape_of.is_none()
            && attributes.measures.is_empty()
            && attributes.stretches.is_empty()
            && (attributes.scale - 1.0).abs() < 1e-9
    };
    let parts: Vec<usize> =
        (0..draft.objects.len()).filter(|&object| is_of_setting(object) && is_plain(object)).collect();
    let first_like = |object: usize| {
        let is_like = |other: &usize| {
            let (one, other) = (&draft.objects[object], &draft.objects[*other]);
            (&one.kind.category.name, one.color) == (&other.kind.category.name, other.color)
        };
        parts.iter().copied().find(is_like).filter(|first| *first != object)
    };
    let alike: Vec<(usize, usize)> =
        parts.iter().filter_map(|&object| Some((object, first_like(object)?))).collect();
    for (object, first) in alike {
        draft.objects[object].shape_of = Some(first);
        draft.objects[object].size_m = draft.objects[first].size_m;
    }
}

/// Whether each person at a table has one of the category.
pub(super) fn is_of_each_person(category: &Category) -> bool {
    let is_other = ["saucer", "bowl", "coaster"].contains(&category.name.as_str());
    is_plate(category) || is_cutlery(category) || is_drunk_from(category) || is_other
}

fn is_plate(category: &Category) -> bool {
    category.name.ends_with("plate")
}

/// Cutlery of a person, not for serving.
fn is_cutlery(category: &Category) -> bool {
    const NAMES: [&str; 4] = ["fork", "knife", "spoon", "chopsticks"];
    category.group == "cutlery"
        && NAMES.iter().any(|name| category.name.ends_with(name))
        && !category.name.contains("serving")
}

/// Whether people drink from it.
fn is_drunk_from(category: &Category) -> bool {
    const ENDINGS: [&str; 6] = ["_glass", "mug", "cup", "goblet", "flute", "snifter"];
    const OTHERS: [&str; 3] = ["egg_cup", "measuring_cup", "yogurt_cup"];
    category.group == "vessel"
        && ENDINGS.iter().any(|ending| category.name.ends_with(ending))
        && !OTHERS.contains(&category.name.as_str())
}

fn excludes(draft: &Draft, parsed: &ParsedText, part: &str) -> bool {
    draft.lexicon.index_of(part).is_none_or(|category| is_excluded(draft, parsed, category))
}

fn add(draft: &mut Draft, part: &str) -> Option<usize> {
    let category = &draft.lexicon.categories[draft.lexicon.index_of(part)?];
    Some(draft.add(Kind::of(category), category.label.clone(), Attributes::plain(), true))
}

fn add_beside(draft: &mut Draft, part: &str, side: RelationKind, plate: usize) {
    if let Some(object) = add(draft, part) {
        draft.relate_as(object, DraftRelation::of_setting(side, plate));
    }
}
