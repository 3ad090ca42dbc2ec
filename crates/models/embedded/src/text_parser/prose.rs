//! The description as English text.

use std::fmt::Write;

use scene::{ObjectSpec, RelationKind, SceneDescription};

/// One paragraph: the table, the objects, and their relations.
pub(super) fn write(description: &SceneDescription) -> String {
    let mut text = format!("A {} scene. ", description.theme.replace('_', " "));
    text.push_str(&table_sentence(description));
    let groups = grouped(&description.objects);
    let names: Vec<String> = groups.iter().map(|(label, count)| counted(label, *count)).collect();
    let _ = write!(text, "On it: {}.", joined(&names));
    for object in &description.objects {
        for relation in &object.relations {
            let name = display_name(object, description);
            let phrase = match (&relation.target, place(relation.kind)) {
                (_, Some(place)) => format!(" The {name} stands {place}."),
                (Some(target), None) => {
                    let target = description.objects.iter().find(|other| other.id == *target);
                    let Some(target) = target else { continue };
                    format!(
                        " The {name} is {} the {}.",
                        preposition(relation.kind),
                        display_name(target, description)
                    )
                }
                (None, None) => continue,
            };
            text.push_str(&phrase);
        }
    }
    if !description.unrecognized.is_empty() {
        let parts: Vec<&str> = description.unrecognized.iter().map(|part| part.span.text.as_str()).collect();
        let _ = write!(text, " Without effect: {}.", parts.join(", "));
    }
    if let Some(goal) = &description.goal {
        let _ = write!(text, " Goal: {}.", goal.instruction);
    }
    text
}

fn table_sentence(description: &SceneDescription) -> String {
    let table = &description.table;
    let mut words = Vec::new();
    words.extend(table.color.clone());
    words.extend(table.material.clone());
    let model = table.model.as_deref().unwrap_or("table").replace('_', " ");
    words.push(model);
    let size = table.size_m.map_or(String::new(), |size| {
        format!(", {:.2} m wide, {:.2} m deep and {:.2} m high", size.x, size.y, size.z)
    });
    let words = words.join(" ");
    let article = if words.starts_with(['a', 'e', 'i', 'o', 'u']) { "An" } else { "A" };
    format!("{article} {words}{size}. ")
}

/// Labels with their counts, in order of appearance.
fn grouped(objects: &[ObjectSpec]) -> Vec<(String, usize)> {
    let mut groups: Vec<(String, usize)> = Vec::new();
    for object in objects {
        match groups.iter_mut().find(|(label, _)| *label == object.label) {
            Some((_, count)) => *count += 1,
            None => groups.push((object.label.clone(), 1)),
        }
    }
    groups
}

fn counted(label: &str, count: usize) -> String {
    let words = super::vocabulary::vocabulary();
    match count {
        1 if label.starts_with(['a', 'e', 'i', 'o', 'u']) => format!("an {label}"),
        1 => format!("a {label}"),
        _ => format!("{count} {}", words.plural_of(label)),
    }
}

/// The label, with its number if there are several.
fn display_name(object: &ObjectSpec, description: &SceneDescription) -> String {
    let alike: Vec<&ObjectSpec> =
        description.objects.iter().filter(|other| other.label == object.label).collect();
    match alike.iter().position(|other| other.id == object.id) {
        Some(k) if alike.len() > 1 => format!("{} {}", object.label, k + 1),
        _ => object.label.clone(),
    }
}

fn joined(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

fn place(kind: RelationKind) -> Option<&'static str> {
    Some(match kind {
        RelationKind::AtCenter => "in the center",
        RelationKind::AtBack => "at the back",
        RelationKind::AtFront => "at the front",
        RelationKind::AtLeft => "on the left side",
        RelationKind::AtRight => "on the right side",
        RelationKind::AtBackLeft => "at the back left",
        RelationKind::AtBackRight => "at the back right",
        RelationKind::AtFrontLeft => "at the front left",
        RelationKind::AtFrontRight => "at the front right",
        RelationKind::FromLeftEdge => "near the left edge",
        RelationKind::FromRightEdge => "near the right edge",
        RelationKind::FromFrontEdge => "near the front edge",
        RelationKind::FromBackEdge => "near the back edge",
        _ => return None,
    })
}

fn preposition(kind: RelationKind) -> &'static str {
    match kind {
        RelationKind::On => "on",
        RelationKind::In => "in",
        RelationKind::LeftOf => "to the left of",
        RelationKind::RightOf => "to the right of",
        RelationKind::InFrontOf => "in front of",
        RelationKind::Behind => "behind",
        RelationKind::NextTo => "next to",
        RelationKind::Around => "one of those around",
        RelationKind::StackedOn => "stacked on",
        RelationKind::Between => "between its neighbors and",
        RelationKind::Facing => "turned to",
        RelationKind::ParallelTo => "parallel to",
        _ => "at",
    }
}
