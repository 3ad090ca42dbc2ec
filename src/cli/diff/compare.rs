//! The differences of two finished scenes: objects, places, properties, the table and the metrics. Pure.
//!
//! Objects are the same by name; an object that kept its category, size and place under another name is renamed. Values
//! are equal within a billionth, far below what any operation changes and above the rounding of a sum.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use geometry::{Friction, Pose};
use scene::instance::{Support, SupportRelation};
use scene::table::Table;
use scene::{Instance, Scene};

/// Largest relative difference of equal numbers; also meters and radians.
const TOLERANCE: f64 = 1e-9;

/// A scene and the appearance of its bodies, by name; the table is one of them.
pub struct SceneContents {
    pub scene: Scene,
    pub appearances: BTreeMap<String, Appearance>,
}

/// Appearance of a body by its visual mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Mean color of its surface, sRGB: red, green, blue.
    pub color: [u8; 3],
    /// Names of its materials.
    pub materials: Vec<String>,
    /// Digest of its triangles as indices, which no scale and no color changes.
    pub triangles: String,
}

/// Differences between two scenes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SceneDifference {
    pub added: Vec<ObjectSummary>,
    pub removed: Vec<ObjectSummary>,
    /// In the order of the second scene.
    pub changed: Vec<ObjectChange>,
    pub table: Vec<Change>,
    pub metrics: Vec<MetricChange>,
}

/// An object that only one of the scenes has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectSummary {
    pub name: String,
    pub label: String,
    pub category: String,
    /// `on table`, `in mug_1`.
    pub support: String,
}

/// An object of both scenes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectChange {
    /// In the second scene.
    pub name: String,
    pub changes: Vec<Change>,
}

/// A property that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "property", rename_all = "snake_case")]
pub enum Change {
    Name {
        before: String,
        after: String,
    },
    Label {
        before: String,
        after: String,
    },
    Category {
        before: String,
        after: String,
    },
    /// Of the origin, and of the whole rotation.
    Pose {
        distance_m: f64,
        angle_rad: f64,
    },
    Size {
        before_m: DVec3,
        after_m: DVec3,
    },
    Mass {
        before_kg: f64,
        after_kg: f64,
    },
    Friction {
        before: Friction,
        after: Friction,
    },
    Restitution {
        before: f64,
        after: f64,
    },
    /// `#rrggbb`.
    Color {
        before: String,
        after: String,
    },
    Materials {
        before: Vec<String>,
        after: Vec<String>,
    },
    /// Other triangles.
    Mesh,
    Support {
        before: String,
        after: String,
    },
    /// Of the table.
    Model {
        before: String,
        after: String,
    },
    /// Of the table.
    Outline,
}

/// A metric that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MetricChange {
    pub name: &'static str,
    pub before: f64,
    pub after: f64,
}

impl SceneDifference {
    /// Whether the scenes are equal.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Differences from `before` to `after`.
pub fn compare(before: &SceneContents, after: &SceneContents) -> SceneDifference {
    let (old, new) = (&before.scene.instances, &after.scene.instances);
    let pairs = pairs(old, new);
    let is_paired = |index: usize| pairs.iter().any(|pair| pair.0 == index);
    let removed = old.iter().enumerate().filter(|(index, _)| !is_paired(*index));
    let added = new.iter().enumerate().filter(|(index, _)| pairs.iter().all(|pair| pair.1 != *index));
    let changed = pairs.iter().filter_map(|&(i, j)| {
        let changes = object_changes(before, &old[i], after, &new[j]);
        (!changes.is_empty()).then(|| ObjectChange { name: new[j].name.to_string(), changes })
    });
    SceneDifference {
        added: added.map(|(_, object)| summary(object)).collect(),
        removed: removed.map(|(_, object)| summary(object)).collect(),
        changed: changed.collect(),
        table: table_changes(before, after),
        metrics: metric_changes(&before.scene, &after.scene),
    }
}

/// Indices of the same object in both lists, in the order of the second.
fn pairs(old: &[Instance], new: &[Instance]) -> Vec<(usize, usize)> {
    let by_name = |object: &Instance| old.iter().position(|other| other.name == object.name);
    let mut partners: Vec<Option<usize>> = new.iter().map(by_name).collect();
    for (index, object) in new.iter().enumerate() {
        if partners[index].is_none() {
            let free = |i: &usize| !partners.contains(&Some(*i)) && is_renamed(&old[*i], object);
            partners[index] = (0..old.len()).find(free);
        }
    }
    partners.into_iter().enumerate().filter_map(|(j, i)| Some((i?, j))).collect()
}

fn is_renamed(old: &Instance, new: &Instance) -> bool {
    let (distance_m, angle_rad) = movement(&old.world_from_object, &new.world_from_object);
    old.category == new.category
        && !differ_in_size(old.size_m, new.size_m)
        && distance_m <= TOLERANCE
        && angle_rad <= TOLERANCE
}

fn summary(object: &Instance) -> ObjectSummary {
    ObjectSummary {
        name: object.name.to_string(),
        label: object.label.clone(),
        category: object.category.clone(),
        support: support_words(&object.support),
    }
}

fn support_words(support: &Support) -> String {
    let relation = match support.relation {
        SupportRelation::On => "on",
        SupportRelation::In => "in",
    };
    format!("{relation} {}", support.parent)
}

/// Distance of the origins in meters, and the angle of the rotation between both in radians.
fn movement(before: &Pose, after: &Pose) -> (f64, f64) {
    let turn = before.rotation.conjugate() * after.rotation;
    // Accurate for small angles, where the arc cosine of w is not.
    let angle_rad = 2.0 * turn.xyz().length().atan2(turn.w.abs());
    (before.translation_m.distance(after.translation_m), angle_rad)
}

fn object_changes(
    before: &SceneContents,
    old: &Instance,
    after: &SceneContents,
    new: &Instance,
) -> Vec<Change> {
    let mut changes = Vec::new();
    let (before_name, after_name) = (old.name.to_string(), new.name.to_string());
    let appearances = (before.appearances.get(&before_name), after.appearances.get(&after_name));
    if before_name != after_name {
        changes.push(Change::Name { before: before_name, after: after_name });
    }
    if old.category != new.category {
        changes.push(Change::Category { before: old.category.clone(), after: new.category.clone() });
    }
    let (distance_m, angle_rad) = movement(&old.world_from_object, &new.world_from_object);
    if distance_m > TOLERANCE || angle_rad > TOLERANCE {
        changes.push(Change::Pose { distance_m, angle_rad });
    }
    let (before, after) = (support_words(&old.support), support_words(&new.support));
    if before != after {
        changes.push(Change::Support { before, after });
    }
    changes.extend(body_changes(&Body::of(old), &Body::of(new), appearances));
    changes
}

/// Properties that objects and the table have in common.
struct Body<'a> {
    label: &'a str,
    size_m: DVec3,
    mass_kg: f64,
    friction: Friction,
    restitution: f64,
}

impl<'a> Body<'a> {
    fn of(object: &'a Instance) -> Self {
        let Instance { label, size_m, mass, friction, restitution, .. } = object;
        let (friction, restitution) = (*friction, *restitution);
        Self { label, size_m: *size_m, mass_kg: mass.mass_kg, friction, restitution }
    }

    fn of_table(table: &'a Table) -> Self {
        let Table { label, size_m, mass, friction, restitution, .. } = table;
        let (friction, restitution) = (*friction, *restitution);
        Self { label, size_m: *size_m, mass_kg: mass.mass_kg, friction, restitution }
    }
}

fn body_changes(
    old: &Body<'_>,
    new: &Body<'_>,
    appearances: (Option<&Appearance>, Option<&Appearance>),
) -> Vec<Change> {
    let mut changes = Vec::new();
    if old.label != new.label {
        changes.push(Change::Label { before: old.label.to_owned(), after: new.label.to_owned() });
    }
    if differ_in_size(old.size_m, new.size_m) {
        changes.push(Change::Size { before_m: old.size_m, after_m: new.size_m });
    }
    if differ(old.mass_kg, new.mass_kg) {
        changes.push(Change::Mass { before_kg: old.mass_kg, after_kg: new.mass_kg });
    }
    if differ(old.friction.static_coefficient, new.friction.static_coefficient)
        || differ(old.friction.dynamic_coefficient, new.friction.dynamic_coefficient)
    {
        changes.push(Change::Friction { before: old.friction, after: new.friction });
    }
    if differ(old.restitution, new.restitution) {
        changes.push(Change::Restitution { before: old.restitution, after: new.restitution });
    }
    if let (Some(old), Some(new)) = appearances {
        if old.color != new.color {
            changes.push(Change::Color { before: hex(old.color), after: hex(new.color) });
        }
        if old.materials != new.materials {
            changes.push(Change::Materials { before: old.materials.clone(), after: new.materials.clone() });
        }
        if old.triangles != new.triangles {
            changes.push(Change::Mesh);
        }
    }
    changes
}

fn table_changes(before: &SceneContents, after: &SceneContents) -> Vec<Change> {
    let (old, new) = (&before.scene.table, &after.scene.table);
    let appearances = (before.appearances.get(&old.name), after.appearances.get(&new.name));
    let mut changes = body_changes(&Body::of_table(old), &Body::of_table(new), appearances);
    if old.model != new.model {
        changes.push(Change::Model { before: old.model.clone(), after: new.model.clone() });
    }
    let (old_corners, new_corners) = (old.outline_m.corners(), new.outline_m.corners());
    let moved = old_corners.iter().zip(new_corners).any(|(a, b)| a.distance(*b) > TOLERANCE);
    if old.shape != new.shape || old_corners.len() != new_corners.len() || moved {
        changes.push(Change::Outline);
    }
    changes
}

fn metric_changes(before: &Scene, after: &Scene) -> Vec<MetricChange> {
    let (old, new) = (&before.metrics, &after.metrics);
    let metrics = [
        ("col_o", old.col_o, new.col_o),
        ("col_s", old.col_s, new.col_s),
        ("ss", old.ss, new.ss),
        ("dss_aligned", old.dss_aligned, new.dss_aligned),
        ("dss_shipped", old.dss_shipped, new.dss_shipped),
    ];
    let changed = metrics.into_iter().filter(|(_, before, after)| differ(*before, *after));
    changed.map(|(name, before, after)| MetricChange { name, before, after }).collect()
}

fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > TOLERANCE * a.abs().max(b.abs()).max(1.0)
}

fn differ_in_size(a: DVec3, b: DVec3) -> bool {
    (0..3).any(|axis| differ(a[axis], b[axis]))
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests;
