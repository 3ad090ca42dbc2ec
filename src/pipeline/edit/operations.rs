//! The operations: each changes a draft, or says why it cannot.

mod appearance;
mod environment;
mod exchange;
mod line_up;
pub(super) mod pairing;
mod rearrange;
mod shape;

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

pub(super) use appearance::{color_named, material_named};
use appearance::{recolor, relabel, restyle_table};
use environment::{move_camera, relight};
use exchange::swap;
use line_up::arrange;
use pairing::{places_of_each, places_of_new};
use rearrange::rearrange;
use shape::{resize, rotate, set_physics};

use super::additions::NewObject;
use super::draft::Draft;
use super::error::EditError;
use crate::pipeline::resolve::Loaded;
use editing::PlaceQuery;
use editing::place::nearest_right_angle_rad;
use editing::references::{self, ReferenceError};
use geometry::pose::wrap_angle_rad;
use runtime::seed::child_seed;
use scene::edit::OperationResult;
use scene::predicates::POSITION_TOLERANCE_M;
use scene::{EditOperation, EditPlace, InstanceId, RelationKind, SupportRelation, Supporter};

/// Tidied objects are this far apart, seen from above, meters.
const TIDY_GAP_M: f64 = 0.008;

/// Inputs of an operation besides the draft.
pub(super) struct OperationInputs<'a> {
    /// Made for this operation, with their geometry.
    pub additions: Vec<(&'a NewObject, Loaded)>,
    /// The table that a change of its appearance needs.
    pub table: Option<NewTable>,
    pub seed: u64,
}

/// A table with another appearance.
pub(super) struct NewTable {
    pub loaded: Loaded,
    pub material: Option<String>,
    pub color: Option<geometry::Rgb>,
}

/// Carries one operation out.
///
/// # Errors
///
/// [`EditError`], the reason why it is refused.
pub(super) fn carry_out(
    draft: &mut Draft,
    operation: &EditOperation,
    given: OperationInputs,
) -> Result<OperationResult, EditError> {
    let (objects, sentence) = match operation {
        EditOperation::Add { place, .. } => add(draft, place.as_ref(), given)?,
        EditOperation::Clutter { .. } => clutter(draft, given)?,
        EditOperation::Remove { target, with_contents } => remove(draft, target, *with_contents)?,
        EditOperation::Replace { target, .. } => replace(draft, target, given)?,
        EditOperation::Move { target, place } => move_to(draft, target, place)?,
        EditOperation::Rotate { target, by_rad, to_rad, facing } => {
            rotate(draft, target, *by_rad, *to_rad, facing.as_deref())?
        }
        EditOperation::Resize { target, factor } => resize(draft, target, *factor)?,
        EditOperation::Recolor { target, color, material } => {
            recolor(draft, target, color.as_deref(), material.as_deref())?
        }
        EditOperation::Relabel { target, label } => relabel(draft, target, label)?,
        EditOperation::RestyleTable { .. } => restyle_table(draft, given)?,
        EditOperation::Stack { targets } => stack(draft, targets)?,
        EditOperation::Swap { targets } => swap(draft, targets)?,
        EditOperation::Arrange { targets, arrangement, sort_by, place } => {
            arrange(draft, targets, *arrangement, *sort_by, place.as_ref())?
        }
        EditOperation::Tidy => tidy(draft)?,
        EditOperation::Remake { target } => remake(draft, target, given)?,
        EditOperation::Rearrange => rearrange(draft, given.seed)?,
        EditOperation::SetPhysics { target, mass_factor, friction_factor } => {
            set_physics(draft, target, *mass_factor, *friction_factor)?
        }
        EditOperation::Relight(light) => relight(draft, *light)?,
        EditOperation::MoveCamera(change) => move_camera(draft, change)?,
    };
    draft.note_result(&objects);
    Ok(OperationResult { op: operation.name().to_owned(), objects, sentence, words: None })
}

type Done = Result<(Vec<InstanceId>, String), EditError>;

fn one(draft: &Draft, phrase: &str) -> Result<usize, EditError> {
    if is_table(phrase) {
        return Err(EditError::FixedTable);
    }
    match several(draft, phrase)?[..] {
        [object] => Ok(object),
        ref candidates => Err(ReferenceError::Ambiguous {
            phrase: phrase.trim().to_owned(),
            candidates: ids(draft, candidates),
        }
        .into()),
    }
}

fn several(draft: &Draft, phrase: &str) -> Result<Vec<usize>, EditError> {
    if is_table(phrase) {
        return Err(EditError::TableIsNoObject);
    }
    // The objects of the operation before.
    if matches!(phrase.trim(), "it" | "them") && !draft.last_result().is_empty() {
        return Ok(draft.last_result());
    }
    Ok(references::resolve_newest(&draft.editable(), phrase, &draft.newest())?)
}

/// The objects of several phrases, each once, in their order.
fn all_of(draft: &Draft, phrases: &[String]) -> Result<Vec<usize>, EditError> {
    let mut all = Vec::new();
    for phrase in phrases {
        for object in several(draft, phrase)? {
            if !all.contains(&object) {
                all.push(object);
            }
        }
    }
    Ok(all)
}

fn is_table(phrase: &str) -> bool {
    let phrase = phrase.trim().to_ascii_lowercase();
    let bare = phrase.strip_prefix("the ").unwrap_or(&phrase);
    matches!(bare, "table" | "desk" | "tabletop" | "table top" | "workbench" | "bench" | "counter")
}

fn names(draft: &Draft, objects: &[usize]) -> String {
    let names: Vec<&str> = objects.iter().map(|object| draft.name(*object)).collect();
    names.join(", ")
}

/// The place that an operation states, for an object.
fn query(draft: &Draft, object: usize, place: &EditPlace) -> Result<PlaceQuery, EditError> {
    let target = match place.target.as_deref() {
        None => None,
        Some(phrase) if is_table(phrase) => match place.relation {
            Some(RelationKind::On) => None,
            _ => return Err(EditError::RelativeToTable),
        },
        Some(phrase) => Some(one(draft, phrase)?),
    };
    let second_target = place.second_target.as_deref().map(|phrase| one(draft, phrase)).transpose()?;
    let branch = draft.workspace.branch(object);
    for other in [target, second_target].into_iter().flatten() {
        if other == object {
            return Err(EditError::RelativeToItself { object: draft.name(object).to_owned() });
        }
        if branch.contains(&other) {
            let (object, carried) = (draft.name(object).to_owned(), draft.name(other).to_owned());
            return Err(EditError::RelativeToCarried { object, carried });
        }
    }
    let relation = match (place.relation, target) {
        (Some(RelationKind::On), None) => None,
        (relation, _) => relation,
    };
    Ok(PlaceQuery {
        relation,
        target,
        second_target,
        distance_m: place.distance_m,
        position_m: place.position_m,
        yaw_rad: place.yaw_rad,
        near_m: None,
        within_m: None,
        outline_gap_m: 0.0,
        usual_yaw_rad: draft.pose(object).yaw_rad().unwrap_or(0.0),
        by_nearness: false,
    })
}

fn put_all(draft: &mut Draft, given: OperationInputs) -> Result<Vec<usize>, EditError> {
    given.additions.into_iter().map(|(new, loaded)| draft.add(new, loaded)).collect()
}

fn ids(draft: &Draft, objects: &[usize]) -> Vec<InstanceId> {
    objects.iter().map(|object| draft.id(*object)).collect()
}

fn add(draft: &mut Draft, place: Option<&EditPlace>, given: OperationInputs) -> Done {
    // Before they are there, so that no new object is its own landmark.
    let places = place.map(|place| places_of_new(draft, place)).transpose()?.unwrap_or_default();
    let added = put_all(draft, given)?;
    if !places.is_empty() && !added.len().is_multiple_of(places.len()) {
        return Err(EditError::UnequalNumbers { objects: added.len(), landmarks: places.len() });
    }
    let mut where_ = Vec::new();
    for (index, &object) in added.iter().enumerate() {
        let query = match places.get(index * places.len() / added.len()) {
            Some(place) => query(draft, object, place)?,
            None => PlaceQuery::default(),
        };
        draft.find_and_rest(object, &query)?;
        note_place(&mut where_, draft.workspace.place_in_words(&query));
    }
    Ok((ids(draft, &added), format!("added {} {where_}", names(draft, &added), where_ = where_.join(", "))))
}

fn clutter(draft: &mut Draft, given: OperationInputs) -> Done {
    let seed = given.seed;
    let (low, high) = draft.workspace.outline.bounds();
    let added = put_all(draft, given)?;
    for &object in &added {
        let share = |axis: &str| unit(child_seed(seed, &format!("{axis} of {}", draft.name(object))));
        let at = DVec2::new(share("x"), share("y"));
        let query = PlaceQuery {
            near_m: Some(low + at * (high - low)),
            usual_yaw_rad: TAU * share("yaw"),
            ..PlaceQuery::default()
        };
        draft.find_and_rest(object, &query)?;
    }
    Ok((ids(draft, &added), format!("added {}", names(draft, &added))))
}

/// A number in 0..1 from the upper bits of a seed.
fn unit(seed: u64) -> f64 {
    (seed >> 11) as f64 / (1_u64 << 53) as f64
}

fn remove(draft: &mut Draft, phrase: &str, with_contents: bool) -> Done {
    let mut targets = several(draft, phrase)?;
    if with_contents {
        let all: Vec<usize> = targets.iter().flat_map(|target| draft.workspace.branch(*target)).collect();
        targets.extend(all);
    }
    targets.sort_unstable();
    targets.dedup();
    let (removed, words) = (ids(draft, &targets), names(draft, &targets));
    // From the top, so that what stands on another removed object does not fall first.
    let order = draft.workspace.supports();
    let mut left: Vec<InstanceId> = order
        .order()
        .iter()
        .rev()
        .filter(|object| targets.contains(object))
        .map(|object| draft.id(*object))
        .collect();
    for id in left.drain(..) {
        let Some(object) = (0..draft.len()).find(|object| draft.id(*object) == id) else { continue };
        let loose = draft.remove(object);
        let again: Vec<(usize, Supporter)> =
            loose.iter().map(|&object| (object, draft.supporter(object))).collect();
        draft.rest_again(&again, &format!("{id} was removed from below it"))?;
    }
    Ok((removed, format!("removed {words}")))
}

fn remake(draft: &mut Draft, phrase: &str, given: OperationInputs) -> Done {
    let target = one(draft, phrase)?;
    let (id, label) = (draft.id(target), draft.composition.recognition.objects[target].label.clone());
    replace(draft, id.as_str(), given)?;
    // The new object is the last one; it takes the name of the old one, so that a text's account still holds.
    let object = draft.len() - 1;
    draft.rename(object, &id, label);
    Ok((vec![id.clone()], format!("gave {id} another mesh of its kind")))
}

/// A new object for each that the phrase means.
fn replace(draft: &mut Draft, phrase: &str, given: OperationInputs) -> Done {
    if is_table(phrase) {
        return Err(EditError::FixedTable);
    }
    let targets = ids(draft, &several(draft, phrase)?);
    if targets.len() != given.additions.len() {
        return Err(EditError::NotOneNewObject);
    }
    let (mut made, mut sentences) = (Vec::new(), Vec::new());
    for (target, addition) in targets.iter().zip(given.additions) {
        let Some(index) = (0..draft.len()).find(|object| draft.id(*object) == *target) else { continue };
        let inputs = OperationInputs { additions: vec![addition], table: None, seed: given.seed };
        let (new, sentence) = replace_one(draft, index, inputs)?;
        made.extend(new);
        sentences.push(sentence);
    }
    Ok((made, sentences.join(", ")))
}

fn replace_one(draft: &mut Draft, target: usize, given: OperationInputs) -> Done {
    let (old_name, old_pose, supporter) =
        (draft.name(target).to_owned(), draft.pose(target), draft.supporter(target));
    let center_m = draft.center_m(target);
    let load: Vec<(InstanceId, SupportRelation)> = draft
        .load(target)
        .into_iter()
        .map(|object| (draft.id(object), draft.supporter(object).relation))
        .collect();
    // Until the new object stands, what rested on the old one is in nothing's way.
    for object in draft.workspace.branch(target) {
        draft.workspace.objects[object].is_placed = object == target;
    }
    let shift = |object: usize| object - usize::from(object > target);
    draft.remove(target);
    let supporter = Supporter { parent: supporter.parent.map(shift), relation: supporter.relation };
    let added = put_all(draft, given)?;
    let &[new] = added.as_slice() else { return Err(EditError::NotOneNewObject) };
    let relation = supporter.parent.map(|_| RelationKind::from(supporter.relation));
    let query = PlaceQuery {
        relation,
        target: supporter.parent,
        near_m: Some(center_m),
        usual_yaw_rad: old_pose.yaw_rad().unwrap_or(0.0),
        ..PlaceQuery::default()
    };
    draft.find_and_rest(new, &query)?;
    let again: Vec<(usize, Supporter)> = load
        .iter()
        .filter_map(|(id, relation)| {
            let object = (0..draft.len()).find(|object| draft.id(*object) == *id)?;
            Some((object, Supporter { parent: Some(new), relation: *relation }))
        })
        .collect();
    place_branches(draft, &again);
    draft.rest_again(&again, &format!("{old_name} was replaced below it"))?;
    Ok((ids(draft, &added), format!("replaced {old_name} by {}", draft.name(new))))
}

/// Objects and what rests on them are in the way again.
fn place_branches(draft: &mut Draft, objects: &[(usize, Supporter)]) {
    for &(object, _) in objects {
        for member in draft.workspace.branch(object) {
            draft.workspace.objects[member].is_placed = true;
        }
    }
}

fn move_to(draft: &mut Draft, phrase: &str, place: &EditPlace) -> Done {
    let targets = several(draft, phrase)?;
    let mut where_ = Vec::new();
    for (&target, place) in targets.iter().zip(&places_of_each(draft, &targets, place)?) {
        let query = query(draft, target, place)?;
        draft.is_named(target);
        let load = draft.workspace.branch(target);
        draft.may_move(&load, &format!("it moves with {}", draft.name(target)));
        if let Some(offset_m) = place.offset_m {
            let mut pose = draft.pose(target);
            pose.translation_m += offset_m.extend(0.0);
            let supporter = draft.supporter(target);
            let wanted_m = draft.center_m(target) + offset_m;
            if let Err(why) = draft.rest_at(target, pose, supporter) {
                let query =
                    PlaceQuery { near_m: Some(wanted_m), ..draft.near_by(target, POSITION_TOLERANCE_M) };
                draft.find_and_rest(target, &query).map_err(|_| why)?;
            }
            note_place(&mut where_, "by the stated distance".to_owned());
            continue;
        }
        draft.find_and_rest(target, &query)?;
        note_place(&mut where_, draft.workspace.place_in_words(&query));
    }
    Ok((
        ids(draft, &targets),
        format!("moved {} {where_}", names(draft, &targets), where_ = where_.join(", ")),
    ))
}

/// Adds a place in words, once.
fn note_place(places: &mut Vec<String>, place: String) {
    if !places.contains(&place) {
        places.push(place);
    }
}

fn stack(draft: &mut Draft, phrases: &[String]) -> Done {
    let mut targets = match phrases {
        [phrase] => {
            let mut targets = several(draft, phrase)?;
            let area_m2 = |object: &usize| {
                let (low, high) = draft.workspace.objects[*object].footprint().bounds();
                (high - low).element_product()
            };
            targets.sort_by(|a, b| area_m2(b).total_cmp(&area_m2(a)));
            targets
        }
        phrases => phrases.iter().map(|phrase| one(draft, phrase)).collect::<Result<_, _>>()?,
    };
    let count = targets.len();
    targets.dedup();
    if targets.len() < 2 || targets.len() != count {
        return Err(EditError::TooFewToStack);
    }
    for pair in targets.windows(2) {
        let &[below, above] = pair else { continue };
        if draft.workspace.branch(above).contains(&below) {
            let (below, above) = (draft.name(below).to_owned(), draft.name(above).to_owned());
            return Err(EditError::StackedUpsideDown { below, above });
        }
        if draft.supporter(above) == Supporter::on(below) {
            continue;
        }
        draft.is_named(above);
        let load = draft.workspace.branch(above);
        draft.may_move(&load, &format!("it moves with {}", draft.name(above)));
        let query = PlaceQuery {
            relation: Some(RelationKind::On),
            target: Some(below),
            usual_yaw_rad: draft.pose(above).yaw_rad().unwrap_or(0.0),
            ..PlaceQuery::default()
        };
        draft.find_and_rest(above, &query)?;
    }
    Ok((ids(draft, &targets), format!("stacked {}, the first at the bottom", names(draft, &targets))))
}

fn tidy(draft: &mut Draft) -> Done {
    let mut targets: Vec<usize> =
        (0..draft.len()).filter(|object| draft.supporter(*object) == Supporter::TABLE).collect();
    let area_m2 = |object: &usize| {
        let (low, high) = draft.workspace.objects[*object].footprint().bounds();
        (high - low).element_product()
    };
    targets.sort_by(|a, b| area_m2(b).total_cmp(&area_m2(a)));
    let mut aligned = Vec::new();
    for &target in &targets {
        let Some(yaw_rad) = draft.pose(target).yaw_rad() else { continue };
        let nearest_rad = nearest_right_angle_rad(yaw_rad);
        let near_m = Some(draft.center_m(target));
        // A long object may fit along one side of the table only; one that fits along none stays as it is.
        let turns = [nearest_rad, nearest_rad + FRAC_PI_2];
        let is_aligned = turns.into_iter().any(|turn_rad| {
            let yaw_rad = Some(wrap_angle_rad(turn_rad));
            let outline_gap_m = TIDY_GAP_M;
            let query = PlaceQuery { yaw_rad, near_m, outline_gap_m, ..PlaceQuery::default() };
            draft.find_and_rest(target, &query).is_ok()
        });
        if is_aligned {
            draft.is_named(target);
            let load = draft.workspace.branch(target);
            draft.may_move(&load, &format!("it moves with {}", draft.name(target)));
            aligned.push(target);
        }
    }
    if aligned.is_empty() {
        return Err(EditError::NothingToAlign);
    }
    let targets = aligned;
    Ok((ids(draft, &targets), format!("aligned {}", names(draft, &targets))))
}
