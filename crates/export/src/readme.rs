//! `README.md` of a bundle: its contents and how to load it in each simulator.

use scene::Scene;

use super::{Body, BundleFile, UsdForm, usd};

/// The text, with the scene's own names and paths in the examples.
pub fn write(scene: &Scene, bodies: &[Body], usd_form: UsdForm) -> BundleFile {
    let example = bodies.iter().find(|body| body.movable).or(bodies.first());
    let example = example.map_or("table", |body| &body.name);
    let rows: String = bodies
        .iter()
        .map(|body| format!("| `{}` | {} | {:.3} |\n", body.name, cell(&body.label), body.mass.mass_kg))
        .collect();
    let text = TEMPLATE
        .replace("{id}", &scene.id)
        .replace("{example}", example)
        .replace("{height}", &format!("{:.3}", scene.table.height_m))
        .replace("{usd_stage}", usd::stage_path(usd_form))
        .replace("{usd_prop}", &usd::prop_path(usd_form, "<name>"))
        .replace("{rows}", &rows);
    BundleFile::text("README.md", text, "readme", "text/markdown")
}

/// A label escaped for a cell of a Markdown table.
fn cell(label: &str) -> String {
    let mut text = String::new();
    for c in label.chars() {
        match c {
            '\n' | '\r' | '\t' => text.push(' '),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '&' => text.push_str("&amp;"),
            '|' | '`' | '*' | '_' | '[' | ']' | '\\' | '{' | '}' | '#' | '!' => {
                text.push('\\');
                text.push(c);
            }
            c if c.is_control() => text.push('\u{fffd}'),
            c => text.push(c),
        }
    }
    text
}

const TEMPLATE: &str = include_str!("readme_template.md");
