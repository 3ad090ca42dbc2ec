//! The differences of two scenes as lines for people: lengths in millimeters, angles in degrees.

use std::fmt::Write as _;

use glam::DVec3;

use super::compare::{Change, ObjectSummary, SceneDifference};
use geometry::Friction;

/// One line for each object that was added (`+`), removed (`-`) or changed (`~`), for the table and for each metric.
pub fn lines(difference: &SceneDifference) -> String {
    if difference.is_empty() {
        return "no difference\n".to_owned();
    }
    let mut rows: Vec<(char, &str, String)> = Vec::new();
    rows.extend(difference.removed.iter().map(|object| ('-', object.name.as_str(), summary(object))));
    rows.extend(difference.added.iter().map(|object| ('+', object.name.as_str(), summary(object))));
    let changed = difference.changed.iter();
    rows.extend(changed.map(|object| ('~', object.name.as_str(), sentences(&object.changes))));
    if !difference.table.is_empty() {
        rows.push(('~', "table", sentences(&difference.table)));
    }
    for metric in &difference.metrics {
        rows.push(('~', metric.name, format!("{} -> {}", metric.before, metric.after)));
    }
    let width = rows.iter().map(|(_, name, _)| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (mark, name, what) in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{mark} {name:<width$}  {what}");
    }
    text
}

fn summary(object: &ObjectSummary) -> String {
    format!("{} ({}), {}", object.label, object.category, object.support)
}

fn sentences(changes: &[Change]) -> String {
    changes.iter().map(sentence).collect::<Vec<_>>().join("; ")
}

fn sentence(change: &Change) -> String {
    match change {
        Change::Name { before, .. } => format!("renamed from {before}"),
        Change::Label { before, after } => format!("label {before:?} -> {after:?}"),
        Change::Category { before, after } => format!("category {before} -> {after}"),
        Change::Pose { distance_m, angle_rad } => {
            format!("moved {:.2} mm, turned {:.2}°", distance_m * 1000.0, angle_rad.to_degrees())
        }
        Change::Size { before_m, after_m } => {
            format!("size {} -> {} mm", size_mm(*before_m), size_mm(*after_m))
        }
        Change::Mass { before_kg, after_kg } => format!("mass {before_kg:.4} -> {after_kg:.4} kg"),
        Change::Friction { before, after } => format!("friction {} -> {}", friction(before), friction(after)),
        Change::Restitution { before, after } => format!("restitution {before} -> {after}"),
        Change::Color { before, after } => format!("color {before} -> {after}"),
        Change::Materials { before, after } => {
            format!("materials {} -> {}", before.join("+"), after.join("+"))
        }
        Change::Mesh => "another mesh".to_owned(),
        Change::Support { before, after } => format!("{before} -> {after}"),
        Change::Model { before, after } => format!("model {before} -> {after}"),
        Change::Outline => "another outline".to_owned(),
    }
}

fn size_mm(size_m: DVec3) -> String {
    let DVec3 { x, y, z } = size_m * 1000.0;
    format!("{x:.1} x {y:.1} x {z:.1}")
}

fn friction(friction: &Friction) -> String {
    format!("{}/{}", friction.static_coefficient, friction.dynamic_coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::diff::compare::{MetricChange, ObjectChange};

    #[test]
    fn every_difference_has_a_line() {
        let spoon = ObjectSummary {
            name: "spoon_1".into(),
            label: "spoon".into(),
            category: "teaspoon".into(),
            support: "in mug_1".into(),
        };
        let changes = vec![
            Change::Name { before: "cup_1".into(), after: "mug_1".into() },
            Change::Pose { distance_m: 0.12345, angle_rad: 0.5 },
            Change::Size { before_m: DVec3::splat(0.1), after_m: DVec3::new(0.1, 0.1, 0.2) },
            Change::Support { before: "on table".into(), after: "on book_1".into() },
        ];
        let difference = SceneDifference {
            added: vec![spoon.clone()],
            removed: vec![ObjectSummary { name: "fork_1".into(), ..spoon }],
            changed: vec![ObjectChange { name: "mug_1".into(), changes }],
            table: vec![Change::Mesh],
            metrics: vec![MetricChange { name: "ss", before: 1.0, after: 0.5 }],
        };
        let expected = "\
- fork_1   spoon (teaspoon), in mug_1
+ spoon_1  spoon (teaspoon), in mug_1
~ mug_1    renamed from cup_1; moved 123.45 mm, turned 28.65°; \
size 100.0 x 100.0 x 100.0 -> 100.0 x 100.0 x 200.0 mm; on table -> on book_1
~ table    another mesh
~ ss       1 -> 0.5
";
        assert_eq!(lines(&difference), expected);
        assert_eq!(lines(&SceneDifference::default()), "no difference\n");
    }
}
