//! What reading every format back showed, beside what is tolerated.

use crate::parity::FormatParity;
use crate::report::Report;
use crate::report::html::{Cell, Html};
use crate::report::numbers::at_most;

pub fn write(page: &mut Html, report: &Report<'_>) {
    let parity = report.parity;
    let formats = [parity.usd, parity.urdf, parity.mjcf, parity.sdf];
    let head = ["Largest difference from the scene", "USD", "URDF", "MJCF", "SDF", "GLB", "Tolerance"];
    let equal = |what: &str, glb: bool| {
        let mut row = vec![Cell::Words(what.to_owned())];
        row.extend((0..4).map(|_| Cell::Number("equal".into())));
        row.extend([Cell::Number(if glb { "equal" } else { "–" }.into()), Cell::Number("equal".into())]);
        row
    };
    let count = |what: &str, of: fn(&FormatParity) -> usize, glb: String| {
        let mut row = vec![Cell::Words(what.to_owned())];
        row.extend(formats.iter().map(|format| Cell::Number(of(format).to_string())));
        row.extend([Cell::Number(glb), Cell::Number("equal".into())]);
        row
    };
    let difference = |what: &str, of: fn(&FormatParity) -> f64, glb: Option<f64>, tolerance: f64| {
        let mut row = vec![Cell::Words(what.to_owned())];
        row.extend(formats.iter().map(|format| Cell::Number(at_most(of(format)))));
        row.push(Cell::Number(glb.map_or("–".to_owned(), at_most)));
        row.push(Cell::Number(format!("{tolerance:e}")));
        row
    };
    // Not every format has a place for it.
    let told = |what: &str, of: fn(&FormatParity) -> Option<f64>, tolerance: f64| {
        let mut row = vec![Cell::Words(what.to_owned())];
        let cell = |difference: Option<f64>| Cell::Number(difference.map_or("–".to_owned(), at_most));
        row.extend(formats.iter().map(|format| cell(of(format))));
        row.extend([cell(None), Cell::Number(format!("{tolerance:e}"))]);
        row
    };
    let (most, glb) = (&parity.tolerances, &parity.glb);
    let rows = vec![
        equal("Names, labels, and what is fixed", true),
        count("Bodies", |format| format.bodies, glb.meshes.to_string()),
        count("Hulls", |format| format.hulls, "–".into()),
        difference("Mass (relative)", |format| format.mass_relative, None, most.mass_relative),
        difference("Center of mass (m)", |format| format.center_of_mass_m, None, most.center_of_mass_m),
        difference("Inertia (relative)", |format| format.inertia_relative, None, most.inertia_relative),
        difference("Dynamic friction", |format| format.dynamic_friction, None, most.dynamic_friction),
        told("Static friction", |format| format.static_friction, most.static_friction),
        told("Restitution", |format| format.restitution, most.restitution),
        told("Rolling friction (m)", |format| format.rolling_friction_m, most.rolling_friction_m),
        told("Torsional friction (m)", |format| format.torsional_friction_m, most.torsional_friction_m),
        difference(
            "Position (m)",
            |format| format.translation_m,
            Some(glb.translation_m),
            most.translation_m,
        ),
        difference("Rotation (rad)", |format| format.rotation_rad, Some(glb.rotation_rad), most.rotation_rad),
        difference("Corners of hulls (m)", |format| format.hull_corner_m, None, most.hull_corner_m),
        difference(
            "Volume of hulls (relative)",
            |format| format.hull_volume_relative,
            None,
            most.hull_volume_relative,
        ),
        difference(
            "Vertices of the visual meshes (m)",
            |format| format.vertex_m,
            Some(glb.vertex_m),
            most.vertex_m,
        ),
    ];
    page.table("", &head, rows);
    page.leaf(
        "p",
        &[("class", "note")],
        "Each file is read by a reader of its own that shares nothing with the writer. Differences are rounded up to \
         a power of ten. Formats with one friction number carry the dynamic one.",
    );
}
