//! Objects that are dropped, and their treatment.
//!
//! An object stays in its place if the text demands one, if others need it there (it carries or contains some, or a
//! relation or a goal names it), or if people would not throw it onto a heap: furniture and appliances, and what is
//! heavy or large beside the table. Open vessels, dishes and plants fall standing, other objects on any side.

use std::collections::BTreeSet;

use crate::pipeline::place;
use crate::pipeline::resolve;
use catalog::{Affordance, category};
use physics::DropRole;
use scene::{InstanceId, Recognition, RelationKind, SceneDescription, Supporter};

/// Heavier objects stay in their places, kilograms.
const MAX_MASS_KG: f64 = 3.0;

/// Taller objects stay in their places, meters.
const MAX_HEIGHT_M: f64 = 0.38;

/// So do those whose longest side is a larger share of the table's shorter side.
const MAX_SIDE_SHARE: f64 = 0.5;

/// Groups of the catalog whose objects fall standing, as containers do.
const STANDING_GROUPS: [&str; 6] = ["vessel", "dish", "cookware", "plant", "light", "tableware"];

/// Groups of the catalog whose objects stay in their places.
const KEPT_GROUPS: [&str; 4] = ["appliance", "furniture", "screen", "rack"];

/// The role of each object, in order.
pub(super) fn of_objects(
    recognition: &Recognition,
    stated: Option<&SceneDescription>,
    layout: &place::Output,
    resolved: &resolve::Output,
) -> Vec<DropRole> {
    let demanded = stated.map(demanded).unwrap_or_default();
    let table_side_m = layout.table.size_m.truncate().min_element();
    let objects = recognition.objects.iter().zip(&layout.instances).zip(&resolved.bodies[1..]).enumerate();
    objects
        .map(|(index, ((object, placed), body))| {
            let supports = &resolved.supports;
            let is_alone = supports.supporter(index) == Supporter::TABLE
                && supports.children(Some(index)).next().is_none();
            let size_m = placed.size_m * body.scale;
            let is_large = body.physical.mass.mass_kg > MAX_MASS_KG
                || size_m.z > MAX_HEIGHT_M
                || size_m.max_element() > MAX_SIDE_SHARE * table_side_m;
            if !is_alone || is_large || demanded.contains(&object.id) {
                return DropRole::Kept;
            }
            of_category(&object.category)
        })
        .collect()
}

fn of_category(name: &str) -> DropRole {
    let Some(kind) = category(name) else { return DropRole::AnySide };
    if KEPT_GROUPS.contains(&kind.group.as_str()) {
        DropRole::Kept
    } else if kind.affords(Affordance::Container) || STANDING_GROUPS.contains(&kind.group.as_str()) {
        DropRole::Standing
    } else {
        DropRole::AnySide
    }
}

/// Objects for which a text demands a place or a posture, and those that such demands refer to.
fn demanded(stated: &SceneDescription) -> BTreeSet<InstanceId> {
    let mut names = BTreeSet::new();
    for object in &stated.objects {
        // On the table is where clutter is, too.
        let places = object
            .relations
            .iter()
            .filter(|relation| relation.kind != RelationKind::On || relation.target.is_some());
        for relation in places {
            names.insert(object.id.clone());
            names.extend(relation.target.iter().chain(&relation.second_target).cloned());
        }
        if object.yaw_rad.is_some() || object.position_m.is_some() || !object.pose.is_upright() {
            names.insert(object.id.clone());
        }
    }
    for arrangement in &stated.arrangements {
        names.extend(arrangement.objects.iter().chain(&arrangement.center).cloned());
    }
    for predicate in stated.goal.iter().flat_map(|goal| &goal.predicates) {
        let others = predicate.target.iter().chain(&predicate.second_target);
        names.extend(std::iter::once(&predicate.object).chain(others).cloned());
    }
    names
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn objects_with_demands_and_their_targets_are_demanded() {
        let object = |id: &str, more: serde_json::Value| {
            let mut object = json!({
                "id": id, "label": id, "category": "mug", "size_m": [0.1, 0.1, 0.1], "seed": 1, "requested": true,
                "relations": [],
            });
            let members = object.as_object_mut().expect("an object");
            members.extend(more.as_object().expect("an object").clone());
            object
        };
        let stated: SceneDescription = serde_json::from_value(json!({
            "theme": "office_desk", "family": "office_living", "prose": "",
            "table": { "shape": "square", "size_m": [1.0, 1.0, 0.03], "material": null, "color": null },
            "objects": [
                object("mug_1", json!({ "relations": [{ "kind": "next_to", "target": "plate_1" }] })),
                object("plate_1", json!({})),
                object("spoon_1", json!({})),
                object("pen_1", json!({ "relations": [{ "kind": "on" }] })),
                object("book_1", json!({ "yaw_rad": 0.3 })),
                object("cup_1", json!({ "pose": "upside_down" })),
                object("coin_1", json!({})),
                object("coin_2", json!({})),
                object("ball_1", json!({})),
            ],
            "arrangements": [{ "kind": { "arrangement": "row" }, "objects": ["coin_1", "coin_2"] }],
            "goal": { "instruction": "lift the ball", "predicates": [{ "predicate": "lifted", "object": "ball_1" }] },
        }))
        .expect("a description");
        let found: Vec<String> = demanded(&stated).iter().map(ToString::to_string).collect();
        let expected = ["ball_1", "book_1", "coin_1", "coin_2", "cup_1", "mug_1", "plate_1"];
        assert_eq!(found, expected);
    }

    #[test]
    fn roles_follow_the_group_and_the_affordances_of_the_category() {
        for (name, role) in [
            ("mug", DropRole::Standing),
            ("bowl", DropRole::Standing),
            ("plate", DropRole::Standing),
            ("book", DropRole::AnySide),
            ("pen", DropRole::AnySide),
            ("apple", DropRole::AnySide),
            ("toaster", DropRole::Kept),
            ("monitor", DropRole::Kept),
            ("no such category", DropRole::AnySide),
        ] {
            assert_eq!(of_category(name), role, "{name}");
        }
    }
}
