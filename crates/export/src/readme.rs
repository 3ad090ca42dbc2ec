//! `README.md` of a bundle: its contents and how to load it in each simulator.

use scene::Scene;

use super::{Body, BundleFile, UsdForm, usd};

/// The text, with the scene's own names and paths in the examples.
pub fn write(scene: &Scene, bodies: &[Body], usd_form: UsdForm) -> BundleFile {
    let example = bodies.iter().find(|body| body.movable).or(bodies.first());
    let example = example.map_or("table", |body| &body.name);
    let rows: String = bodies
        .iter()
        .map(|body| {
            let mark = if body.stand_in { " (stand-in)" } else { "" };
            format!("| `{}` | {}{mark} | {:.3} |\n", body.name, cell(&body.label), body.mass.mass_kg)
        })
        .collect();
    let stand_ins = if bodies.iter().any(|body| body.stand_in) { STAND_INS } else { "" };
    let text = TEMPLATE
        .replace("{id}", &scene.id)
        .replace("{example}", example)
        .replace("{height}", &format!("{:.3}", scene.table.height_m))
        .replace("{usd_stage}", usd::stage_path(usd_form))
        .replace("{usd_prop}", &usd::prop_path(usd_form, "<name>"))
        .replace("{stand_ins}", stand_ins)
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

/// The paragraph of a bundle with stand-ins.
const STAND_INS: &str = "
A stand-in is a plain shape of the size of an object that the catalog does not have; the label says which object. Every
format marks it: `stand_in` in `scene.json`, among the extras of glTF nodes and in `tabletopgen:label` elements of URDF,
the attribute `tabletopgen:stand_in` of USD prims and of SDF models, and `stand_in_<name>` texts in MJCF.
";

const TEMPLATE: &str = include_str!("readme_template.md");
