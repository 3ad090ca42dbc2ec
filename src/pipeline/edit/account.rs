//! The account of the text of an edited scene.
//!
//! The text is that of the scene from which the edits started; its account keeps what still holds. After each
//! operation, every statement about an object that is gone or that it changed leaves `understood`, and `changed` says
//! which words and which operation. Relations are tested with the tolerances of [`scene::predicates`], positions with
//! theirs, orientations with 10 degrees. Objects that edits add are no part of the text. Costs a footprint per object
//! and operation.

use std::collections::{BTreeMap, BTreeSet};

use super::draft::Draft;
use super::variation::states_finish;
use geometry::{Outline, Pose};
use physics::settle::angle_between_rad;
use scene::edit::OperationResult;
use scene::predicates::{
    POSITION_TOLERANCE_M, PosedFootprint, PosedRelation, Unmet, UnmetDemand, YAW_TOLERANCE_RAD, holds,
};
use scene::text_account::{ChangedPart, TextAccount, TextSpan, Understood};
use scene::{EditOperation, InstanceId, RelationKind, TextMeaning};
use tasks::{TaskScene, evaluate};

/// Properties that another size changes.
const OF_SIZE: [&str; 3] = ["size", "volume", "mass"];
/// Properties that another mesh of the same kind keeps: it is made from them.
const OF_REMADE: [&str; 3] = ["color", "material", "kind"];

/// Objects and their poses before an operation.
pub(super) struct Before {
    poses: BTreeMap<InstanceId, Pose>,
}

impl Before {
    pub fn of(draft: &Draft) -> Self {
        Self { poses: (0..draft.len()).map(|object| (draft.id(object), draft.pose(object))).collect() }
    }
}

/// Objects after an operation.
struct After {
    now: BTreeMap<InstanceId, (Pose, PosedFootprint)>,
    categories: BTreeSet<String>,
    outline: Outline,
}

/// The account of the scene after an operation that was carried out.
pub(super) fn after(
    account: TextAccount,
    operation: &EditOperation,
    done: &OperationResult,
    before: &Before,
    draft: &Draft,
) -> TextAccount {
    let footprint = |object: usize| draft.workspace.objects[object].footprint();
    let now =
        (0..draft.len()).map(|object| (draft.id(object), (draft.pose(object), footprint(object)))).collect();
    let is_new = |object: &usize| !before.poses.contains_key(&draft.id(*object));
    let category = |object: usize| draft.composition.recognition.objects[object].category.clone();
    let categories = (0..draft.len()).filter(is_new).map(category).collect();
    let after = After { now, categories, outline: draft.workspace.outline.clone() };
    Step { operation, done, before, after }.applied(account)
}

/// The account without a goal that the scene satisfies: a scene shows the start of a task.
pub(super) fn without_reached_goal(mut account: TextAccount, scene: &TaskScene) -> TextAccount {
    let Some(goal) = &account.goal else { return account };
    let Ok(asked) = tasks::Goal::new(goal.predicates.iter().cloned()) else { return account };
    if evaluate(&asked, &scene.situation()).iter().all(|predicate| predicate.holds) {
        drop_goal(&mut account, "after the edit the goal is reached from the start");
    }
    account
}

fn drop_goal(account: &mut TextAccount, by: &str) {
    account.goal = None;
    let is_goal = |part: &Understood| matches!(part.meaning, TextMeaning::Goal { .. });
    let (of_goal, others) = std::mem::take(&mut account.understood).into_iter().partition(is_goal);
    account.understood = others;
    for part in of_goal {
        note(&mut account.changed, part.span, by);
    }
}

fn note(changed: &mut Vec<ChangedPart>, span: TextSpan, by: &str) {
    changed.push(ChangedPart { span, by: by.to_owned() });
    changed.sort_by_key(|part| (part.span.start, part.span.end));
    changed.dedup();
}

/// One operation and its effect.
struct Step<'a> {
    operation: &'a EditOperation,
    done: &'a OperationResult,
    before: &'a Before,
    after: After,
}

impl Step<'_> {
    fn applied(&self, mut account: TextAccount) -> TextAccount {
        let by = self.done.sentence.as_str();
        for part in std::mem::take(&mut account.understood) {
            let Understood { span, meaning } = part;
            let is_finish = matches!(meaning, TextMeaning::Table) && states_finish(&span.text);
            let kept = match self.operation {
                EditOperation::RestyleTable { .. } if is_finish => None,
                _ => self.kept(meaning.clone(), &account.unmet),
            };
            if kept.as_ref() != Some(&meaning) {
                note(&mut account.changed, span.clone(), by);
            }
            account.understood.extend(kept.map(|meaning| Understood { span, meaning }));
        }
        let is_gone = |id: &InstanceId| self.is_gone(id);
        let names_gone = account.goal.iter().flat_map(|goal| &goal.predicates).any(|predicate| {
            let others = predicate.target.iter().chain(&predicate.second_target);
            std::iter::once(&predicate.object).chain(others).any(is_gone)
        });
        if names_gone {
            drop_goal(&mut account, by);
        }
        account.stand_ins.retain(|id| !is_gone(id));
        account.fillings.retain(|id| !is_gone(id));
        account.unmet.retain(|unmet| !unmet.names().any(is_gone) && !self.is_met(unmet));
        account
    }

    fn is_gone(&self, id: &InstanceId) -> bool {
        !self.after.now.contains_key(id)
    }

    /// Whether the operation moved an object farther than a tolerance, or turned it.
    fn has_moved(&self, id: &InstanceId, farther_than_m: f64, more_than_rad: f64) -> bool {
        let poses = self.before.poses.get(id).zip(self.after.now.get(id));
        poses.is_none_or(|(before, (now, _))| {
            before.translation_m.distance(now.translation_m) > farther_than_m
                || angle_between_rad(before, now) > more_than_rad
        })
    }

    /// Whether the operation changed pose or shape of an object.
    fn is_touched(&self, id: &InstanceId) -> bool {
        let is_reshaped =
            matches!(self.operation, EditOperation::Resize { .. } | EditOperation::Remake { .. });
        is_reshaped && self.done.objects.contains(id) || self.has_moved(id, 0.0, 0.0)
    }

    /// Whether a relation that yielded in the layout holds after the operation.
    fn is_met(&self, unmet: &Unmet) -> bool {
        let UnmetDemand::Relation { relation, targets, distance_m: None } = &unmet.demand else {
            return false;
        };
        let met = |id: &InstanceId| self.is_touched(id) && self.holds(*relation, id, targets);
        !unmet.objects.is_empty() && unmet.objects.iter().all(met)
    }

    /// The part of a meaning that still holds. What yielded in the layout before is no change.
    fn kept(&self, meaning: TextMeaning, unmet: &[Unmet]) -> Option<TextMeaning> {
        let left = |objects: Vec<InstanceId>| -> Vec<InstanceId> {
            objects.into_iter().filter(|id| !self.is_gone(id)).collect()
        };
        let some = |objects: &[InstanceId]| !objects.is_empty();
        match meaning {
            TextMeaning::Object { category, objects } if some(&objects) => {
                let objects = left(objects);
                some(&objects).then_some(TextMeaning::Object { category, objects })
            }
            TextMeaning::Property { property, value, objects } if some(&objects) => {
                let objects = self.with_property(&property, &value, objects);
                some(&objects).then_some(TextMeaning::Property { property, value, objects })
            }
            TextMeaning::Relation { relation, objects, targets } if some(&objects) => {
                let yielded = |id: &InstanceId| {
                    let is_of = |unmet: &Unmet| match &unmet.demand {
                        UnmetDemand::Relation { relation: demanded, .. } => {
                            *demanded == relation && unmet.objects.contains(id)
                        }
                        _ => false,
                    };
                    unmet.iter().any(is_of)
                };
                let objects = self.related(relation, objects, &targets, yielded);
                some(&objects).then_some(TextMeaning::Relation { relation, objects, targets })
            }
            TextMeaning::Arrangement { index, objects } => {
                let is_broken = |id: &InstanceId| {
                    self.is_gone(id) || self.has_moved(id, POSITION_TOLERANCE_M, f64::INFINITY)
                };
                // Together they keep their arrangement.
                let is_kept = !objects.iter().any(is_broken) || self.move_together(&objects);
                is_kept.then_some(TextMeaning::Arrangement { index, objects })
            }
            TextMeaning::Exclusion { ref categories } => {
                (!categories.iter().any(|category| self.after.categories.contains(category)))
                    .then_some(meaning)
            }
            TextMeaning::Completion { complete: false } => {
                self.after.categories.is_empty().then_some(meaning)
            }
            _ => Some(meaning),
        }
    }

    /// The objects that still have a property.
    fn with_property(&self, property: &str, value: &str, objects: Vec<InstanceId>) -> Vec<InstanceId> {
        if property == "count" && objects.iter().any(|id| self.is_gone(id)) {
            return Vec::new();
        }
        let is_same = |new: &Option<String>| new.as_deref().is_none_or(|new| new == value);
        let acts = |id: &InstanceId| self.done.objects.contains(id);
        let is_lost = |id: &InstanceId| match (self.operation, property) {
            (EditOperation::Recolor { color, .. }, "color") => acts(id) && !is_same(color),
            (EditOperation::Recolor { material, .. }, "material") => acts(id) && !is_same(material),
            (EditOperation::Recolor { material: Some(_), .. }, "mass") => acts(id),
            (EditOperation::Resize { factor, .. }, _) if OF_SIZE.contains(&property) => {
                acts(id) && *factor != 1.0
            }
            (EditOperation::SetPhysics { mass_factor: Some(_), .. }, "mass") => acts(id),
            (EditOperation::Remake { .. }, _) => acts(id) && !OF_REMADE.contains(&property),
            (_, "position" | "distance") => self.has_moved(id, POSITION_TOLERANCE_M, f64::INFINITY),
            (_, "arrangement") => {
                self.has_moved(id, POSITION_TOLERANCE_M, f64::INFINITY) && !self.move_together(&objects)
            }
            (_, "orientation") => self.has_moved(id, f64::INFINITY, YAW_TOLERANCE_RAD),
            _ => false,
        };
        objects.iter().filter(|id| !self.is_gone(id) && !is_lost(id)).cloned().collect()
    }

    /// The objects of which a relation to the targets still holds, or did not change.
    fn related(
        &self,
        relation: RelationKind,
        objects: Vec<InstanceId>,
        targets: &[InstanceId],
        yielded: impl Fn(&InstanceId) -> bool,
    ) -> Vec<InstanceId> {
        if targets.iter().any(|id| self.is_gone(id)) {
            return Vec::new();
        }
        let still = |id: &InstanceId| {
            let is_touched = self.is_touched(id) || targets.iter().any(|target| self.is_touched(target));
            !self.is_gone(id) && (!is_touched || yielded(id) || self.holds(relation, id, targets))
        };
        objects.into_iter().filter(still).collect()
    }

    /// Whether a relation of an object to one of the targets holds, or to the table without targets.
    fn holds(&self, relation: RelationKind, id: &InstanceId, targets: &[InstanceId]) -> bool {
        let footprint = |id: &InstanceId| self.after.now.get(id).map(|(_, footprint)| footprint);
        let Some(object) = footprint(id) else { return false };
        let related = |target, second_target| {
            let posed = PosedRelation { kind: relation, object, target, second_target, distance_m: None };
            holds(&posed, &self.after.outline)
        };
        let others: Vec<&InstanceId> = targets.iter().filter(|target| *target != id).collect();
        match (relation, others.as_slice()) {
            (_, []) => related(None, None),
            (RelationKind::Between, [first, second, ..]) => related(footprint(first), footprint(second)),
            // Of several targets each object has one.
            (_, several) => several.iter().any(|target| related(footprint(target), None)),
        }
    }

    /// Whether an operation moved all objects alike.
    fn move_together(&self, objects: &[InstanceId]) -> bool {
        let offset = |id: &InstanceId| {
            let (before, (now, _)) = self.before.poses.get(id).zip(self.after.now.get(id))?;
            Some(now.translation_m - before.translation_m)
        };
        let offsets: Option<Vec<_>> = objects.iter().map(offset).collect();
        offsets.is_some_and(|offsets| {
            offsets.iter().all(|offset| offset.distance(offsets[0]) <= POSITION_TOLERANCE_M)
        })
    }
}
