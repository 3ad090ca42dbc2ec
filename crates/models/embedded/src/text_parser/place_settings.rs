//! Place settings: a plate for each person, with cutlery at its sides and a glass behind it.

use super::counts::is_excluded;
use super::draft::{Draft, DraftRelation, Kind};
use super::grammar::ParsedText;
use super::phrase::Attributes;
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
    let has_group = |draft: &Draft, groups: &[&str]| {
        (0..draft.objects.len()).any(|object| groups.contains(&draft.category(object).group.as_str()))
    };
    if has_group(draft, &["dish"]) {
        return;
    }
    let glasses: Vec<usize> =
        (0..draft.objects.len()).filter(|&object| is_drunk_from(draft, object)).collect();
    let missing: Vec<(&str, RelationKind)> = PARTS
        .into_iter()
        .filter(|(part, side)| match side {
            RelationKind::Behind => glasses.is_empty(),
            _ => !has_group(draft, &["cutlery"]) && !excludes(draft, parsed, part),
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

/// Whether somebody at the table drinks from the object, and the text does not say where it is.
fn is_drunk_from(draft: &Draft, object: usize) -> bool {
    let name = draft.category(object).name.as_str();
    let is_glass = ["_glass", "mug", "cup", "goblet", "flute"].iter().any(|end| name.ends_with(end));
    is_glass && draft.objects[object].relations.is_empty()
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
