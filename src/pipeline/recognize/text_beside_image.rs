//! The account of a text beside an image: which of its parts had an effect on the recognition of the image.
//!
//! Objects keep their meaning as far as the image shows them; the others are reported. What the image decides
//! (the table, places, arrangements, the orientation) is reported too, except supports that the recognition has.

use ports::RecognitionHints;
use scene::text_account::{TextAccount, TextMeaning, Understood, Unrecognized, UnrecognizedReason};
use scene::{InstanceId, Recognition, RelationKind, SceneDescription, StandsOn};

/// Properties that the recognition takes from the text.
const APPLIED: [&str; 4] = ["color", "material", "size", "mass"];

/// The account of the description's text after the recognition of the image with its hints.
pub(super) fn account(
    description: &SceneDescription,
    hints: &RecognitionHints,
    recognition: &Recognition,
) -> TextAccount {
    let is_found = |id: &InstanceId| recognition.objects.iter().any(|object| &object.id == id);
    let mut account = description.account();
    account.fillings.clear();
    // Its predicates may be about objects that the image does not show.
    account.goal = account.goal.filter(|goal| {
        goal.predicates.iter().all(|predicate| {
            let others = predicate.target.iter().chain(&predicate.second_target);
            std::iter::once(&predicate.object).chain(others).all(is_found)
        })
    });
    account.stand_ins.retain(is_found);
    let has_goal = account.goal.is_some();
    for part in std::mem::take(&mut account.understood) {
        let (kept, reason) = judged(part.meaning, hints, recognition, has_goal, &is_found);
        if let Some(reason) = reason {
            let span = part.span.clone();
            account.unrecognized.push(Unrecognized {
                span,
                reason,
                nearest_by_spelling: None,
                nearest_by_meaning: None,
            });
        }
        account.understood.extend(kept.map(|meaning| Understood { span: part.span, meaning }));
    }
    account.unrecognized.sort_by_key(|part| (part.span.start, part.span.end));
    account.unrecognized.dedup();
    account
}

/// The meaning that had an effect, and why the rest of it had none.
fn judged(
    meaning: TextMeaning,
    hints: &RecognitionHints,
    recognition: &Recognition,
    has_goal: bool,
    is_found: &impl Fn(&InstanceId) -> bool,
) -> (Option<TextMeaning>, Option<UnrecognizedReason>) {
    let missing = Some(UnrecognizedReason::NotInImage);
    let by_image = (None, Some(UnrecognizedReason::ShownByImage));
    match meaning {
        TextMeaning::Object { category, objects } => {
            let named: Vec<InstanceId> = objects.into_iter().filter(|id| hints.find(id).is_some()).collect();
            let found: Vec<InstanceId> = named.iter().filter(|id| is_found(id)).cloned().collect();
            let reason = if found.len() < named.len() { missing } else { None };
            let kept = (!found.is_empty()).then_some(TextMeaning::Object { category, objects: found });
            (kept, reason)
        }
        TextMeaning::Property { property, value, objects } if APPLIED.contains(&property.as_str()) => {
            let found: Vec<InstanceId> = objects.into_iter().filter(is_found).collect();
            match found.is_empty() {
                true => (None, missing),
                false => (Some(TextMeaning::Property { property, value, objects: found }), None),
            }
        }
        TextMeaning::Relation { relation, objects, targets } => {
            let holds = |id: &InstanceId| {
                let object = recognition.objects.iter().find(|object| &object.id == id);
                object.is_some_and(|object| supports(relation, &object.stands_on, &targets))
            };
            match objects.iter().all(holds) {
                true => (Some(TextMeaning::Relation { relation, objects, targets }), None),
                false => by_image,
            }
        }
        TextMeaning::Goal { .. } if has_goal => (Some(meaning), None),
        TextMeaning::Goal { .. } => (None, missing),
        TextMeaning::Exclusion { .. } | TextMeaning::Correction { .. } => (Some(meaning), None),
        TextMeaning::Property { .. }
        | TextMeaning::Arrangement { .. }
        | TextMeaning::Table
        | TextMeaning::Theme { .. }
        | TextMeaning::Completion { .. } => by_image,
    }
}

/// Whether a recognized support is the stated one; without targets, the table.
fn supports(relation: RelationKind, stands_on: &StandsOn, targets: &[InstanceId]) -> bool {
    match (relation, stands_on) {
        (RelationKind::On | RelationKind::StackedOn, StandsOn::On(below)) => targets.contains(below),
        (RelationKind::In, StandsOn::In(below)) => targets.contains(below),
        (RelationKind::On, StandsOn::Table) => targets.is_empty(),
        _ => false,
    }
}

#[cfg(test)]
mod tests;
