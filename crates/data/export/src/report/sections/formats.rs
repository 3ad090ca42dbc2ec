//! Table of the round trip: differences of every format, and the tolerances.

use crate::report::Report;
use crate::report::numbers::at_most;
use crate::round_trip::FormatDeviation;
use markup::html::{Cell, Html};

pub fn write(page: &mut Html, report: &Report<'_>) {
    let parity = report.round_trip;
    let formats = [parity.usd, parity.urdf, parity.mjcf, parity.sdf];
    let head = ["Largest difference from the scene", "USD", "URDF", "MJCF", "SDF", "GLB", "Tolerance"];
    let equal = |what: &str, glb: bool| {
        let mut row = vec![Cell::Words(what.to_owned())];
        row.extend((0..4).map(|_| Cell::Number("equal".into())));
        row.extend([Cell::Number(if glb { "equal" } else { "–" }.into()), Cell::Number("equal".into())]);
        row
    };
    let count = |what: &str, of: fn(&FormatDeviation) -> usize, glb: String| {
        let mut row = vec![Cell::Words(what.to_owned())];
        row.extend(formats.iter().map(|format| Cell::Number(of(format).to_string())));
        row.extend([Cell::Number(glb), Cell::Number("equal".into())]);
        row
    };
    let difference = |what: &str, of: fn(&FormatDeviation) -> f64, glb: Option<f64>, tolerance: f64| {
        let mut row = vec![Cell::Words(what.to_owned())];
        row.extend(formats.iter().map(|format| Cell::Number(at_most(of(format)))));
        row.push(Cell::Number(glb.map_or("–".to_owned(), at_most)));
        row.push(Cell::Number(format!("{tolerance:e}")));
        row
    };
    // Not every format has a place for these parameters.
    let optional_difference = |what: &str, of: fn(&FormatDeviation) -> Option<f64>, tolerance: f64| {
        let mut row = vec![Cell::Words(what.to_owned())];
        let cell = |difference: Option<f64>| Cell::Number(difference.map_or("–".to_owned(), at_most));
        row.extend(formats.iter().map(|format| cell(of(format))));
        row.extend([cell(None), Cell::Number(format!("{tolerance:e}"))]);
        row
    };
    let (limits, glb) = (&parity.tolerances, &parity.glb);
    let rows = vec![
        equal("Names, labels, and what is fixed", true),
        count("Bodies", |format| format.bodies, glb.meshes.to_string()),
        count("Hulls", |format| format.hulls, "–".into()),
        difference("Mass (relative)", |format| format.mass_relative, None, limits.mass_relative),
        difference("Center of mass (m)", |format| format.center_of_mass_m, None, limits.center_of_mass_m),
        difference("Inertia (relative)", |format| format.inertia_relative, None, limits.inertia_relative),
        difference("Dynamic friction", |format| format.dynamic_friction, None, limits.dynamic_friction),
        optional_difference("Static friction", |format| format.static_friction, limits.static_friction),
        optional_difference("Restitution", |format| format.restitution, limits.restitution),
        optional_difference(
            "Rolling friction (m)",
            |format| format.rolling_friction_m,
            limits.rolling_friction_m,
        ),
        optional_difference(
            "Torsional friction (m)",
            |format| format.torsional_friction_m,
            limits.torsional_friction_m,
        ),
        difference(
            "Position (m)",
            |format| format.translation_m,
            Some(glb.translation_m),
            limits.translation_m,
        ),
        difference(
            "Rotation (rad)",
            |format| format.rotation_rad,
            Some(glb.rotation_rad),
            limits.rotation_rad,
        ),
        difference("Corners of hulls (m)", |format| format.hull_corner_m, None, limits.hull_corner_m),
        difference(
            "Volume of hulls (relative)",
            |format| format.hull_volume_relative,
            None,
            limits.hull_volume_relative,
        ),
        difference(
            "Vertices of the visual meshes (m)",
            |format| format.vertex_m,
            Some(glb.vertex_m),
            limits.vertex_m,
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
