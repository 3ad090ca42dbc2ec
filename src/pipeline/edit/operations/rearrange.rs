//! New places for everything on the table, within what a text states.

use std::f64::consts::PI;

use glam::DVec2;

use super::{Done, ids, unit};
use crate::pipeline::edit::draft::Draft;
use crate::pipeline::edit::error::EditError;
use editing::PlaceQuery;
use editing::workspace::Workspace;
use geometry::pose::wrap_angle_rad;
use runtime::seed::child_seed;
use scene::text_account::{TextMeaning, Understood};
use scene::{InstanceId, RelationKind, Supporter};

/// Layouts that are tried.
const LAYOUTS: usize = 8;

/// Places that are drawn for one object of a layout.
const DRAWS: usize = 6;

/// An object that has a front turns by up to this.
const TURN_RAD: f64 = 0.5;

/// A stated relation that holds before the objects move.
struct MetDemand {
    object: usize,
    query: PlaceQuery,
}

impl MetDemand {
    /// The objects that it is relative to.
    fn targets(&self) -> impl Iterator<Item = usize> {
        self.query.target.into_iter().chain(self.query.second_target)
    }
}

/// Demands of a text on a layout.
#[derive(Default)]
struct Demands {
    met: Vec<MetDemand>,
    /// Objects that stay where they are: those of arrangements, and those with a stated distance or position.
    fixed: Vec<usize>,
}

pub(super) fn rearrange(draft: &mut Draft, seed: u64) -> Done {
    let demands = demands(draft);
    let mut movable: Vec<usize> = (0..draft.len())
        .filter(|object| draft.supporter(*object) == Supporter::TABLE && !demands.fixed.contains(object))
        .collect();
    if movable.is_empty() {
        return Err(EditError::EverythingFixed);
    }
    in_order(&mut movable, draft, &demands);
    let mut layout = 0;
    loop {
        let mut tried = draft.clone();
        let layout_seed = child_seed(seed, &format!("layout {layout}"));
        let Err(why) = laid_out(&mut tried, &movable, &demands, layout_seed) else {
            *draft = tried;
            return Ok((ids(draft, &movable), format!("gave {} objects new places", movable.len())));
        };
        draft.cancel.check()?;
        layout += 1;
        if layout == LAYOUTS {
            return Err(EditError::NoLayout { layouts: LAYOUTS, last: Box::new(why) });
        }
    }
}

/// The demands of the text that the objects meet now.
fn demands(draft: &Draft) -> Demands {
    let mut demands = Demands::default();
    let index = |id: &InstanceId| (0..draft.len()).find(|object| draft.id(*object) == *id);
    let all = |ids: &[InstanceId]| ids.iter().filter_map(index).collect::<Vec<usize>>();
    for understood in draft.composition.account.iter().flat_map(|account| &account.understood) {
        match &understood.meaning {
            TextMeaning::Relation { relation, objects, targets } if !relation.is_support() => {
                let (objects, targets) = (all(objects), all(targets));
                match query_of(understood, *relation, &targets) {
                    Some(query) => {
                        let met = objects.iter().filter(|object| draft.workspace.meets(**object, &query));
                        demands.met.extend(met.map(|&object| MetDemand { object, query: query.clone() }));
                    }
                    None => demands.fixed.extend(objects.into_iter().chain(targets)),
                }
            }
            TextMeaning::Arrangement { objects, .. } => demands.fixed.extend(all(objects)),
            TextMeaning::Property { property, objects, .. }
                if !["color", "material", "size", "volume", "mass", "state"].contains(&property.as_str()) =>
            {
                demands.fixed.extend(all(objects));
            }
            _ => {}
        }
    }
    // The supporter of what stays does not move either.
    let below: Vec<usize> = demands.fixed.iter().map(|object| root(&draft.workspace, *object)).collect();
    demands.fixed.extend(below);
    demands
}

/// The relation as a query; `None` for one that new places would have to keep to the millimeter or to the degree.
fn query_of(understood: &Understood, relation: RelationKind, targets: &[usize]) -> Option<PlaceQuery> {
    use RelationKind::{
        Around, Facing, FromBackEdge, FromFrontEdge, FromLeftEdge, FromRightEdge, ParallelTo,
    };
    let is_exact = matches!(
        relation,
        Around | Facing | ParallelTo | FromLeftEdge | FromRightEdge | FromFrontEdge | FromBackEdge
    );
    if is_exact || states_distance(&understood.span.text) {
        return None;
    }
    let (target, second_target) = match (relation, targets) {
        (RelationKind::Between, &[first, second]) => (Some(first), Some(second)),
        (RelationKind::Between, _) => return None,
        (_, []) if !relation.target_is_object() => (None, None),
        (_, &[target]) => (Some(target), None),
        _ => return None,
    };
    Some(PlaceQuery { relation: Some(relation), target, second_target, ..PlaceQuery::default() })
}

/// Whether words name a length: a digit or a unit is among them. The account of a text has no distances.
fn states_distance(text: &str) -> bool {
    let is_unit = |word: &str| {
        ["cm", "mm", "m", "inch", "inches"].contains(&word)
            || word.contains("meter")
            || word.contains("metre")
    };
    let text = text.to_ascii_lowercase();
    text.chars().any(|c| c.is_ascii_digit()) || text.split(|c: char| !c.is_ascii_alphabetic()).any(is_unit)
}

/// Object on the table that carries an object directly or indirectly, perhaps itself.
fn root(workspace: &Workspace, mut object: usize) -> usize {
    while let Some(parent) = workspace.objects[object].supporter.parent {
        object = parent;
    }
    object
}

/// Sorts the objects: those that others are relative to come first, and of the rest the largest.
fn in_order(movable: &mut Vec<usize>, draft: &Draft, demands: &Demands) {
    let area_m2 = |object: usize| {
        let (low, high) = draft.workspace.objects[object].footprint().bounds();
        (high - low).element_product()
    };
    movable.sort_by(|a, b| area_m2(*b).total_cmp(&area_m2(*a)));
    let mut left = std::mem::take(movable);
    while !left.is_empty() {
        let waits = |object: usize| {
            let own = demands.met.iter().filter(|met| root(&draft.workspace, met.object) == object);
            own.flat_map(MetDemand::targets).any(|target| {
                let target = root(&draft.workspace, target);
                target != object && left.contains(&target)
            })
        };
        // A cycle of relations starts anywhere.
        let next = left.iter().position(|object| !waits(*object)).unwrap_or(0);
        movable.push(left.remove(next));
    }
}

/// Puts every object at a place that the seed draws.
fn laid_out(draft: &mut Draft, movable: &[usize], demands: &Demands, seed: u64) -> Result<(), EditError> {
    for &object in movable {
        draft.is_named(object);
        let branch = draft.workspace.branch(object);
        draft.may_move(&branch, &format!("it moves with {}", draft.name(object)));
        for member in branch {
            draft.workspace.objects[member].is_placed = false;
        }
    }
    for &object in movable {
        for member in draft.workspace.branch(object) {
            draft.workspace.objects[member].is_placed = true;
        }
        put_somewhere(draft, object, demands, child_seed(seed, draft.name(object)))?;
    }
    Ok(())
}

fn put_somewhere(draft: &mut Draft, object: usize, demands: &Demands, seed: u64) -> Result<(), EditError> {
    let (low, high) = draft.workspace.outline.bounds();
    let order = draft.composition.yaws[object].symmetry_order;
    let turn_rad = if order == 1 { TURN_RAD } else { PI };
    let yaw_rad = draft.pose(object).yaw_rad().unwrap_or(0.0);
    let own = demands.met.iter().find(|met| met.object == object);
    let name = draft.name(object).to_owned();
    let mut why = EditError::BreaksText { object: name.clone() };
    for draw in 0..DRAWS {
        let share = |axis: &str| unit(child_seed(seed, &format!("{axis} {draw}")));
        let query = PlaceQuery {
            near_m: Some(low + DVec2::new(share("x"), share("y")) * (high - low)),
            usual_yaw_rad: wrap_angle_rad(yaw_rad + turn_rad * (2.0 * share("yaw") - 1.0)),
            by_nearness: true,
            ..own.map(|met| met.query.clone()).unwrap_or_default()
        };
        let candidates = match draft.workspace.places(object, &query) {
            Ok(candidates) => candidates,
            Err(error) => {
                why = error.into();
                continue;
            }
        };
        for candidate in &candidates {
            draft.cancel.check()?;
            let mut tried = draft.workspace.clone();
            match tried.put_down(object, candidate, draft.rest, &draft.cancel) {
                Ok(()) if keeps(&tried, object, demands) => {
                    draft.workspace = tried;
                    return Ok(());
                }
                Ok(()) => why = EditError::BreaksText { object: name.clone() },
                Err(fault) => why = EditError::LeavesDrawnPlace { object: name.clone(), fault },
            }
        }
    }
    Err(why)
}

/// Whether every demand between an object, with what it carries, and others that are placed holds.
fn keeps(workspace: &Workspace, object: usize, demands: &Demands) -> bool {
    let branch = workspace.branch(object);
    let is_placed = |index: usize| workspace.objects[index].is_placed;
    demands
        .met
        .iter()
        .filter(|met| branch.contains(&met.object) || met.targets().any(|target| branch.contains(&target)))
        .filter(|met| is_placed(met.object) && met.targets().all(is_placed))
        .all(|met| workspace.meets(met.object, &met.query))
}
