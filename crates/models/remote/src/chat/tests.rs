//! Shared helpers of the tests.

use editing::EditableObject;
use glam::{DVec2, DVec3};
use scene::predicates::PosedFootprint;
use scene::{InstanceId, Supporter};
use serde_json::Value;

/// `config/default.toml`.
pub(crate) fn defaults() -> Value {
    let text = include_str!("../../../../../config/default.toml");
    serde_json::to_value(text.parse::<toml::Table>().expect("is TOML")).expect("has a JSON form")
}

/// An apple, a bowl and a fork on a table.
pub(crate) fn scene_objects() -> Vec<EditableObject> {
    let object = |(index, category): (usize, &str)| {
        let center = DVec2::new(0.2 * index as f64, 0.0);
        let corners = [(-0.04, -0.04), (0.04, -0.04), (0.04, 0.04), (-0.04, 0.04)];
        let points = corners.map(|(x, y)| center + DVec2::new(x, y));
        EditableObject {
            name: InstanceId::numbered(category, 1),
            label: category.to_owned(),
            category: category.to_owned(),
            stand_in: false,
            color: None,
            material: None,
            size_m: DVec3::splat(0.08),
            footprint: PosedFootprint::new(&points, 0.0, 0.0, 0.08),
            supporter: Supporter::TABLE,
        }
    };
    ["apple", "bowl", "fork"].into_iter().enumerate().map(object).collect()
}
