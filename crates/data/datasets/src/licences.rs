//! `LICENSES.md`: the licenses of all meshes, counted from the provenance of the objects.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::facts::SceneFacts;

/// Path of the summary in a version's folder.
pub const PATH: &str = "LICENSES.md";

/// Counts of one license.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LicenceCount {
    pub objects: usize,
    pub tables: usize,
    pub scenes: usize,
    /// Objects by the adapter that made their mesh.
    pub mesh_by: BTreeMap<String, usize>,
}

/// Counts by license.
pub fn counts<'a>(scenes: impl IntoIterator<Item = &'a SceneFacts>) -> BTreeMap<String, LicenceCount> {
    let mut counts: BTreeMap<String, LicenceCount> = BTreeMap::new();
    for scene in scenes {
        let mut of_scene = BTreeSet::from([scene.table_licence.as_str()]);
        counts.entry(scene.table_licence.clone()).or_default().tables += 1;
        for object in &scene.objects {
            of_scene.insert(&object.licence);
            let count = counts.entry(object.licence.clone()).or_default();
            count.objects += 1;
            *count.mesh_by.entry(object.mesh_by.clone()).or_default() += 1;
        }
        for licence in of_scene {
            counts.entry(licence.to_owned()).or_default().scenes += 1;
        }
    }
    counts
}

/// The text of the file.
pub fn text<'a>(name: &str, version: u32, scenes: impl IntoIterator<Item = &'a SceneFacts>) -> String {
    let counts = counts(scenes);
    let mut text = format!(
        "# Licenses of {name}, version {version}\n\n\
         Counted from the provenance of every object (`provenance.licence` and `provenance.mesh_by` in `scene.json`)\n\
         and from `licence` in the `manifest.json` of every bundle, which holds for tables and scene files.\n\n\
         | license | objects | tables | scenes |\n| --- | ---: | ---: | ---: |\n"
    );
    for (licence, count) in &counts {
        let LicenceCount { objects, tables, scenes, .. } = count;
        // A string takes all text.
        let _ = writeln!(text, "| {} | {objects} | {tables} | {scenes} |", cell(licence));
    }
    text.push_str(
        "\n## Makers of the meshes\n\n| license | mesh made by | objects |\n| --- | --- | ---: |\n",
    );
    for (licence, count) in &counts {
        for (maker, objects) in &count.mesh_by {
            let _ = writeln!(text, "| {} | {} | {objects} |", cell(licence), cell(maker));
        }
    }
    text
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let text = text.replace('\\', "\\\\").replace('|', "\\|").replace('<', "&lt;");
    if text.trim().is_empty() { "(not stated)".to_owned() } else { text }
}
