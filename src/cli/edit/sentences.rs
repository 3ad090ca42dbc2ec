//! Operations of an edit in words, for people.

use serde::Serialize;

use scene::{EditOperation, EditPlace};

/// An operation in one line.
pub fn sentence(operation: &EditOperation) -> String {
    match operation {
        EditOperation::Add { object, count, place } => {
            let count = if *count == 1 { String::new() } else { format!("{count} × ") };
            format!("add {count}{object}{}", place.as_ref().map(place_words).unwrap_or_default())
        }
        EditOperation::Remove { target, with_contents } => {
            format!("remove {target}{}", if *with_contents { " with its contents" } else { "" })
        }
        EditOperation::Replace { target, object } => format!("replace {target} by {object}"),
        EditOperation::Move { target, place } => format!("move {target}{}", place_words(place)),
        EditOperation::Rotate { target, by_rad, to_rad, facing } => {
            let by = by_rad.map(|angle_rad| format!(" by {}", degrees(angle_rad)));
            let to = to_rad.map(|angle_rad| format!(" to {}", degrees(angle_rad)));
            let toward = facing.as_ref().map(|facing| format!(" toward {facing}"));
            format!("rotate {target}{}", by.or(to).or(toward).unwrap_or_default())
        }
        EditOperation::Resize { target, factor } => format!("resize {target} by a factor of {factor}"),
        EditOperation::Recolor { target, color, material } => {
            format!("recolor {target}{}", appearance_words(color.as_deref(), material.as_deref()))
        }
        EditOperation::Relabel { target, label } => format!("relabel {target} as {label:?}"),
        EditOperation::RestyleTable { material, color } => {
            format!("restyle the table{}", appearance_words(color.as_deref(), material.as_deref()))
        }
        EditOperation::Stack { targets } => format!("stack {}", targets.join(", ")),
        EditOperation::Tidy => "tidy the table".to_owned(),
        EditOperation::Clutter { count, theme } => {
            let theme = theme.as_ref().map(|theme| format!(" of the theme {theme}"));
            format!("add {count} more objects{}", theme.unwrap_or_default())
        }
    }
}

/// " left of laptop_1, 0.05 m apart".
fn place_words(place: &EditPlace) -> String {
    let mut text = String::new();
    if let Some(relation) = place.relation {
        text.push_str(&format!(" {}", words(relation)));
    }
    let targets: Vec<&str> =
        [&place.target, &place.second_target].into_iter().flatten().map(String::as_str).collect();
    if !targets.is_empty() {
        text.push_str(&format!(" {}", targets.join(" and ")));
    }
    if let Some(distance_m) = place.distance_m {
        text.push_str(&format!(", {distance_m} m apart"));
    }
    if let Some(at) = place.position_m {
        text.push_str(&format!(" to x = {} m, y = {} m", at.x, at.y));
    }
    if let Some(yaw_rad) = place.yaw_rad {
        text.push_str(&format!(", turned to {}", degrees(yaw_rad)));
    }
    text
}

fn appearance_words(color: Option<&str>, material: Option<&str>) -> String {
    let given: Vec<&str> = [color, material].into_iter().flatten().collect();
    format!(": {}", given.join(" "))
}

fn degrees(angle_rad: f64) -> String {
    // Adding zero removes the sign of a rounded -0.
    format!("{:.1}°", (angle_rad.to_degrees() * 10.0).round() / 10.0 + 0.0)
}

/// The serialized word with spaces.
fn words(value: impl Serialize) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    value.as_str().unwrap_or_default().replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operation_has_a_sentence() {
        for (json, expected) in [
            (
                r#"{"op":"add","object":"a spoon","where":{"relation":"in","target":"mug_1"}}"#,
                "add a spoon in mug_1",
            ),
            (r#"{"op":"add","object":"a die","count":3}"#, "add 3 × a die"),
            (r#"{"op":"remove","target":"the desk lamp"}"#, "remove the desk lamp"),
            (r#"{"op":"remove","target":"bowl_1","with_contents":true}"#, "remove bowl_1 with its contents"),
            (r#"{"op":"replace","target":"mug_1","object":"a glass"}"#, "replace mug_1 by a glass"),
            (
                r#"{"op":"move","target":"mug_1","where":{"position_m":[0.1,-0.2],"yaw_rad":1.5707963267948966}}"#,
                "move mug_1 to x = 0.1 m, y = -0.2 m, turned to 90.0°",
            ),
            (
                r#"{"op":"move","target":"a","where":{"relation":"left_of","target":"b","distance_m":0.05}}"#,
                "move a left of b, 0.05 m apart",
            ),
            (
                r#"{"op":"move","target":"a","where":{"relation":"between","target":"b","second_target":"c"}}"#,
                "move a between b and c",
            ),
            (r#"{"op":"move","target":"a","where":{"relation":"at_back_left"}}"#, "move a at back left"),
            (r#"{"op":"rotate","target":"a","by_rad":-0.0001}"#, "rotate a by 0.0°"),
            (r#"{"op":"rotate","target":"a","facing":"b"}"#, "rotate a toward b"),
            (r#"{"op":"resize","target":"a","factor":1.5}"#, "resize a by a factor of 1.5"),
            (r#"{"op":"recolor","target":"a","color":"red","material":"steel"}"#, "recolor a: red steel"),
            (r#"{"op":"relabel","target":"a","label":"cup"}"#, "relabel a as \"cup\""),
            (r#"{"op":"restyle_table","material":"oak"}"#, "restyle the table: oak"),
            (r#"{"op":"stack","targets":["a","b"]}"#, "stack a, b"),
            (r#"{"op":"tidy"}"#, "tidy the table"),
            (r#"{"op":"clutter","count":2,"theme":"office"}"#, "add 2 more objects of the theme office"),
        ] {
            let operation: EditOperation = serde_json::from_str(json).expect(json);
            assert_eq!(sentence(&operation), expected, "{json}");
        }
    }
}
