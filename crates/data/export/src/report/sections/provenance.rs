//! Request, adapters and every setting: sufficient to reproduce the bundle.

use markup::html::{Cell, Html};
use serde_json::Value;

use crate::report::Report;

pub fn write(page: &mut Html, report: &Report<'_>) {
    let made_with = &report.certificate.made_with;
    let facts = [
        ("Program", format!("tabletopgen {}", made_with.version)),
        ("Scene", report.scene.id.clone()),
        ("Seed", report.scene.seed.to_string()),
        ("Rounds of resolve", report.certificate.resolve.rounds.to_string()),
    ];
    let rows = facts.into_iter().map(|(what, value)| vec![Cell::Words(what.into()), Cell::Words(value)]);
    page.table("facts", &["", ""], rows.collect());

    page.leaf("h3", &[], "Adapters");
    let rows = made_with.adapters.iter().map(|used| {
        [&used.port, &used.name, &used.model].map(|word| Cell::Words(word.clone())).into_iter().collect()
    });
    page.table("", &["Port", "Adapter", "Model or version"], rows.collect());

    page.leaf("h3", &[], "Meshes");
    let rows = report.scene.instances.iter().map(|instance| {
        let provenance = &instance.provenance;
        vec![
            Cell::Body(instance.name.to_string()),
            Cell::Words(provenance.mesh_by.clone()),
            Cell::Words(provenance.licence.clone()),
            Cell::UserText(provenance.notes.join("; ")),
        ]
    });
    page.table("", &["Object", "Made by", "Licence", "Notes"], rows.collect());

    page.leaf("h3", &[], "Settings");
    let mut settings = Vec::new();
    flatten("", &made_with.settings, &mut settings);
    page.open("dl", &[("class", "settings")]);
    for (key, value) in settings {
        page.open("div", &[]);
        page.leaf("dt", &[], &key);
        page.leaf("dd", &[], &value);
        page.close();
    }
    page.close();
}

/// `section.key` and value of every setting, in order.
fn flatten(prefix: &str, value: &Value, found: &mut Vec<(String, String)>) {
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let dot = if prefix.is_empty() { "" } else { "." };
                flatten(&format!("{prefix}{dot}{key}"), value, found);
            }
        }
        Value::String(text) => found.push((prefix.to_owned(), text.clone())),
        Value::Null if prefix.is_empty() => {}
        value => found.push((prefix.to_owned(), value.to_string())),
    }
}
